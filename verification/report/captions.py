"""Titles and captions of the figures of the report."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Figure:
    """A figure of the report.

    Attributes
    ----------
    name : str
        Key of the series that it draws.
    claim : str
        The claim that it belongs to.
    title, caption : str
    """

    name: str
    claim: str
    title: str
    caption: str


OVERVIEW = Figure(
    "overview",
    "T1a",
    "F by iteration, printed and corrected update",
    "F by iteration on the smallest counterexample, both updates from the same start. The minimum F* lies"
    " in the gray band, its proved interval, which is narrower here than the line.",
)
"""On the first screen; its numbers are two curves of the series "counterexample"."""

FIGURES = (
    Figure(
        "counterexample",
        "T1a",
        "The smallest counterexample, iteration by iteration",
        "F at each iteration for every variant of the update, from the same start. The gray band is an"
        " interval that is proved to contain the minimum F*. Equal curves lie one over the other: absolute"
        " and appendix half; corrected, appendix full and smoothed.",
    ),
    Figure(
        "distance",
        "T1b",
        "Where the iteration ends",
        "Each row is one update variant in one order (GS: Gauss-Seidel). The darker a cell, the larger the"
        " share of its runs that ended at that relative distance, (F(last) - F*)/F*. The vertical line is"
        " the tolerance; the first cell holds all runs that ended at 1e-16 or below, the last all beyond"
        " 100. On the right: runs whose distance is known + undecided runs + runs without an end, whose"
        " system was singular or that diverged.",
    ),
    Figure(
        "rate",
        "T1c",
        "How fast the corrected update converges",
        "(F - F*)/F* by iteration, both axes logarithmic. A straight line is a power of the iteration; a"
        " curve that bends down is faster than every power. Values of 0 or below, where rounding ends the"
        " curve, are not drawn. The dotted line 1/(2k+1)^2 is proved to lie below the curve of the corrected"
        " update where one zero is not strict.",
    ),
    Figure(
        "cost",
        "C1",
        "Multiplications by size",
        "Multiplications of one step, counted by running it on numbers that count their operations; both axes"
        " logarithmic. The slope is the measured exponent. The curves of steps 6 and 7 coincide.",
    ),
    Figure(
        "clarabel",
        "S1",
        'Answers with the status "optimal", by the scale of the data',
        "The scale multiplies o, lambda2 and lambda3; it multiplies F* by its square and changes nothing"
        " else. Shown are the shares of the answers that lie outside the proved interval of F* by more than"
        " the stated part of F*, and of those that are not called optimal.",
    ),
)

TIMES = Figure(
    "times",
    "C1",
    "Measured times by size",
    "Seconds of the same steps on this machine, both axes logarithmic.",
)

NOT_RUN = "Not run in this profile."
