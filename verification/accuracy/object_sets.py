"""Which objects are known, by how many references, and which are shown."""

import re
from collections.abc import Sequence
from dataclasses import dataclass

NUMBERED = re.compile(r"(.*?\D)[-_ ]?(\d+)")
"""An object's name that has a category: a word and the object's number in it."""


@dataclass(frozen=True, slots=True)
class Fold:
    """One library and what is shown to it.

    Attributes
    ----------
    known : dict of str to str
        The label of each known object.
    tested : dict of str to str
        The label that is right for each object that is shown; an object that is unknown has its own name.
    """

    known: dict[str, str]
    tested: dict[str, str]


@dataclass(frozen=True, slots=True)
class ObjectSet:
    """Several folds that show each object once.

    Attributes
    ----------
    name : str
    references : int
        Of each known object.
    folds : tuple of Fold
    """

    name: str
    references: int
    folds: tuple[Fold, ...]


def groups(objects: Sequence[str]) -> list[list[str]]:
    """One object of each category, then the next of each; all objects where not all names tell a category.

    Every group has an object of every category: what a category has beyond the smallest one is left out.
    """
    found: dict[str, list[tuple[int, str]]] = {}
    for name in objects:
        match = NUMBERED.fullmatch(name)
        if match is None:
            return [list(objects)]
        found.setdefault(match[1], []).append((int(match[2]), name))
    if len(found) < 2:
        return [list(objects)]
    ranked = [[name for _, name in sorted(each)] for each in found.values()]
    return [list(each) for each in zip(*ranked, strict=False)]


def category(name: str) -> str:
    """Return what the name says of the category; the name where it says nothing."""
    match = NUMBERED.fullmatch(name)
    return name if match is None else match[1]


def object_sets(objects: Sequence[str], references: int) -> list[ObjectSet]:
    """Choose the sets in which objects, and where names tell them categories, are recognised."""
    parts, found = groups(objects), list[ObjectSet]()
    everyone = {name: name for part in parts for name in part}
    counts = dict.fromkeys((1, references))
    if len(parts) > 1:
        own = tuple(Fold({name: name for name in part}, {name: name for name in part}) for part in parts)
        found += [ObjectSet(f"{len(parts[0])} objects x {_told(count)}", count, own) for count in counts]
    found += [
        ObjectSet(f"{len(everyone)} objects x {_told(count)}", count, (Fold(everyone, everyone),))
        for count in counts
    ]
    if len(parts) > 1:
        labels = {name: category(name) for name in everyone}
        for many in dict.fromkeys((1, len(parts) - 1)):
            folds = []
            for k, part in enumerate(parts):
                known = [name for step in range(1, many + 1) for name in parts[(k + step) % len(parts)]]
                folds.append(Fold({n: labels[n] for n in known}, {n: labels[n] for n in part}))
            name = f"categories, {many} other object{'s' * (many > 1)} x {_told(references)}"
            found.append(ObjectSet(name, references, tuple(folds)))
    return found


def _told(references: int) -> str:
    return f"{references} reference{'s' * (references > 1)}"


def unknown_sets(objects: Sequence[str], references: int) -> list[ObjectSet]:
    """Choose the sets in which half of the objects are unknown; either half is, in one of two folds."""
    parts = groups(objects)
    everyone = [name for part in parts for name in part]
    halves = {"unknown objects": set(everyone[::2])}
    if len(parts) > 1:
        kinds = sorted({category(name) for name in everyone})
        halves = {
            "unknown objects of known categories": {name for part in parts[::2] for name in part},
            "unknown objects of unknown categories": {n for n in everyone if category(n) in kinds[::2]},
        }
    found = []
    for name, half in halves.items():
        folds = [
            Fold({n: n for n in everyone if (n in half) == inside}, {n: n for n in everyone})
            for inside in (True, False)
        ]
        found.append(ObjectSet(name, references, tuple(folds)))
    return found
