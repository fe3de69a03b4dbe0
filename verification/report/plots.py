"""The figures of the report as inline SVG: small, self-contained, the same bytes for the same numbers."""

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter

from convexperc.errors import InputError
from verification.report.drawing import COLORS, INK, MARKS, QUIET, drawn, finish, line, numbers

LONGEST = 44
"""Letters of a legend."""
TOLERANCE = 1e-6
"""The line in the figure of distances: `verification.ledger.claims.LIMIT`."""
REFERENCES: dict[str, Callable[[np.ndarray], np.ndarray]] = {"1/(2k+1)^2": lambda k: (2.0 * k + 1.0) ** -2}


def plot(name: str, series: Mapping[str, Any], label: str) -> str:
    """Draw one series.

    Parameters
    ----------
    name : str
        A key of `DRAWN`; also the prefix of every id in the SVG, so that several fit on one page.
    series : mapping
        Its numbers; "inf", "-inf" and "nan" may stand for numbers.
    label : str
        What a reader who cannot see it is told.

    Raises
    ------
    InputError
        The series lacks something, or its lists do not fit together.
    """
    try:
        height, draw = DRAWN[name]
        return drawn(lambda figure: draw(figure.subplots(), series), height, name, label)
    except (KeyError, TypeError, ValueError, IndexError) as problem:
        raise InputError(
            f"series {name!r}", value=str(problem), must="must have the shape that `plots` draws"
        ) from None


def _counterexample(axes: Axes, series: Mapping[str, Any]) -> None:
    lower, upper = numbers(series["F_star"])
    axes.axhspan(lower, upper, color="#9aa5b1", alpha=0.5, linewidth=0)
    axes.axhline((lower + upper) / 2.0, color=QUIET, linewidth=1.0)
    axes.annotate(
        "F*",
        (1.0, (lower + upper) / 2.0),
        (4, -3),
        xycoords=("axes fraction", "data"),
        textcoords="offset points",
    )
    for at, (name, values) in enumerate(series["runs"].items()):
        axes.plot(numbers(values), label=_words(name), **line(at), marker=MARKS[at % 6], markersize=4)
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    finish(axes, "iteration", "F")


def _distance(axes: Axes, series: Mapping[str, Any]) -> None:
    edges = np.log10(numbers(series["edges"]))
    rows = list(series["counts"])
    table = np.array([series["counts"][row] for row in rows], dtype=np.float64)
    if table.shape[1] != edges.size:
        raise ValueError(f"{table.shape[1]} counts do not fit {edges.size} upper ends")
    edges = np.concatenate([[edges[0] - 1.0], edges])
    totals = table.sum(axis=1)
    shares = table / np.maximum(totals, 1.0)[:, None]
    axes.pcolormesh(
        edges,
        np.arange(len(rows) + 1),
        np.sqrt(shares),
        cmap="Blues",
        vmin=0.0,
        vmax=1.0,
        edgecolor="white",
        linewidth=0.4,
    )
    axes.axvline(math.log10(TOLERANCE), color=COLORS[1], linewidth=1.4)
    axes.set_yticks(np.arange(len(rows)) + 0.5, [_words(row.replace("gauss_seidel", "GS")) for row in rows])
    axes.set_ylim(len(rows), 0)
    axes.tick_params(axis="y", length=0, labelsize=8)
    right = axes.secondary_yaxis("right")
    others = [series[name] for name in ("undecided", "undefined")]
    counts = [
        " + ".join([f"{total:.0f}", *(str(other[row]) for other in others)])
        for row, total in zip(rows, totals, strict=True)
    ]
    right.set_yticks(np.arange(len(rows)) + 0.5, counts)
    right.tick_params(length=0, labelsize=8)
    axes.set_xlabel("log10 of (F(last) - F*) / F*")
    for part in (axes, right):
        part.spines[:].set_visible(False)


def _rate(axes: Axes, series: Mapping[str, Any]) -> None:
    longest, least = 1, math.inf
    for at, (name, values) in enumerate(series["curves"].items()):
        gaps = numbers(values)
        shown = np.isfinite(gaps) & (gaps > 0.0)
        axes.plot(np.arange(1, gaps.size + 1)[shown], gaps[shown], label=_words(name), **line(at))
        longest, least = max(longest, gaps.size), min([least, *gaps[shown]])
    k = np.geomspace(1.0, longest, 60) - 1.0
    reference = REFERENCES[series["reference"]](k)
    axes.plot(k + 1.0, reference, color=INK, linewidth=0.9, linestyle=(0, (1, 2)), label=series["reference"])
    _logarithmic(axes, "x", "y")
    finish(axes, "iteration k, plus 1", "(F - F*) / F*")


def _cost(axes: Axes, series: Mapping[str, Any], what: str = "multiplications") -> None:
    for at, (name, growth) in enumerate(series.items()):
        slope = f": slope {float(growth['slope']):.2f}"
        axes.plot(
            numbers(growth["x"]),
            numbers(growth["y"]),
            label=_words(name) + slope,
            marker=MARKS[at % 6],
            markersize=4,
            **line(at),
        )
    _logarithmic(axes, "x", "y")
    axes.xaxis.set_major_locator(LogLocator(2.0, numticks=8))
    finish(axes, "size (n for step 6, else d)", what)


def _times(axes: Axes, series: Mapping[str, Any]) -> None:
    _cost(axes, series, "seconds")


def _clarabel(axes: Axes, series: Mapping[str, Any]) -> None:
    scales = numbers(series["scales"])
    named = {"share_off_1e-6": "off by more than 1e-6 F*", "share_off_1e-3": "off by more than 1e-3 F*"}
    for at, (key, label) in enumerate((named | {"share_not_optimal": "not called optimal"}).items()):
        axes.plot(
            scales, 100.0 * numbers(series[key]), label=label, marker=MARKS[at], markersize=4.5, **line(at)
        )
    _logarithmic(axes, "x")
    axes.set_ylim(-4, 104)
    fewest, most = min(series["per_scale"]), max(series["per_scale"])
    each = f"{most}" if fewest == most else f"{fewest} to {most}"
    finish(axes, f"scale ({each} problems each)", "share of the answers, %")


DRAWN: dict[str, tuple[float, Callable[[Axes, Mapping[str, Any]], None]]] = {
    "counterexample": (3.4, _counterexample),
    "distance": (4.0, _distance),
    "rate": (3.6, _rate),
    "cost": (3.6, _cost),
    "times": (3.6, _times),
    "clarabel": (3.4, _clarabel),
}


def _words(name: str) -> str:
    """A name for a legend or a row, cut where it would leave no room for the drawing."""
    words = name.replace("gauss_seidel", "Gauss-Seidel").replace("jacobi", "Jacobi")
    words = words.replace("_", " ").replace("/", ", ")
    return words if len(words) <= LONGEST else f"{words[: LONGEST - 3]}..."


def _logarithmic(axes: Axes, *names: str) -> None:
    """Make these axes logarithmic, with at most seven labels that need no superscript."""
    for name in names:
        axes.set(**{f"{name}scale": "log"})
        axis = getattr(axes, f"{name}axis")
        axis.set_major_locator(LogLocator(10.0, numticks=7))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_formatter(NullFormatter())
