"""Whether a point is within a tolerance of the optimum, by exact numbers and balls.

A point is accused where F there exceeds F at another rational point by more than

    tolerance F(other) + absolute + allowance,

and acquitted where it exceeds a proved lower bound of F* by no more than that. The allowance is for
float64: a share of |A| |z| + |d|, the size of what each part is computed from, as it changes F. It is
smaller for an acquittal than for an accusation; between the two, nothing is said.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from flint import fmpq

from convexperc.errors import ToleranceError
from verification.exact.balls import Numbers, UnresolvedError, enclosed, exact, inner, precision
from verification.exact.numbers import Enclosure, square_root
from verification.reweighted.answers import Word
from verification.reweighted.objectives.conjugates import Growth, NotCoveredError, blocks
from verification.reweighted.objectives.objective import Objective, rational_point
from verification.reweighted.objectives.optimum import Optimum, optimum
from verification.reweighted.objectives.system import BITS
from verification.reweighted.terms.expressions import fraction

ACCUSING = 2.0**-30
"""Share of the size of the data below which no difference accuses: 1e-9, far above float64's rounding.

It is the relative tolerance where that is larger: where the data fit perfectly, F* is 0, and a program is not
held to more digits of F than it promises of the data."""

ACQUITTING = 2.0**-44
"""Share of the size of the data that float64's rounding is granted for an acquittal."""


@dataclass(frozen=True)
class Rule:
    """What a program promises.

    Parameters
    ----------
    tolerance : float
        Relative to F*.
    absolute : float
        In the unit of F.

    Raises
    ------
    ToleranceError
        One is no finite number >= 0.
    """

    tolerance: float = 1e-6
    absolute: float = 0.0

    def __post_init__(self) -> None:
        for name in ("tolerance", "absolute"):
            value = getattr(self, name)
            if (
                isinstance(value, bool)
                or not isinstance(value, (int, float))
                or not 0 <= value < float("inf")
            ):
                raise ToleranceError(name, value=value, must="must be a finite number >= 0")

    def __str__(self) -> str:
        """In words."""
        parts = [f"{self.tolerance:g} relative"] if self.tolerance or not self.absolute else []
        return " and ".join(parts + ([f"{self.absolute:g} absolute"] if self.absolute else []))

    def allows(self, value: Fraction, allowance: Fraction) -> Fraction:
        """The largest F that is within the tolerance of `value`."""
        return value * (1 + Fraction(self.tolerance)) + Fraction(self.absolute) + allowance


@dataclass(frozen=True)
class Verdict:
    """What is proved of one point.

    Attributes
    ----------
    word : Word
        YES: within the tolerance; NO: beyond it.
    value : Enclosure or None
        F at the point; None where balls do not tell.
    best : Optimum or None
    other : mapping of str to sequences of numbers
        The other point of an accusation: of float64 numbers where they show it.
    other_value : Fraction or None
        At least F there.
    reason : str
        Why it is undecided.
    """

    word: Word
    value: Enclosure | None = None
    best: Optimum | None = None
    other: Mapping[str, Sequence[Any]] | None = None
    other_value: Fraction | None = None
    reason: str = ""

    @property
    def excess(self) -> float:
        """How far F may lie above F*, F/lower - 1; infinite where no lower bound above 0 is known."""
        if self.value is None or self.best is None or not self.best.lower:
            return 0.0 if self.value is not None and self.value.upper == 0 else float("inf")
        return rounded(self.value.upper / self.best.lower - 1)


def verdict(
    objective: Objective, values: Mapping[str, Any], rule: Rule, best: Optimum | None = None
) -> Verdict:
    """Judge a point of finite numbers.

    Parameters
    ----------
    objective : Objective
    values : mapping of str to arrays
    rule : Rule
    best : Optimum, optional
        Of the objective, if it is known.
    """
    try:
        value, best = value_at(objective, values), best or optimum(objective)
    except (NotCoveredError, UnresolvedError) as fault:
        return Verdict(Word.UNDECIDED, reason=str(fault))
    shares = max(ACCUSING, rule.tolerance), ACQUITTING
    accusing, acquitting = (allowance(objective, best.point, share) for share in shares)
    if best.lower is not None and value.upper <= rule.allows(best.lower, acquitting):
        return Verdict(Word.YES, value, best)
    if value.lower <= rule.allows(best.upper, accusing):
        close = "It is not beyond the tolerance by more than rounding may explain."
        return Verdict(Word.UNDECIDED, value, best, reason=best.reason or close)
    other = {name: [float(x) for x in entries] for name, entries in best.point.items()}
    upper = value_at(objective, other).upper
    if value.lower > rule.allows(upper, accusing):
        return Verdict(Word.NO, value, best, other, upper)
    return Verdict(Word.NO, value, best, best.point, best.upper)


def value_at(objective: Objective, values: Mapping[str, Any]) -> Enclosure:
    """F at a point of finite numbers, between two rationals.

    Raises
    ------
    UnresolvedError
        Balls do not tell.
    """
    with precision(BITS):
        return enclosed(objective.at(rational_point(values)))


def allowance(objective: Objective, point: Mapping[str, Sequence[Any]], share: float) -> Fraction:
    """By how much F may change where each |A| |z| + |d| changes by this share of itself."""
    z = [exact(x) for name in objective.sizes for x in point[name]]
    total = Fraction(0)
    for block in blocks(objective):
        terms = [
            [*(a * x for a, x in zip(row, z, strict=True)), b]
            for row, b in zip(block.rows, block.offset, strict=True)
        ]
        change = Fraction(share) * _length([sum(map(abs, each), fmpq(0)) for each in terms])
        length = _length([sum(each, fmpq(0)) for each in terms])
        total += max(_change(growth, length, change) for growth in block.growths)
    return total


def _length(values: Numbers) -> Fraction:
    """At least the norm."""
    return square_root(fraction(inner(values, values))).upper


def _change(growth: Growth, length: Fraction, change: Fraction) -> Fraction:
    """The most that a loss changes where its residual of this length does by `change`."""
    found = []
    if growth.radius is not None:
        found.append(fraction(growth.radius) * change)
    if growth.curve is not None:
        found.append(fraction(growth.curve) * (2 * length * change + change**2))
    return min(found)


def rounded(value: Fraction) -> float:
    """A rational in float64, for display; infinite where it is too large."""
    try:
        return float(value)
    except OverflowError:
        return float("inf")
