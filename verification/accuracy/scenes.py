"""Scenes composed from the photographs of several objects: what is known, what calibrates, what tests.

The photographs of each object are shuffled, once for each draw. The first are its references; the others are
halved: scenes that set thresholds are made of one half, scenes that test of the other. So no photograph
serves as a reference and in a scene, or in scenes of both kinds. Where too few are left for that, nothing
is calibrated and all others test.

A scene is six photographs of one object, drawn without replacement, under one of three conditions. With the
same seed the scenes of all conditions are of the same photographs, and the same two of them are changed.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from convexperc.errors import InputError
from convexperc.features import FeatureConfiguration, extract
from verification.experiments.design import VIEWS, key
from verification.experiments.scenes.album import Album, Photo
from verification.experiments.scenes.obstacles import cover_fully, cover_partly
from verification.experiments.scenes.pictures import Picture, PictureSet, Scene, View

CLEAR, COVERED, INTRUDER = "six clear views", "two views covered", "two views of another object"
CONDITIONS = {
    CLEAR: "six photographs of the object as they are",
    COVERED: "of two of the six, a board or box hides all of the object in one and 30 to 70 % in the other",
    INTRUDER: "two of the six are photographs of another object that is known",
}
CHANGED = 2
"""Views of a scene that are covered, or show another object."""
Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Sizes:
    """How much is drawn.

    Attributes
    ----------
    seed : int
    draws : int
        Divisions of the photographs into references and views of scenes.
    scenes : int
        Of each object, draw and condition.
    references : int
        Photographs of each object that may be its references.
    """

    seed: int = 0
    draws: int = 3
    scenes: int = 6
    references: int = 5


@dataclass(frozen=True, slots=True, eq=False)
class Split:
    """What each photograph of an object serves in one draw; `calibration` may be empty."""

    object: str
    references: tuple[Photo, ...]
    calibration: tuple[Photo, ...]
    test: tuple[Photo, ...]

    @classmethod
    def of(cls, album: Album, sizes: Sizes, draw: int) -> "Split":
        """Shuffle and divide an album.

        Raises
        ------
        InputError
            It has too few photographs for the references and one scene.
        """
        photos = (album.reference, *album.others)
        order = _rng(sizes, album.object, "split", draw).permutation(len(photos)).tolist()
        first, rest = order[: sizes.references], order[sizes.references :]
        if len(rest) < VIEWS:
            must = f"must be at least {sizes.references} references and {VIEWS} views of scenes"
            raise InputError(f"photographs of {album.object}", value=len(photos), must=must)
        half = len(rest) // 2 if len(rest) >= 2 * VIEWS else 0
        parts = (tuple(photos[k] for k in each) for each in (first, rest[:half], rest[half:]))
        return cls(album.object, *parts)


@dataclass(frozen=True, slots=True, eq=False)
class Trial:
    """A scene with the features of its views, float64 (6, d)."""

    scene: Scene
    X: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Described:
    """The features of all photographs, each computed once.

    Attributes
    ----------
    configuration : FeatureConfiguration
    rows : dict of str to float64 (d,)
        By ``OBJECT/VIEW``.
    """

    configuration: FeatureConfiguration
    rows: dict[str, Floats]

    @classmethod
    def of(cls, albums: Iterable[Album], configuration: FeatureConfiguration) -> "Described":
        """Describe the photographs as they are."""
        photos = {
            photograph(each.object, photo): photo.picture
            for each in albums
            for photo in (each.reference, *each.others)
        }
        X = extract(photos.values(), configuration)
        return cls(configuration, dict(zip(photos, X, strict=True)))


def photograph(name: str, photo: Photo) -> str:
    """Name a photograph unlike all others."""
    return f"{name}/{photo.name}"


def compose(
    splits: Mapping[str, Split],
    described: Described,
    condition: str,
    sizes: Sizes,
    draw: int,
    *,
    calibration: bool = False,
    others: Mapping[str, Sequence[str]] | None = None,
) -> list[Trial]:
    """Compose every object's scenes of one draw, and describe the views that were changed.

    Parameters
    ----------
    splits : mapping of str to Split
    described : Described
    condition : str
        One of `CONDITIONS`.
    sizes : Sizes
    draw : int
    calibration : bool
        Whether the scenes set thresholds.
    others : mapping of str to sequence of str, optional
        Of each object those that may be in view beside it; without, all.
    """
    kind = "calibration" if calibration else "test"
    drawn: list[tuple[Scene, list[Picture | str]]] = []
    for name, split in splits.items():
        own = split.calibration if calibration else split.test
        beside = (others or {}).get(name) or [each for each in splits if each != name]
        for number in range(sizes.scenes if own else 0):
            rng = _rng(sizes, name, kind, draw, number)
            chosen = [own[k] for k in rng.choice(len(own), VIEWS, replace=False)]
            places = rng.choice(VIEWS, CHANGED, replace=False).tolist()
            views = [(View(f"robot-{k}", 1.0, photograph=photograph(name, p)), photograph(name, p))
                     for k, p in enumerate(chosen, 1)]  # fmt: skip
            seen: list[tuple[View, Picture | str]] = [*views]
            if condition == COVERED:
                for place, cover in zip(places, (cover_partly, cover_fully), strict=True):
                    covered = cover(chosen[place].picture, chosen[place].mask, rng)
                    view = View(views[place][0].name, covered.visible_share, photograph=views[place][1])
                    seen[place] = view, covered.picture
            elif condition == INTRUDER:
                other = splits[beside[int(rng.integers(len(beside)))]]
                pool = other.calibration if calibration else other.test
                for place, k in zip(places, rng.choice(len(pool), CHANGED, replace=False), strict=True):
                    shown = photograph(other.object, pool[k])
                    seen[place] = View(views[place][0].name, 0.0, photograph=shown), shown
            scene = Scene(f"{name}, {kind} {draw}.{number}", name, condition, tuple(v for v, _ in seen))
            drawn.append((scene, [picture for _, picture in seen]))
    return list(_described(drawn, described))


def _described(drawn: list[tuple[Scene, list[Picture | str]]], described: Described) -> Iterator[Trial]:
    """Features by name where the picture is a photograph as it is, and new ones where it was changed."""
    changed = [picture for _, views in drawn for picture in views if not isinstance(picture, str)]
    new = iter(extract(changed, described.configuration) if changed else ())
    for scene, views in drawn:
        rows = [described.rows[view] if isinstance(view, str) else next(new) for view in views]
        yield Trial(scene, np.stack(rows))


def simulated_albums(pictures: PictureSet) -> tuple[Album, ...]:
    """Turn a simulated set into albums: the reference and all views with nothing before the object.

    Raises
    ------
    InputError
        An object has no clear view.
    """
    layout = pictures.layout
    found: dict[str, list[Photo]] = {name: [] for name in layout.objects}
    for scene, rows in layout.rows():
        for view, row in zip(scene.views, range(rows.start, rows.stop), strict=True):
            if view.obstruction == "none":
                name = f"{scene.name}/{view.name}"
                found[scene.object].append(Photo(name, None, pictures.pictures[row], pictures.masks[row]))
    if empty := [name for name, photos in found.items() if not photos]:
        raise InputError(f"views of {empty[0]}", value=0, must="must be clear in some scene")
    return tuple(
        Album(name, Photo("reference", 0, pictures.pictures[k], pictures.masks[k]), tuple(found[name]))
        for k, name in enumerate(layout.objects)
    )


def _rng(sizes: Sizes, *names: object) -> np.random.Generator:
    return np.random.default_rng([sizes.seed, key(" ".join(map(str, names)))])
