"""Figures of the experiments: accuracy against the number of views, its spread, information against rank."""

from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np
from jaxtyping import Float
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MaxNLocator, NullLocator

from verification.experiments.design import NOTHING
from verification.report.drawing import COLORS, GRID, INK, MARKS, QUIET, line

Data = Mapping[str, Any]
SHORT = {"best single view": "best view", "mean of the views": "mean view", "ridge": "ridge"}
"""Baselines beside their lines."""
SCALE = colormaps["cividis"].resampled(20)
"""Few enough colours for a colour bar that is drawn and not a picture."""
LONGEST = 12
"""Letters of another baseline's name beside its line."""
POINT = 1.0
"""The smallest effect of interest, in points of a hundred; within it the scale of the gain is linear."""
APART = 0.055
"""Least distance of two labels, as a share of the height of the axes."""


def accuracy(figure: Figure, pictures: Data, design: Data) -> None:
    """Mean score of each setting with its interval, and of the baselines, by the number of views."""
    axes, counts = figure.subplots(), np.array(design["counts"], dtype=np.float64)
    default, labels = pictures["default"], []
    for name, cells in default["baselines"].items():
        scores = _percent(cells, "score")
        axes.plot(counts, scores, color="#7c8894", linewidth=1.1, linestyle=(0, (3, 2)))
        labels.append((scores[-1], SHORT.get(name, name[:LONGEST]), QUIET))
    for at, (setting, cells) in enumerate(zip(design["settings"], default["accuracy"], strict=True)):
        shifted = counts + 0.07 * (at - 1.5)
        scores = _percent(cells, "score")
        bars = np.abs(np.stack([_percent(cells, "lower"), _percent(cells, "upper")]) - scores)
        axes.errorbar(shifted, scores, bars, marker=MARKS[at], markersize=4.5, elinewidth=1.0, **line(at))
        labels.append((scores[-1], f"({setting[0]:g}, {setting[1]:g})", COLORS[at]))
    axes.set_xticks(counts)
    _beside(axes, labels)
    plain(axes, f"views n (chance: {100.0 * pictures['chance']:g} %)", "mean score, %")


def spread(figure: Figure, pictures: Data, design: Data) -> None:
    """One panel a setting: where the scores of all configurations lie, and the default one."""
    for at, axes in enumerate(figure.subplots(2, 2, sharex=True, sharey=True).flat):
        _bands(axes, pictures["spread"][at], design, at)
        default = _percent(pictures["default"]["accuracy"][at], "score")
        axes.plot(design["counts"], default, color=INK, linestyle="none", marker=MARKS[at], markersize=4)
        axes.set_ylim(0, 100)
        plain(axes, "views n" if at > 1 else "", "" if at % 2 else "mean score, %")


def gain(figure: Figure, pictures: Data, design: Data) -> None:
    """One panel a setting other than (0, 0): its score minus that of (0, 0), over all configurations."""
    others = [at for at, setting in enumerate(design["settings"]) if tuple(setting) != NOTHING]
    panels = figure.subplots(1, len(others), sharey=True)
    for at, axes in zip(others, np.atleast_1d(panels), strict=True):
        _bands(axes, pictures["gain"][at], design, at)
        axes.axhline(0.0, color=INK, linewidth=1.0)
        axes.axhline(POINT, color=QUIET, linewidth=0.9, linestyle=(0, (1, 2)))
        axes.set_yscale("symlog", linthresh=POINT, linscale=0.6)
        axes.set_yticks(_decades(100.0 * np.array(pictures["gain"], dtype=np.float64)))
        axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axes.yaxis.set_minor_locator(NullLocator())
        plain(axes, "views n", "gain, points" if at == others[0] else "")


def _decades(values: Float[np.ndarray, "..."]) -> list[float]:
    """0, the smallest effect on either side, and powers of 10 as far as the values go."""
    powers = [POINT * 10.0**k for k in range(3)]
    least, most = float(values.min()), float(values.max())
    below = [-each for each in reversed(powers) if each == POINT or -each >= least]
    return [*below, 0.0, *(each for each in powers if each == POINT or each <= most)]


def _bands(axes: Axes, cells: Sequence[Sequence[float]], design: Data, at: int) -> None:
    """Quantiles over the configurations by number of views, in percent, named by their setting."""
    low, inner, middle, outer, high = 100.0 * np.array(cells, dtype=np.float64).T
    counts, setting = np.array(design["counts"], dtype=np.float64), design["settings"][at]
    axes.fill_between(counts, low, high, color=COLORS[at], alpha=0.15, linewidth=0)
    axes.fill_between(counts, inner, outer, color=COLORS[at], alpha=0.3, linewidth=0)
    axes.plot(counts, middle, color=COLORS[at], linewidth=1.4)
    axes.set_title(f"({setting[0]:g}, {setting[1]:g})", fontsize=10, color=COLORS[at], loc="left")
    axes.set_xticks(counts)


def information(figure: Figure, pictures: Data, design: Data) -> None:
    """Mutual information of a view and the reference, by the view's rank."""
    axes, rows = figure.subplots(), pictures["default"]["information"]
    ranks, means = [each["rank"] for each in rows], np.array([each["mean"] for each in rows])
    ends = np.array([[each["lower"], each["upper"]] for each in rows]).T
    style = line(0) | {"linestyle": "none"}
    axes.errorbar(ranks, means, np.abs(ends - means), marker="o", markersize=5.5, elinewidth=1.4, **style)
    axes.set_xticks(ranks)
    axes.set_ylim(0.0, max(1e-9, 1.15 * float(ends.max())))
    axes.yaxis.set_major_locator(MaxNLocator(6))
    plain(axes, "rank of the view by |w|", "mutual information, bits")


def lambdas(figure: Figure, pictures: Data, design: Data) -> None:
    """Heat map of the score over lambda2 and lambda3, with its scale and the numbers."""
    axes, values = figure.subplots(), design["grid"]
    table = 100.0 * np.array([[cell["score"] for cell in row] for row in pictures["default"]["grid"]])
    if table.shape != (len(values), len(values)):
        raise ValueError(f"a grid of {table.shape} does not fit {len(values)} values")
    edges = np.arange(len(values) + 1) - 0.5
    mesh = axes.pcolormesh(edges, edges, table, cmap=SCALE, vmin=0, vmax=100, edgecolor="w", linewidth=0.6)
    for (row, column), value in np.ndenumerate(table):
        tone = "white" if value < 55.0 else INK
        axes.annotate(f"{value:.0f}", (column, row), ha="center", va="center", color=tone, fontsize=10)
    bar = figure.colorbar(mesh, ax=axes, label="mean score, %", ticks=[0, 25, 50, 75, 100])
    bar.ax.tick_params(length=0)
    bar.outline.set_visible(False)
    for name, axis in (("lambda3", axes.xaxis), ("lambda2", axes.yaxis)):
        axis.set_ticks(range(len(values)), [f"{each:g}" for each in values])
        axis.set_label_text(name)
    axes.tick_params(length=0)
    axes.spines[:].set_visible(False)
    axes.set_aspect("equal")


def _percent(cells: Sequence[Data], key: str) -> Float[np.ndarray, " k"]:
    return 100.0 * np.array([cell[key] for cell in cells], dtype=np.float64)


def _beside(axes: Axes, labels: list[tuple[float, str, str]]) -> None:
    """Names of the lines at their right ends, moved apart where they would overlap."""
    low, high = axes.get_ylim()
    rows = sorted(labels)
    places = spaced([(value - low) / (high - low) for value, _, _ in rows], APART)
    for (value, text, color), place in zip(rows, places, strict=True):
        axes.annotate(
            text,
            (6.15, value),
            (1.08, place),
            textcoords="axes fraction",
            color=color,
            fontsize=9,
            va="center",
            arrowprops={"arrowstyle": "-", "color": color, "linewidth": 0.6, "shrinkA": 1, "shrinkB": 1},
        )


def spaced(values: Sequence[float], least: float) -> list[float]:
    """Rising values in [0, 1], moved as little as needed to be at least `least` apart where there is room.

    Neighbours that are too close are joined into one run around their mean, until no two runs meet.
    """
    runs: list[tuple[float, int]] = []
    for value in values:
        runs.append((value, 1))
        while len(runs) > 1 and runs[-1][0] - runs[-2][0] < least * (runs[-1][1] + runs[-2][1]) / 2.0:
            (one, few), (two, many) = runs[-2:]
            runs[-2:] = [((one * few + two * many) / (few + many), few + many)]
    placed = []
    for middle, size in runs:
        half = least * (size - 1) / 2.0
        start = min(max(middle - half, 0.0), max(0.0, 1.0 - 2.0 * half))
        placed += [start + least * at for at in range(size)]
    return placed


def plain(axes: Axes, x: str, y: str, grid: Literal["both", "y"] = "both") -> None:
    """Name the axes; a thin grid, and no ticks, upper or right line."""
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    axes.grid(axis=grid, color=GRID, linewidth=0.6)
    axes.tick_params(length=0)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    if grid == "both":
        axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
