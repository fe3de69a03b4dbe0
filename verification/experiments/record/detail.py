"""The default configuration in full: counts, intervals, and the scenes that are shown."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from verification.experiments.design import SETTINGS
from verification.experiments.measure.baselines import BASELINES
from verification.experiments.measure.features import MODALITIES
from verification.experiments.measure.measured import Measured
from verification.experiments.measure.numbers import rounded
from verification.experiments.measure.trials import KINDS, Tried
from verification.experiments.measure.weights import by_rank
from verification.experiments.record.bootstrap import intervals
from verification.experiments.record.entries import (
    Case,
    Cell,
    CountedCell,
    Detail,
    Rank,
    Scored,
    StudyScene,
)
from verification.experiments.scenes.pictures import OBSTRUCTIONS, STUDIED

Floats = NDArray[np.float64]

LONGEST_U = 3000
"""Feature weights are recorded up to this number of columns."""
U_DIGITS = 8
SHOWN = 3
"""Scenes of the case study that are shown, each of another object."""


def detail(measured: Measured) -> Detail:
    """Plain JSON values of the record's "default".

    Raises
    ------
    ValueError
        The settings were not decided by the explained fraction, as they are under the default configuration.
    """
    if measured.explained is None:
        raise ValueError("no configuration but the default one is told in full")
    counts = range(len(measured.design.counts))
    side = range(measured.trials.grid.scores.shape[1])
    return {
        "accuracy": _all_counted(measured.trials.settings, measured),
        "explained": _all_counted(measured.explained, measured),
        "baselines": {
            name: [_scored(measured.baselines[:, b, k].mean(axis=1), measured) for k in counts]
            for b, name in enumerate(BASELINES)
        },
        "grid": [[_cell(measured.trials.grid, (slice(None), i, j)) for j in side] for i in side],
        "by_level": _by(measured, [scene.level for scene in measured.layout.scenes]),
        "by_object": _by(measured, [scene.object for scene in measured.layout.scenes]),
        "information": _information(measured),
        "shares": _shares(measured),
        "modalities": _modalities(measured),
        "case": _case(measured),
        "case_study": _case_study(measured),
    }


def _scored(scores: Floats, measured: Measured) -> Scored:
    """Mean of one score a scene, with an interval for this mean alone; bounds of a share stay within 0..1."""
    found = intervals(scores[:, None], measured.layout.scenes, measured.design, scored=True)
    mean, lower, upper = (rounded(np.clip(each[0], 0.0, 1.0)) for each in found)
    return {"score": mean, "lower": lower, "upper": upper}


def _all_counted(tried: Tried, measured: Measured) -> list[list[CountedCell]]:
    """Of each setting and number of views."""
    counts, settings = range(len(measured.design.counts)), range(len(SETTINGS))
    return [[_counted(tried, (slice(None), s, k), measured) for k in counts] for s in settings]


def _counted(tried: Tried, chosen: Any, measured: Measured) -> CountedCell:
    return {**_cell(tried, chosen), **_scored(tried.scores[chosen].mean(axis=1), measured)}


def _cell(tried: Tried, chosen: Any) -> Cell:
    right, wrong, tie, undecided = (int((tried.kinds[chosen] == kind).sum()) for kind in range(len(KINDS)))
    score = rounded(tried.scores[chosen].mean())
    return {"right": right, "wrong": wrong, "tie": tie, "undecided": undecided, "score": score}


def _by(measured: Measured, groups: list[str]) -> dict[str, list[float]]:
    """Score with all views of each setting, by what the scenes have in common."""
    all_views = measured.accuracy[:, :, -1]
    return {name: rounded(all_views[np.array(groups) == name].mean(axis=0)) for name in dict.fromkeys(groups)}


def _information(measured: Measured) -> list[Rank]:
    """Bits of the view of each rank."""
    pairs = zip(measured.weights.w, measured.information, strict=True)
    ranked = np.array([by_rank(w, bits) for w, bits in pairs])
    found = intervals(ranked, measured.layout.scenes, measured.design)
    columns = zip(found.mean, found.lower, found.upper, strict=True)
    return [
        rounded({"rank": rank, "mean": mean, "lower": lower, "upper": upper})
        for rank, (mean, lower, upper) in enumerate(columns, 1)
    ]


def _shares(measured: Measured) -> dict[str, float]:
    """Mean share of sum |w| of a single view, by its obstruction, over the scenes looked at one by one."""
    chosen = measured.studied()
    scenes = [scene for scene in measured.layout.scenes if scene.level == STUDIED]
    w = np.abs(measured.weights.w[chosen])
    total = w.sum(axis=1, keepdims=True)
    shares = np.divide(w, total, out=np.zeros_like(w), where=total > 0.0)
    kinds = np.array([[view.obstruction for view in scene.views] for scene in scenes])
    return {name: rounded(shares[kinds == name].mean()) for name in OBSTRUCTIONS if (kinds == name).any()}


def _modalities(measured: Measured) -> dict[str, float]:
    """Mean share of sum ||u^i|| of each modality, over the same scenes."""
    norms = measured.weights.norms[measured.studied()]
    kept = norms[norms.sum(axis=1) > 0.0]
    means = (kept / kept.sum(axis=1, keepdims=True)).mean(axis=0) if len(kept) else np.zeros(norms.shape[1])
    return dict(zip(MODALITIES, rounded(means), strict=True))


def _case(measured: Measured) -> Case:
    """One scene with all its weights."""
    number = int(np.argmax(measured.studied()))
    scene = measured.layout.scenes[number]
    found: Case = {
        "scene": scene.name,
        "object": scene.object,
        "views": [view.name for view in scene.views],
        "obstruction": [view.obstruction for view in scene.views],
        "visible_share": rounded([view.visible_share for view in scene.views]),
        "w": rounded(measured.weights.w[number]),
        "modality_sizes": measured.sizes,
        "modality_norms": rounded(measured.weights.norms[number]),
    }
    u = measured.weights.u[0]
    if len(u) <= LONGEST_U:
        found["u"] = rounded(u, U_DIGITS)
    return found


def _case_study(measured: Measured) -> list[StudyScene]:
    """The first scene of each of the first objects."""
    shown: dict[str, StudyScene] = {}
    for scene, w in zip(measured.study.scenes, measured.study_weights.w, strict=True):
        if scene.object not in shown and len(shown) < SHOWN:
            shown[scene.object] = {
                "scene": scene.name,
                "object": scene.object,
                "views": [view.name for view in scene.views],
                "w": rounded(w),
                "good": [view.good for view in scene.views],
                "visible_share": rounded([view.visible_share for view in scene.views]),
            }
    return list(shown.values())
