"""Where the method goes wrong: counts under each configuration, and over all of them."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from verification.experiments.design import BOTH, SETTINGS
from verification.experiments.measure.configurations import FACTORS
from verification.experiments.measure.measured import Measured
from verification.experiments.measure.numbers import rounded
from verification.experiments.measure.trials import WRONG
from verification.experiments.measure.weights import followed
from verification.experiments.record.entries import Confusion, Entry, Limits, Shortest
from verification.experiments.record.sensitivity import level_name


def limits(measured: Measured) -> dict[str, Any]:
    """Counts of one configuration.

    Returns
    -------
    dict
        "wrong" and "shortest": wrong labels of each setting, and how many of them are the reference of the
        smallest length, None where all are equally long; "explained"; "visible": mean Kendall's tau-b of |w|
        and the visible share over the scenes where it is defined, None without any; "grid open": share of
        trials without a proved label on the grid; "confusion": labels by object, all views and both norms.
    """
    settings = measured.trials.settings
    wrong = settings.kinds == WRONG
    shortest = wrong & (settings.labels == measured.shortest)
    counts = shortest.sum(axis=(0, 2, 3)).tolist()
    return {
        "wrong": wrong.sum(axis=(0, 2, 3)).tolist(),
        "shortest": None if measured.shortest is None else counts,
        "explained": rounded(measured.by_fraction.mean()),
        "visible": followed(measured.layout, measured.weights.w),
        "grid open": rounded(measured.trials.grid.open.mean(axis=(0, 3))),
        "confusion": _confusion(measured),
    }


def _confusion(measured: Measured) -> Confusion:
    """Rows: the object; columns: the label; what is open is counted apart."""
    layout = measured.layout
    labels = measured.trials.settings.labels[:, SETTINGS.index(BOTH), -1, 0]
    truths = np.array([layout.truth(scene) for scene in layout.scenes])
    counts = np.zeros((len(layout.objects), len(layout.objects)), dtype=int)
    proved = labels >= 0
    np.add.at(counts, (truths[proved], labels[proved]), 1)
    missing = np.bincount(truths[~proved], minlength=len(layout.objects))
    return {"objects": list(layout.objects), "counts": counts.tolist(), "open": missing.tolist()}


def summary(configurations: Sequence[Entry], found: Sequence[Mapping[str, Any]]) -> Limits:
    """What all configurations together say.

    Parameters
    ----------
    configurations : sequence of mapping
        As the record has them; the default first.
    found : sequence of mapping
        What `limits` gave for each.
    """
    both = SETTINGS.index(BOTH)
    accuracy = [float(np.mean(each["accuracy"][both])) for each in configurations]
    open_ = [float(np.mean(each["open"][both])) for each in configurations]
    return {
        "shortest": _shortest(configurations, found, both),
        "objective": _by_level(
            "normalisation", configurations, lambda k: configurations[k]["accuracy"][both][-1]
        ),
        "explained": _by_level("normalisation", configurations, lambda k: found[k]["explained"]),
        "visible": _by_level("lambda1", configurations, lambda k: found[k]["visible"])
        | {"default": found[0]["visible"]},
        "accuracy": {each: _by_level(each, configurations, accuracy.__getitem__) for each in FACTORS},
        "open": {each: _by_level(each, configurations, open_.__getitem__) for each in FACTORS},
        "settings": rounded(np.mean([each["accuracy"] for each in configurations], axis=(0, 2))),
        "settings_open": rounded(np.mean([each["open"] for each in configurations], axis=(0, 2))),
        "grid": rounded(np.mean([each["grid"] for each in configurations], axis=0)),
        "grid_open": rounded(np.mean([each["grid open"] for each in found], axis=0)),
        "confusion": found[0]["confusion"],
    }


def _shortest(
    configurations: Sequence[Entry], found: Sequence[Mapping[str, Any]], setting: int
) -> dict[str, Shortest]:
    """Wrong labels where references differ in length, and those that are the shortest, by normalisation."""
    counts: dict[str, Shortest] = {}
    for configuration, each in zip(configurations, found, strict=True):
        if each["shortest"] is not None:
            level = level_name(configuration["levels"]["normalisation"])
            kept = counts.setdefault(level, {"wrong": 0, "shortest": 0})
            kept["wrong"] += each["wrong"][setting]
            kept["shortest"] += each["shortest"][setting]
    return counts


def _by_level(
    factor: str, configurations: Sequence[Entry], value: Callable[[int], float | None]
) -> dict[str, float]:
    """Mean over the configurations of each level that has been tried."""
    found: dict[str, list[float]] = {}
    for k, configuration in enumerate(configurations):
        measured = value(k)
        if measured is not None:
            found.setdefault(level_name(configuration["levels"][factor]), []).append(measured)
    return {level: rounded(np.mean(values)) for level, values in found.items()}
