"""The figure of a recognition: the ranked views, the modalities and the optimum of every object."""

import io
import math
import textwrap
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import UInt8
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from convexperc.features.decoding.sizes import MIN_SIDE
from convexperc.features.pictures import Picture, resize
from convexperc.recognition.calibration import Judgement
from convexperc.recognition.decision import Decision
from convexperc.recognition.recognition import Ranked, Recognition
from convexperc.report.canvas import drawable, settings
from convexperc.report.tables import labelled, percents, stated
from convexperc.solution.solution import Status

WIDTH, MARGIN, GUTTER = 11.0, 0.35, 0.18
"""Width of the figure, of its margins and of the gaps between views, in inches: a landscape page."""
CELL_WIDTH, PICTURE_HEIGHT = 2.15, 1.48
"""Largest width of a view with its gap and largest height of its picture, in inches."""
COLUMNS = 6
"""Largest number of views in a row: with more, their captions do not fit."""
NAME_HEIGHT, CAPTION_HEIGHT = 0.24, 0.56
"""Space above a picture for the view's name, and below it for its weight, in inches."""
ROW_HEIGHT, HEADING_HEIGHT = 0.34, 0.95
"""Height of a row of the panels, and of their headings with the axis, in inches."""
MOST_VIEWS, MOST_BARS = 24, 16
"""Largest numbers of views and of rows in a panel: more make the figure longer than a page."""
LONGEST_SIDE = 360
"""Side in pixels to which pictures are reduced: slightly more than a cell has at 150 dots per inch."""
INK, QUIET, LINE, FAINT = "#1d2733", "#6b7683", "#d5dae0", "#eceef1"
"""Colours of text, of secondary text, of lines and of the background of bars."""
ACCENT, ALARM = "#0b6fb8", "#b3261e"
"""Colours of bars and candidates, and of warnings."""
STYLE: dict[Any, Any] = {
    "text.color": INK,
    "svg.hashsalt": "convexperc",
    "svg.fonttype": "path",
    "text.parse_math": False,
}
"""Matplotlib's settings beside `canvas.settings`; salt and paths make the bytes reproducible. A dollar sign
in a name is no formula."""


def draw(
    recognition: Recognition, views: Mapping[str, Picture], kind: str, judgement: Judgement | None
) -> bytes:
    """Draw a recognition whose arguments `convexperc.report.picture.recognition_picture` has validated."""
    with settings(STYLE):
        sheet = _Sheet.of(recognition, views)
        _title(sheet, recognition, judgement)
        return _draw(sheet, recognition, views, kind)


@dataclass(frozen=True)
class _Sheet:
    """The layout, in inches from the top left corner."""

    figure: Figure
    height: float
    shown: int
    columns: int
    cell: float
    picture: float
    panels: float

    @classmethod
    def of(cls, recognition: Recognition, views: Mapping[str, Picture]) -> "_Sheet":
        shown = min(len(recognition.views), MOST_VIEWS)
        rows = math.ceil(shown / COLUMNS)
        columns = math.ceil(shown / rows)
        cell = min(CELL_WIDTH, (WIDTH - 2 * MARGIN + GUTTER) / columns)
        tallest = max(views[name].shape[0] / views[name].shape[1] for name in recognition.views)
        picture = min(PICTURE_HEIGHT, tallest * (cell - GUTTER))
        panels = 1.55 + rows * (NAME_HEIGHT + picture + CAPTION_HEIGHT)
        bars = max(len(recognition.objects), len(recognition.ranked_modalities()), 3)
        height = (
            panels + HEADING_HEIGHT + ROW_HEIGHT * min(bars, MOST_BARS) + 0.3 * bool(recognition.warnings)
        )
        figure = Figure(figsize=(WIDTH, height), dpi=150, facecolor="white")
        FigureCanvasAgg(figure)
        return cls(figure, height, shown, columns, cell, picture, panels)

    def axes(self, left: float, top: float, width: float, height: float) -> Axes:
        box = left / WIDTH, 1.0 - (top + height) / self.height, width / WIDTH, height / self.height
        return self.figure.add_axes(box)

    def text(self, left: float, top: float, text: str, size: float, **style: Any) -> None:
        self.figure.text(left / WIDTH, 1.0 - top / self.height, text, fontsize=size, va="baseline", **style)

    def bar(self, left: float, top: float, width: float, height: float, color: str) -> None:
        corner = left / WIDTH, 1.0 - (top + height) / self.height
        size = width / WIDTH, height / self.height
        self.figure.add_artist(Rectangle(corner, *size, color=color, linewidth=0))

    def corner(self, place: int) -> tuple[float, float]:
        """Return left and top of the view at this place of the ranking."""
        row, column = divmod(place, self.columns)
        return MARGIN + column * self.cell, 1.4 + row * (NAME_HEIGHT + self.picture + CAPTION_HEIGHT)


def _draw(sheet: _Sheet, recognition: Recognition, views: Mapping[str, Picture], kind: str) -> bytes:
    ranking, rules = recognition.ranked_views(), recognition.rules
    nearest = dict(zip(recognition.views, rules.nearest, strict=True))
    for place, view in enumerate(ranking[: sheet.shown]):
        other = nearest[view.name] if view.name in rules.disagreeing else None
        _view(sheet, place, view, views[view.name], other)
    best = recognition.candidates[0]
    _modalities(sheet, recognition.ranked_modalities()[:MOST_BARS], best)
    _objectives(sheet, recognition)
    if recognition.warnings:
        warning = textwrap.shorten(
            "Warning: " + drawable(" ".join(recognition.warnings)), 165, placeholder=" …"
        )
        sheet.text(MARGIN, sheet.height - 0.16, warning, 7.5, color=ALARM)
    stream = io.BytesIO()
    metadata = {"Date": None} if kind == "svg" else None
    sheet.figure.savefig(stream, format=kind, metadata=metadata, dpi=150)
    return stream.getvalue()


def _title(sheet: _Sheet, recognition: Recognition, judgement: Judgement | None) -> None:
    head, color = f"No label: {recognition.verdict.value}", ALARM
    if recognition.label is not None:
        head, color = _fitted(recognition.label, WIDTH - 2 * MARGIN, 21.0), INK
    if judgement is not None and judgement.accepted != (recognition.label,):
        head, color = judgement.acceptance.value.capitalize(), ALARM
        if judgement.accepted:
            head = _fitted(f"{head}: {' or '.join(judgement.accepted)}", WIDTH - 2 * MARGIN, 21.0)
    sheet.text(MARGIN, 0.48, head, 19.0, weight="bold", color=color)
    line = stated(recognition)
    if recognition.label is not None:
        line += f": {labelled(recognition)}"
    lines = line, " · ".join(_facts(recognition, judgement))
    for top, line in zip((0.74, 0.94), lines, strict=True):
        shown = textwrap.shorten(drawable(line), 150, placeholder=" …")
        sheet.text(MARGIN, top, shown, 9.5, color=QUIET)
    heading = f"Views by weight |w|, for {_fitted(recognition.candidates[0], 4.5, 10.0)}"
    if len(recognition.views) > sheet.shown:
        heading += f"; the first {sheet.shown} of {len(recognition.views)}"
    sheet.text(MARGIN, 1.22, heading, 10.0, weight="bold")


def _facts(recognition: Recognition, judgement: Judgement | None) -> list[str]:
    """The margin, the share explained, and what a calibration says."""
    facts = list[str]()
    if recognition.margin is not None:
        facts.append(f"{percents(recognition.margin)} below the runner-up {recognition.runner_up}")
    facts += [f"{percents(recognition.explained)} explained"]
    facts.append("not judged" if judgement is None else f"{judgement.acceptance.value} by the calibration")
    return facts


def _view(sheet: _Sheet, place: int, view: Ranked, picture: Picture, other: str | None) -> None:
    left, top = sheet.corner(place)
    width = sheet.cell - GUTTER
    sheet.text(left, top + 0.16, f"{place + 1}  {_fitted(view.name, width - 0.25, 9.0)}", 9.0)
    axes = sheet.axes(left, top + NAME_HEIGHT, width, sheet.picture)
    axes.imshow(_small(picture), alpha=0.3 if view.proved_zero else 1.0, interpolation="antialiased")
    axes.set_anchor("NW")
    axes.set_axis_off()
    below = top + NAME_HEIGHT + sheet.picture
    sheet.bar(left, below + 0.07, width, 0.06, LINE)
    sheet.bar(left, below + 0.07, width * view.share, 0.06, ACCENT)
    if view.proved_zero:
        sheet.text(left, below + 0.29, "proved zero", 8.5, color=QUIET, style="italic")
    else:
        sheet.text(left, below + 0.29, f"{100 * view.share:.1f} %   w = {view.weight:+.3g}", 8.5)
    if other is not None:
        sheet.text(left, below + 0.45, f"nearest to {_fitted(other, width - 0.7, 8.5)}", 8.5, color=ALARM)


def _modalities(sheet: _Sheet, ranking: tuple[Ranked, ...], best: str) -> None:
    left, width, label, top = MARGIN, 3.9, 1.15, sheet.panels + 0.35
    heading = f"Modalities by ||uⁱ||, for {_fitted(best, 1.6, 10.0)}"
    sheet.text(left, sheet.panels + 0.2, heading, 10.0, weight="bold")
    largest = max(entry.weight for entry in ranking) or 1.0
    for row, entry in enumerate(ranking):
        place = left + label, top + ROW_HEIGHT * (row + 0.25)
        longest, color = width - label - 1.0, QUIET if entry.proved_zero else ACCENT
        sheet.bar(*place, longest, 0.5 * ROW_HEIGHT, FAINT)
        sheet.bar(*place, longest * entry.weight / largest, 0.5 * ROW_HEIGHT, color)
        line = top + ROW_HEIGHT * (row + 0.5) + 0.045
        sheet.text(left, line, _fitted(entry.name, label - 0.1, 9.0), 9.0)
        if entry.proved_zero:
            sheet.text(left + width - 0.92, line, "proved zero", 8.5, color=QUIET, style="italic")
        else:
            sheet.text(left + width - 0.92, line, f"{entry.weight:.3g}", 8.5)


def _objectives(sheet: _Sheet, recognition: Recognition) -> None:
    rows = sorted(recognition.best_templates, key=lambda template: template.cost[1])[:MOST_BARS]
    left, label, numbers, top = 4.6, 1.55, 2.25, sheet.panels + 0.35
    width = WIDTH - MARGIN - left
    heading = "Optimum F* of each object, lowest first"
    if recognition.decision is Decision.EXPLAINED_FRACTION:
        heading = "Share F*/||o||² that each object leaves, lowest first"
    sheet.text(left, sheet.panels + 0.2, heading, 10.0, weight="bold")
    sheet.text(left + width - 0.78, sheet.panels + 0.2, "proved within", 8.0, color=QUIET)
    axes = sheet.axes(left + label, top, width - label - numbers, ROW_HEIGHT * len(rows))
    for row, template in enumerate(rows):
        lower, upper = template.cost
        color = ACCENT if template.object in recognition.candidates else QUIET
        axes.plot([0, lower], [row, row], color=LINE, linewidth=1.2, zorder=1)
        ends = [[upper - lower], [0.0]]
        axes.errorbar(upper, row, xerr=ends, fmt="o", color=color, markersize=6, capsize=2.5)
        line = top + ROW_HEIGHT * (row + 0.5) + 0.045
        weight = "bold" if template.object == recognition.label else "normal"
        sheet.text(left, line, _fitted(template.name, label - 0.12, 9.0), 9.0, color=color, weight=weight)
        sheet.text(left + width - numbers + 0.2, line, _digits(lower, upper), 8.5)
        sound = template.excluded or template.status is Status.CERTIFIED
        sheet.text(left + width - 0.78, line, f"{upper - lower:.1e}", 8.5, color=INK if sound else ALARM)
    axes.set(ylim=(len(rows) - 0.5, -0.5), yticks=[])
    axes.set_xlim(left=0.0)
    axes.tick_params(axis="x", labelsize=7.5, color=LINE, labelcolor=QUIET)
    for side, spine in axes.spines.items():
        spine.set_visible(side == "bottom")
        spine.set_color(LINE)


def _digits(lower: float, upper: float) -> str:
    """Format the upper bound, with no more digits than the interval's width makes significant."""
    width = upper - lower
    digits = 12 if width == 0.0 else min(12, max(2, math.floor(math.log10(upper / width))))
    return f"{upper:#.{digits}g}"


def _fitted(text: str, inches: float, size: float) -> str:
    """Escape a name and shorten it in the middle to a width in inches, at a font size in points."""
    text = drawable(text)
    room = max(5, math.floor(inches * 72 / (0.6 * size)))
    if len(text) <= room:
        return text
    tail = (room - 1) // 3
    return f"{text[: room - 1 - tail]}…{text[-tail:]}"


def _small(picture: Picture) -> UInt8[np.ndarray, "rows columns 3"]:
    """Reduce a picture to the pixels that the figure shows."""
    height, width = picture.shape[:2]
    scale = LONGEST_SIDE / max(height, width)
    if scale >= 1.0:
        return picture
    return resize(picture, (max(MIN_SIDE, round(height * scale)), max(MIN_SIDE, round(width * scale))))
