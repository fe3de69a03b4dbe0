"""What a user should know: sentences made of the numbers of the record."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from verification.experiments.design import NOTHING
from verification.ledger.claims import PARTS
from verification.report.experiments.flips import FACTORS
from verification.report.experiments.tables import pair, percent
from verification.report.experiments.weights import MODALITIES

Data = Mapping[str, Any]
ONE_VIEW = (
    f"It is proved (R1/one_view) that {PARTS['R1/one_view'].statement}. So at n = 1 the lambdas gain nothing"
    " in such a configuration."
)
LIBRARY_LAMBDAS = (1.0, 0.1)
"""(lambda2, lambda3) that `convexperc recognize` takes unless told otherwise."""
UNEQUAL_LENGTHS = ("sum one by modality", "none")
"""Normalisations under which references differ in length."""


def advice(pictures: Data, design: Data) -> Iterator[tuple[str, str]]:
    """Points on one set, each with what it is about in front."""
    yield "Accuracy", _accuracy(pictures, design)
    yield "Obstructed views", _obstructed(pictures)
    yield "What the weights mean", _weights(pictures)
    yield "Modalities", _modalities(pictures)
    yield "Lambdas", _lambdas(pictures, design)
    yield "The library's own choice", _own(pictures, design)
    yield "One view", ONE_VIEW
    if "limits" in pictures:
        yield from _limits(pictures, design)


def _accuracy(pictures: Data, design: Data) -> str:
    last = [cells[-1] for cells in pictures["default"]["accuracy"]]
    best = max(range(len(last)), key=lambda at: last[at]["score"])
    cell, first = last[best], last[design["settings"].index(list(NOTHING))]
    open_ = sum(each["tie"] + each["undecided"] for each in last)
    rivals = {name: cells[-1]["score"] for name, cells in pictures["default"]["baselines"].items()}
    rival = max(rivals, key=lambda name: rivals[name])
    trials = sum(_trials(each) for each in last)
    return (
        f"With all {design['counts'][-1]} views the default configuration scores {percent(cell['score'])} %"
        f" at its best setting, {pair(design['settings'][best])}, and {percent(first['score'])} % by least"
        f" squares alone; the best baseline, {rival}, scores {percent(rivals[rival])} %; chance is"
        f" {percent(pictures['chance'])} %. Of {trials:,} labels of the settings {open_:,} were ties or"
        " undecided."
    )


def _trials(cell: Data) -> int:
    return sum(int(cell[name]) for name in ("right", "wrong", "tie", "undecided"))


def _obstructed(pictures: Data) -> str:
    levels = {name: values[-1] for name, values in pictures["default"]["by_level"].items()}
    easy, hard = max(levels, key=lambda name: levels[name]), min(levels, key=lambda name: levels[name])
    return (
        f"At (0.1, 0.1) with all views the score is highest, {percent(levels[easy])} %, where the"
        " obstructed views"
        f" are: {easy}; and lowest, {percent(levels[hard])} %, where they are: {hard}."
    )


def _weights(pictures: Data) -> str:
    shares, rows = pictures["default"]["shares"], pictures["default"]["information"]
    told = (
        "A view that shows at least 90 % of the object has on average {none} % of the sum of |w|, one that is"
        " partly hidden {partial} %, one that shows at most 5 % {full} %; 16.7 % would be an equal part."
    ).format(**{name: percent(shares[name]) for name in ("none", "partial", "full")})
    ends = f"{rows[0]['mean']:.2f} to {rows[-1]['mean']:.2f}"
    return (
        f"{told} The mutual information with the reference goes from {ends} bits between the first"
        " and the last"
        " rank. A small weight is no proof of a hidden view, and a large one none of a good view:"
        " |w| says how"
        " much a view adds to the others in this sum."
    )


def _modalities(pictures: Data) -> str:
    shares = pictures["default"]["modalities"]
    ranked = sorted(shares, key=lambda name: -shares[name])
    told = ", ".join(f"{MODALITIES.get(name, name)} {percent(shares[name])} %" for name in ranked)
    return f"Mean shares of the norms ||u^i|| in scenes with one view hidden and one partly hidden: {told}."


def _lambdas(pictures: Data, design: Data) -> str:
    limits, default = pictures.get("limits", {}), pictures["default"]
    table = np.array(limits.get("grid", [[cell["score"] for cell in row] for row in default["grid"]]))
    values, over = design["grid"], "all configurations" if "grid" in limits else "the default one"
    best, worst = (np.unravel_index(int(at), table.shape) for at in (table.argmax(), table.argmin()))
    told = (
        f"On the grid, in the mean over {over}, (lambda2, lambda3) ="
        f" {pair([values[at] for at in best])} is best with {percent(table[best])} %,"
        f" {pair([values[at] for at in worst])} worst with {percent(table[worst])} %."
    )
    if "grid_open" not in limits:
        return told
    open_ = np.array(limits["grid_open"])
    most = np.unravel_index(int(open_.argmax()), open_.shape)
    if not open_[most]:
        return f"{told} No label was tied or undecided."
    cell = pair([values[at] for at in most])
    return f"{told} Ties and undecided labels are most frequent at {cell}: {percent(open_[most])} %."


def _own(pictures: Data, design: Data) -> str:
    """The defaults of the command line, against the paper's choice and least squares."""
    grid, values = pictures["default"]["grid"], list(design["grid"])

    def score(lambda2: float, lambda3: float) -> str:
        return f"{percent(grid[values.index(lambda2)][values.index(lambda3)]['score'])} %"

    return (
        f"`convexperc recognize` takes (lambda2, lambda3) = {pair(LIBRARY_LAMBDAS)}, with features of unit"
        f" length by modality. On the grid's subsets that scores {score(*LIBRARY_LAMBDAS)}, the paper's"
        f" (0.1, 0.1) {score(0.1, 0.1)}, least squares {score(0.0, 0.0)}.{_ranked(pictures)} The lambdas are"
        " of the size of ||o||^2, which is 3 there: for features of another length choose others."
    )


def _ranked(pictures: Data) -> str:
    """What the same lambdas do to the ranking."""
    found = {tuple(each["lambdas"]): each for each in pictures.get("rankings", ())}
    if LIBRARY_LAMBDAS not in found or (0.1, 0.1) not in found:
        return ""
    own, paper = found[LIBRARY_LAMBDAS], found[0.1, 0.1]
    return (
        f" It proves {own['proved zero']} of {own['full']} hidden views to have weight 0 at every optimum,"
        f" (0.1, 0.1) {paper['proved zero']}; the three good views of the case study come first in"
        f" {percent(own['three'])} % and {percent(paper['three'])} % of the scenes."
    )


def _limits(pictures: Data, design: Data) -> Iterator[tuple[str, str]]:
    limits = pictures["limits"]
    means = limits["settings"]
    told = ", ".join(
        f"{pair(s)} {percent(mean)} %" for s, mean in zip(design["settings"], means, strict=True)
    )
    first = ", ".join(
        f"{pair(s)} in {count}" for s, count in zip(design["settings"], pictures["best"], strict=True)
    )
    yield (
        "Settings",
        f"Mean score over n and all {pictures['readings']} configurations, also those that do not count:"
        f" {told}. Highest mean over n: {first}.",
    )
    if widest := _widest(limits["accuracy"]):
        yield "What matters most", widest
    if told := _visible(limits):
        yield "Rank and sight", told
    if told := _shortest(limits):
        yield "Unequal lengths", told
    yield "Where the label fails", _hardest(limits["confusion"])


def _widest(accuracy: Data) -> str:
    """The choice that moves the score most."""
    spans = {name: max(by.values()) - min(by.values()) for name, by in accuracy.items() if len(by) > 1}
    if not spans:
        return ""
    name = max(spans, key=lambda each: spans[each])
    by = accuracy[name]
    best, worst = max(by, key=lambda each: by[each]), min(by, key=lambda each: by[each])
    return (
        f"At (0.1, 0.1), of all that was varied, the {FACTORS.get(name, name)} moves the mean score most:"
        f" {percent(by[best])} % with {best}, {percent(by[worst])} % with {worst}."
    )


def _visible(limits: Data) -> str:
    """How |w| follows what is seen of the object."""
    known = {name: tau for name, tau in limits["visible"].items() if tau is not None and name != "default"}
    if not known:
        return ""
    told = ", ".join(f"{tau:.2f} at lambda1 = {name}" for name, tau in known.items())
    return f"Kendall's tau-b of |w| and the visible share of the object: {told}; 1 would be the same order."


def _shortest(limits: Data) -> str:
    """Labels that the shortest reference takes."""
    counted = [
        f"with {name} {found['shortest']:,} of {found['wrong']:,} wrong labels are the shortest reference"
        for name, found in limits.get("shortest", {}).items()
        if name in UNEQUAL_LENGTHS and found["wrong"]
    ]
    if "objective" in limits and "explained" in limits:
        counted += [
            f"with {name} the score is {percent(limits['objective'][name])} % by F* and"
            f" {percent(limits['explained'][name])} % by the explained fraction F*/||o||^2"
            for name in limits["objective"]
            if name in UNEQUAL_LENGTHS and name in limits["explained"]
        ]
    if not counted:
        return ""
    return "Where references differ in length the lowest F* favours short ones: " + "; ".join(counted) + "."


def _hardest(confusion: Data) -> str:
    """The object that is recognised least, and what it is taken for."""
    table = np.array(confusion["counts"])
    totals = table.sum(axis=1) + np.array(confusion["open"])
    right = np.diag(table) / np.maximum(totals, 1)
    worst, names = int(right.argmin()), confusion["objects"]
    others = table[worst].copy()
    others[worst] = -1
    taken = int(others.argmax())
    count = table[worst, worst]
    told = f"At (0.1, 0.1) with all views the {names[worst]} is labelled right least often, {count} of"
    more = f"; {others[taken]} times it is taken for the {names[taken]}" if others[taken] > 0 else ""
    return f"{told} {totals[worst]} times{more}."
