"""Figures of one case: weights of the views, norms of the modalities, weights of the features."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from verification.report.drawing import COLORS, INK, QUIET
from verification.report.experiments.figures import plain

Data = Mapping[str, Any]
MODALITIES = {"color": "colour", "hog": "HOG", "lbp": "LBP"}
LOOKS: dict[str, dict[str, Any]] = {
    "none": {"facecolor": COLORS[0]},
    "partial": {"facecolor": "#f3d3bd", "hatch": "///", "edgecolor": COLORS[1]},
    "full": {"facecolor": COLORS[1], "edgecolor": COLORS[1]},
}
"""Bars by what stands before the object."""


def views(figure: Figure, pictures: Data, design: Data) -> None:
    """Bars of w, the obstructed views marked; beside them bars of ||u^i||."""
    case = pictures["default"]["case"]
    left, right = figure.subplots(1, 2, width_ratios=[2.0, 1.0])
    for at, (weight, kind) in enumerate(zip(case["w"], case["obstruction"], strict=True)):
        left.bar(at, weight, width=0.7, linewidth=1.0, **LOOKS[kind])
    names = [name.removeprefix("robot-") for name in case["views"]]
    marks = {"none": "", "partial": "\npartly\nhidden", "full": "\nhidden"}
    told = [name + marks[kind] for name, kind in zip(names, case["obstruction"], strict=True)]
    left.set_xticks(range(len(told)), told)
    left.axhline(0.0, color=INK, linewidth=0.8)
    plain(left, "view", "weight w", grid="y")
    norms = case["modality_norms"]
    named = [MODALITIES.get(name, name) for name in case["modality_sizes"]]
    right.bar(range(len(norms)), norms, width=0.6, color=COLORS[2])
    right.set_xticks(range(len(norms)), named)
    plain(right, "modality", "norm of u^i", grid="y")


def features(figure: Figure, pictures: Data, design: Data) -> None:
    """The entries of u, one panel a modality with one scale; strokes of many columns show their range."""
    u = pictures["default"]["case"]["u"]
    panels = np.atleast_1d(figure.subplots(len(u), 1, sharey=True))
    for axes, (at, (name, strokes)) in zip(panels, enumerate(u.items()), strict=True):
        ends = np.array(strokes["ends"], dtype=np.float64)
        columns = strokes["columns"] * np.arange(len(ends))
        low, high = np.minimum(ends[:, 0], 0.0), np.maximum(ends[:, 1], 0.0)
        axes.fill_between(columns, low, high, step="post", color=COLORS[at], linewidth=0)
        axes.axhline(0.0, color=QUIET, linewidth=0.6)
        axes.set_title(MODALITIES.get(name, name), fontsize=10, loc="left", color=COLORS[at])
        axes.set_xlim(0, max(1, columns[-1] + strokes["columns"]))
        axes.xaxis.set_major_locator(MaxNLocator(6, integer=True))
        axes.yaxis.set_major_locator(MaxNLocator(3))
        plain(axes, "", "u", grid="y")
    panels[-1].set_xlabel("column within the modality")
