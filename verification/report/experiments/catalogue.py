"""The figures of one set of pictures, in their order, with titles, captions and what a listener is told."""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

from matplotlib.figure import Figure as Canvas

from convexperc.errors import InputError
from verification.report.drawing import drawn
from verification.report.experiments import figures, flips, weights
from verification.report.experiments.compact import compact

Data = Mapping[str, Any]
Draw = Callable[[Canvas, Data, Data], None]
LOOK = ".plot{background:#fff;font-family:sans-serif}.plot *{stroke-linejoin:round;stroke-linecap:butt}"
"""Of a file of its own; a page has its own style sheet."""


@dataclass(frozen=True, slots=True)
class Drawing:
    """One figure, drawn.

    Attributes
    ----------
    name : str
        Also of its file.
    title, caption : str
    svg : str
        For a page; ids begin with the name.
    """

    name: str
    title: str
    caption: str
    svg: str

    @property
    def standalone(self) -> str:
        """The same as a file of its own."""
        size = re.search(r'viewBox="0 0 ([\d.]+) ([\d.]+)"', self.svg)
        if size is None:
            raise ValueError("no viewBox")
        opening = f'<svg xmlns="http://www.w3.org/2000/svg" width="{size[1]}pt" height="{size[2]}pt"'
        svg = self.svg.replace("<svg", opening, 1).replace(">", f"><style>{LOOK}</style>", 1)
        return f'<?xml version="1.0" encoding="utf-8"?>\n{svg}\n'


@dataclass(frozen=True, slots=True)
class _Plan:
    name: str
    height: float
    draw: Draw
    title: str
    caption: str
    needs: str = ""


PLANS = (
    _Plan(
        "accuracy",
        3.7,
        figures.accuracy,
        "Accuracy by the number of views",
        "Default configuration. Lines with marks are the settings (lambda2, lambda3) with 95 % intervals over"
        " objects and scenes, each for itself; marks are moved sideways to be told apart. Broken gray lines"
        " are the baselines on the same views. A tie or an undecided label scores what a fair draw among its"
        " candidates would.",
    ),
    _Plan(
        "gain",
        2.7,
        figures.gain,
        "Gain over lambda2 = lambda3 = 0, in all configurations",
        "Score minus that of (0, 0) on the same views, in points of a hundred. Line: median of the"
        " configurations; dark band: nine tenths of them; pale band: all. The dotted line is the smallest"
        " effect of interest, one point: X2 needs every gain above 0 from two views on. The scale is linear"
        " within one point on either side of 0 and logarithmic beyond, so that a few configurations with"
        " large losses do not hide the others.",
    ),
    _Plan(
        "spread",
        4.2,
        figures.spread,
        "Accuracy in all configurations",
        "One panel for each setting (lambda2, lambda3). Line: median of the configurations; dark band: nine"
        " tenths of them; pale band: all; marks: the default configuration.",
    ),
    _Plan(
        "flips",
        6.4,
        flips.flips,
        "Which configurations decide which claim",
        "Each small bar is split by the share of the configurations with that level in which the part is"
        " reproduced, shows no effect, shows the opposite, or stays open. A column whose bars change from row"
        " to row depends on what the paper leaves open. Configurations that keep the background count; the"
        " last row shows the others. There is no bar where no scene defines the statistic.",
    ),
    _Plan(
        "lambdas",
        3.6,
        figures.lambdas,
        "Accuracy over the two lambdas",
        "Default configuration: mean score, in %, of the first repetition at n = 3 and of all six views.",
    ),
    _Plan(
        "information",
        3.0,
        figures.information,
        "Mutual information by rank",
        "Default configuration, (0.1, 0.1): mean mutual information of the gray values of a view and of the"
        " reference, for the views ranked 1 to 6 by |w|, with 95 % intervals over objects and scenes.",
    ),
    _Plan(
        "weights",
        3.0,
        weights.views,
        "One case: weights of the views and of the modalities",
        "Default configuration, (0.1, 0.1), the true object. Orange bars are views whose object is hidden by"
        " an obstacle, hatched ones partly.",
    ),
    _Plan(
        "features",
        4.2,
        weights.features,
        "The same case: weights of the features",
        "All entries of u in one scale. A stroke that stands for several columns shows their range.",
        needs="u",
    ),
)


def main_drawing(found: Data) -> Drawing:
    """Draw the figure that stands for all others: accuracy on the set that decides.

    Parameters
    ----------
    found : mapping
        See `verification.report.experiments.summary.summary`.

    Raises
    ------
    InputError
        The record has another shape than the figure needs.
    """
    return _drawing(PLANS[0], found["sets"][0], found["design"])


def drawings(pictures: Data, design: Data) -> list[Drawing]:
    """Draw the figures of one set.

    Parameters
    ----------
    pictures : mapping
        A set of `verification.report.experiments.summary.summary`.
    design : mapping

    Raises
    ------
    InputError
        The record has another shape than a figure needs.
    """
    case = pictures["default"]["case"]
    return [_drawing(plan, pictures, design) for plan in PLANS if not plan.needs or plan.needs in case]


def _drawing(plan: _Plan, pictures: Data, design: Data) -> Drawing:
    name = f"{pictures['name']}-{plan.name}"
    caption = f"{plan.caption} Pictures: {pictures['name']}."
    label = f"{plan.title}. {caption}"
    try:
        svg = drawn(partial(_draw, plan, pictures, design), plan.height, name, label)
    except (KeyError, TypeError, ValueError, IndexError) as problem:
        must = "must have the shape that its figure draws"
        raise InputError(f"experiments, {name}", value=str(problem), must=must) from None
    return Drawing(name, plan.title, caption, compact(svg))


def _draw(plan: _Plan, pictures: Data, design: Data, canvas: Canvas) -> None:
    plan.draw(canvas, pictures, design)
