"""The figures of the report as inline SVG: small, self-contained, the same bytes for the same numbers."""

import html
import io
import math
import re
import warnings
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter

from convexperc.errors import InputError

INK, QUIET, GRID = "#1b2530", "#4d5a68", "#e3e7eb"
COLORS = ("#0072b2", "#d55e00", "#009e73", "#b0568f", "#56707f", "#a86b00")
"""Okabe and Ito's, the light ones darkened; marks and dashes tell them apart as well."""
MARKS = "os^Dvx"
DASHES: tuple[Any, ...] = ("-", (0, (5, 2)), (0, (2, 1.5)), (0, (7, 2, 1.5, 2)), (0, (1, 1.5)), (0, (9, 3)))
WIDTH = 4.7
"""Inches; 450 pixels, so that 10 point letters stay readable on a phone."""
LONGEST = 44
"""Letters of a legend."""
TOLERANCE = 1e-6
"""The line in the figure of distances: `verification.claims.LIMIT`."""
REFERENCES: dict[str, Callable[[np.ndarray], np.ndarray]] = {"1/(k+1)^2": lambda k: (k + 1.0) ** -2}
STYLE: dict[Any, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 10.0,
    "text.color": INK,
    "axes.labelcolor": INK,
    "axes.edgecolor": QUIET,
    "xtick.color": QUIET,
    "ytick.color": QUIET,
    "xtick.labelsize": 9.0,
    "ytick.labelsize": 9.0,
    "legend.fontsize": 9.0,
    "svg.hashsalt": "convexperc",
    "svg.fonttype": "none",
    "text.parse_math": False,
    "path.simplify": True,
}


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
        with mpl.rc_context(STYLE), warnings.catch_warnings():
            warnings.filterwarnings("ignore", message=r"Glyph \d+", category=UserWarning)
            figure = Figure(figsize=(WIDTH, height), layout="constrained", facecolor="white")
            FigureCanvasAgg(figure)
            draw(figure.subplots(), series)
            out = io.StringIO()
            figure.savefig(out, format="svg", metadata={"Date": None})
    except (KeyError, TypeError, ValueError, IndexError) as problem:
        raise InputError(
            f"series {name!r}", value=str(problem), must="must have the shape that `plots` draws"
        ) from None
    return _inline(out.getvalue(), name, label)


def _counterexample(axes: Axes, series: Mapping[str, Any]) -> None:
    lower, upper = _numbers(series["F_star"])
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
        axes.plot(_numbers(values), label=_words(name), **_line(at), marker=MARKS[at % 6], markersize=4)
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    _finish(axes, "iteration", "F")


def _distance(axes: Axes, series: Mapping[str, Any]) -> None:
    edges = np.log10(_numbers(series["edges"]))
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
        gaps = _numbers(values)
        shown = np.isfinite(gaps) & (gaps > 0.0)
        axes.plot(np.arange(1, gaps.size + 1)[shown], gaps[shown], label=_words(name), **_line(at))
        longest, least = max(longest, gaps.size), min([least, *gaps[shown]])
    k = np.geomspace(1.0, longest, 60) - 1.0
    reference = REFERENCES[series["reference"]](k)
    axes.plot(k + 1.0, reference, color=INK, linewidth=0.9, linestyle=(0, (1, 2)), label=series["reference"])
    _logarithmic(axes, "x", "y")
    _finish(axes, "iteration k, plus 1", "(F - F*) / F*")


def _cost(axes: Axes, series: Mapping[str, Any], what: str = "multiplications") -> None:
    for at, (name, line) in enumerate(series.items()):
        slope = f": slope {float(line['slope']):.2f}"
        axes.plot(
            _numbers(line["x"]),
            _numbers(line["y"]),
            label=_words(name) + slope,
            marker=MARKS[at % 6],
            markersize=4,
            **_line(at),
        )
    _logarithmic(axes, "x", "y")
    axes.xaxis.set_major_locator(LogLocator(2.0, numticks=8))
    _finish(axes, "size (n for step 6, else d)", what)


def _times(axes: Axes, series: Mapping[str, Any]) -> None:
    _cost(axes, series, "seconds")


def _clarabel(axes: Axes, series: Mapping[str, Any]) -> None:
    scales = _numbers(series["scales"])
    named = {"share_off_1e-6": "off by more than 1e-6 F*", "share_off_1e-3": "off by more than 1e-3 F*"}
    for at, (key, label) in enumerate((named | {"share_not_optimal": "not called optimal"}).items()):
        axes.plot(
            scales, 100.0 * _numbers(series[key]), label=label, marker=MARKS[at], markersize=4.5, **_line(at)
        )
    _logarithmic(axes, "x")
    axes.set_ylim(-4, 104)
    fewest, most = min(series["per_scale"]), max(series["per_scale"])
    each = f"{most}" if fewest == most else f"{fewest} to {most}"
    _finish(axes, f"scale ({each} problems each)", "share of the answers, %")


DRAWN: dict[str, tuple[float, Callable[[Axes, Mapping[str, Any]], None]]] = {
    "counterexample": (3.4, _counterexample),
    "distance": (4.0, _distance),
    "rate": (3.6, _rate),
    "cost": (3.6, _cost),
    "times": (3.6, _times),
    "clarabel": (3.4, _clarabel),
}


def _numbers(values: Sequence[Any]) -> np.ndarray:
    return np.array([float(value) for value in values], dtype=np.float64)


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


def _line(at: int) -> dict[str, Any]:
    return {"color": COLORS[at % 6], "linestyle": DASHES[at % 6], "linewidth": 1.5}


def _finish(axes: Axes, x: str, y: str) -> None:
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    axes.grid(color=GRID, linewidth=0.6)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(
        loc="lower left", bbox_to_anchor=(0.0, 1.0), frameon=False, borderaxespad=0.2, handlelength=3.2
    )


def _inline(svg: str, name: str, label: str) -> str:
    """Leave the drawing alone: ids of its own, no declarations, no metadata, no fixed size."""
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r"<metadata>.*?</metadata>\s*|<style.*?</style>\s*", "", svg, flags=re.DOTALL)
    view = re.search(r'viewBox="([^"]*)"', svg)
    if view is None:
        raise ValueError("no viewBox")
    opening = f'<svg class="plot" role="img" aria-label="{html.escape(label)}" viewBox="{view[1]}">'
    svg = re.sub(r"<svg[^>]*>", lambda _: opening, svg, count=1)
    svg = re.sub(r'\bid="', f'id="{name}-', svg)
    svg = re.sub(r'xlink:href="#', f'href="#{name}-', svg)
    return re.sub(r"url\(#", f"url(#{name}-", svg).strip()
