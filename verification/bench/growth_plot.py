"""The growth of the cost with n, d, m and p as one figure; layout alone."""

import io
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from convexperc.report.canvas import settings
from verification.bench.floor import BASE, Growth

INK, QUIET = "#1d2733", "#6b7683"
SERIES = (("floor", "#6b7683", "o", "Gram and X O"), ("solve", "#0b6fb8", "s", "all templates solved"))
WORDS = {"n": "robots n", "d": "features d", "m": "modalities m", "p": "templates p"}


def growth_plot(found: Sequence[Growth], kind: str) -> bytes:
    """Draw the times with the power laws that fit them; `kind` is ``"png"`` or ``"svg"``."""
    with settings({"text.color": INK, "svg.hashsalt": "convexperc"}):
        figure = Figure(figsize=(11.0, 3.6), layout="constrained", facecolor="white")
        FigureCanvasAgg(figure)
        axes = figure.subplots(1, len(found), squeeze=False, sharey=True)[0]
        for place, line in zip(axes, found, strict=True):
            _panel(place, line)
        axes[0].set_ylabel("milliseconds a frame", fontsize=9, color=QUIET)
        sizes = f"n = {BASE.n}, d = {BASE.d}, m = {len(BASE.sizes)}, p = {BASE.p}"
        figure.suptitle(
            f"Growth of the cost, one size at a time from {sizes}", fontsize=11, x=0.01, ha="left"
        )
        out = io.BytesIO()
        figure.savefig(out, format=kind, dpi=150, metadata={"Date": None} if kind == "svg" else None)
        return out.getvalue()


def _panel(place: Axes, line: Growth) -> None:
    values = np.array(line.values, dtype=np.float64)
    for (name, color, marker, label), exponent in zip(SERIES, line.exponents, strict=True):
        times = 1e3 * np.array(getattr(line, name))
        middle = np.exp(np.log(times).mean() - exponent * np.log(values).mean())
        place.plot(values, times, marker, color=color, markersize=6)
        text = f"{label}: {line.size}^{exponent:.2f}"
        place.plot(values, middle * values**exponent, color=color, linewidth=1.2, label=text)
    place.set(xscale="log", yscale="log")
    place.set_xticks(values, [str(value) for value in line.values], fontsize=8)
    place.minorticks_off()
    place.set_xlabel(WORDS[line.size], fontsize=9, color=QUIET)
    place.tick_params(labelsize=8, colors=QUIET)
    place.spines[["top", "right"]].set_visible(False)
    place.legend(fontsize=8, frameon=False, loc="lower left", bbox_to_anchor=(0.0, 1.0))
