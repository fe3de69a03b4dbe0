"""The figure of outcomes by factor level and part: small stacked bars."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch, Rectangle
from matplotlib.path import Path

from verification.report.drawing import COLORS, INK, QUIET

Data = Mapping[str, Any]
OUTCOMES = ("reproduced", "no_effect", "opposite", "open")
"""Counts of a part, in the order in which a bar is stacked."""
KINDS = (
    ("reproduced", COLORS[0]),
    ("no effect", "#e3c567"),
    ("opposite", COLORS[1]),
    ("open", "#d5dbe1"),
)
"""The same in words, with their colours."""
FACTORS = {
    "lambda1": "lambda1",
    "normalisation": "normalisation",
    "color": "colour histogram",
    "hog": "HOG",
    "lbp": "LBP",
    "size": "picture size",
    "background": "background",
}
"""Factors in the order in which they are shown."""
LEVELS = {
    "unit length by modality": "unit, by modality",
    "sum one by modality": "sum 1, by modality",
    "by channel, 8 bins": "channel, 8 bins",
    "by channel, 32 bins": "channel, 32 bins",
    "joint, 4 bins a channel": "joint, 4 a channel",
    "joint, 8 bins a channel": "joint, 8 a channel",
}
GAP = 1.1
"""Rows between two factors, where the name of the second stands."""
FULL, TALL = 0.84, 0.72
"""Width and height of a bar in its cell."""


def flips(figure: Figure, pictures: Data, design: Data) -> None:
    """Draw shares of configurations: rows are levels of factors, columns are parts of claims."""
    axes, claims = figure.subplots(), pictures["claims"]
    rows = _rows(claims, design)
    boxes: dict[str, list[Any]] = {kind: [] for kind, _ in KINDS}
    for row, (place, _, counts) in enumerate(rows):
        for column, key in enumerate(claims):
            _stack(boxes, column, place, counts[key])
        axes.annotate(
            rows[row][1], (-0.15, place), ha="right", va="center", fontsize=8, annotation_clip=False
        )
    for kind, color in KINDS:
        if boxes[kind]:
            path = Path.make_compound_path_from_polys(np.array(boxes[kind]))
            axes.add_patch(PathPatch(path, facecolor=color, linewidth=0))
    _heads(axes, claims, rows, design)


def factors(design: Data) -> list[tuple[str, list[Any]]]:
    """The factors and their levels, in the order in which they are shown."""
    order = list(FACTORS)
    return sorted(
        design["factors"].items(), key=lambda item: order.index(item[0]) if item[0] in order else 99
    )


def _rows(claims: Data, design: Data) -> list[tuple[float, str, dict[str, Any]]]:
    """Place, name and counts by part: first all that count, then the levels, a gap before each factor."""
    total = {key: [each[name] for name in OUTCOMES] for key, each in claims.items()}
    rows, place = [(0.0, "all that count", total)], 0.0
    for factor, levels in factors(design):
        place += GAP
        for level in levels:
            place += 1.0
            name = level if isinstance(level, str) else f"{level:g}"
            counts = {key: each["levels"][factor][name] for key, each in claims.items()}
            rows.append((place, LEVELS.get(name, name), counts))
    return rows


def _stack(boxes: dict[str, list[Any]], column: int, place: float, counts: list[int]) -> None:
    total, left = sum(counts), float(column)
    for (kind, _), count in zip(KINDS, counts, strict=True):
        if count:
            right = left + FULL * count / total
            low, high = place - TALL / 2.0, place + TALL / 2.0
            boxes[kind].append([[left, low], [right, low], [right, high], [left, high]])
            left = right


def _heads(axes: Axes, claims: Data, rows: list[tuple[float, str, dict[str, Any]]], design: Data) -> None:
    """Parts above, factors at the left in bold, no frame."""
    place = 0.0
    for factor, levels in factors(design):
        place += GAP
        axes.annotate(
            FACTORS.get(factor, factor),
            (-0.15, place + 0.1),
            ha="right",
            va="center",
            fontsize=8,
            fontweight="bold",
            color=INK,
            annotation_clip=False,
        )
        place += len(levels)
    for column, key in enumerate(claims):
        claim, _, part = key.partition("/")
        named = claim if part == "stated" else f"{claim} {part}"
        at = (column + FULL / 4.0, -0.8)
        axes.annotate(
            named, at, ha="left", va="bottom", rotation=50, rotation_mode="anchor", fontsize=8.5,
            annotation_clip=False,
        )  # fmt: skip
    for number, (kind, color) in enumerate(KINDS):
        left, low = 4.0 * number + 0.1, rows[-1][0] + 1.6
        box = Rectangle((left, low - TALL / 2.0), 0.5, TALL, facecolor=color, linewidth=0)
        axes.add_patch(box)
        axes.annotate(kind, (left + 0.7, low), ha="left", va="center", annotation_clip=False)
    axes.set_xlim(-0.05, len(claims))
    axes.set_ylim(rows[-1][0] + 2.2, -0.6)
    axes.set_xticks([])
    axes.set_yticks([])
    axes.tick_params(colors=QUIET)
    axes.spines[:].set_visible(False)
