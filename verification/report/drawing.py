"""What all figures of the report share: colours, marks, letters, and the way to inline SVG.

Small, self-contained, the same bytes for the same numbers.
"""

import html
import io
import re
import warnings
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from convexperc.report.canvas import settings

INK, QUIET, GRID = "#1b2530", "#4d5a68", "#e3e7eb"
COLORS = ("#0072b2", "#d55e00", "#009e73", "#b0568f", "#56707f", "#a86b00")
"""Okabe and Ito's, the light ones darkened; marks and dashes tell them apart as well."""
MARKS = "os^Dvx"
DASHES: tuple[Any, ...] = ("-", (0, (5, 2)), (0, (2, 1.5)), (0, (7, 2, 1.5, 2)), (0, (1, 1.5)), (0, (9, 3)))
WIDTH = 4.7
"""Inches; 450 pixels, so that 10 point letters stay readable on a phone."""
STYLE: dict[Any, Any] = {
    "font.size": 10.0,
    "text.parse_math": False,  # a dollar sign in a name is one
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
    "path.simplify": True,
}


def drawn(draw: Callable[[Figure], None], height: float, name: str, label: str) -> str:
    """Draw a figure as inline SVG.

    Parameters
    ----------
    draw : callable
        Fills the figure.
    height : float
        In inches; the width is `WIDTH`.
    name : str
        Prefix of every id in the SVG, so that several fit on one page.
    label : str
        What a reader who cannot see it is told.
    """
    with settings(STYLE), warnings.catch_warnings():
        warnings.filterwarnings("ignore", message=r"Glyph \d+", category=UserWarning)
        figure = Figure(figsize=(WIDTH, height), layout="constrained", facecolor="white")
        FigureCanvasAgg(figure)
        draw(figure)
        out = io.StringIO()
        figure.savefig(out, format="svg", metadata={"Date": None})
    return _inline(out.getvalue(), name, label)


def numbers(values: Sequence[Any]) -> Float[np.ndarray, " k"]:
    """Numbers; "inf", "-inf" and "nan" may stand for them."""
    return np.array([float(value) for value in values], dtype=np.float64)


def line(at: int) -> dict[str, Any]:
    """Colour, dash and width of the line with this number."""
    return {"color": COLORS[at % 6], "linestyle": DASHES[at % 6], "linewidth": 1.5}


def frame(axes: Axes, x: str, y: str) -> None:
    """Titles of the axes, a quiet grid."""
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    axes.grid(color=GRID, linewidth=0.6)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)


def finish(axes: Axes, x: str, y: str) -> None:
    """The same, and the legend above."""
    frame(axes, x, y)
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
