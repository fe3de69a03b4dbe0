"""A proved interval for the optimal value of a cone program, from an answer of any solver."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from convexperc.conic.boxes import level_box
from convexperc.conic.curvature import curvature
from convexperc.conic.dual import Terms, lower_bound
from convexperc.conic.primal import Repair, upper_bound
from convexperc.conic.program import BITS, ConeProgram, Floats, NoBoundError, exact
from convexperc.enclosure.balls import float_below, precision

MARGINS = (4.0, 400.0, 40000.0)
"""By how many times the worst violation the constraints are tightened, one after the other."""
LEAST_MARGIN, MOST_MARGIN = 1e-11, 1e-2
"""Of a tightened row, in its units."""

Again = Callable[[Floats], Floats | None]
"""Solve the program with another b; None where that has no answer."""


@dataclass(frozen=True)
class ConicInterval:
    """What is proved of an optimal value p*; rounding is included.

    Attributes
    ----------
    lower, upper : float
        lower <= p* <= upper, in the units of the objective; infinite where nothing is proved. p* is infinite
        where no point is feasible.
    relative_tolerance : float
        Certified means that relative_gap is at most this.
    no_lower, no_upper : str
        Why there is no such bound; empty where there is one.
    """

    lower: float
    upper: float
    relative_tolerance: float
    no_lower: str = ""
    no_upper: str = ""

    @property
    def relative_gap(self) -> float:
        """(upper - lower) / the least |p*| there, rounded up; 0 where both are equal, infinite at p* = 0."""
        if self.lower == self.upper:
            return 0.0
        least = max(self.lower, -self.upper, 0.0)
        width = math.nextafter(self.upper - self.lower, math.inf)
        return math.nextafter(width / least, math.inf) if least > 0.0 and math.isfinite(width) else math.inf

    @property
    def certified(self) -> bool:
        """Whether relative_gap is within the tolerance."""
        return self.relative_gap <= self.relative_tolerance

    @property
    def statement(self) -> str:
        """The interval in a line, with the reasons where a side is missing."""
        reasons = [f"no {side} bound: {why}" for side, why in self._missing if why]
        known = f"{self.lower:.17g} <= p* <= {self.upper:.17g}"
        return "; ".join([known, *reasons]) if reasons else known

    @property
    def _missing(self) -> tuple[tuple[str, str], ...]:
        return ("lower", self.no_lower), ("upper", self.no_upper)

    def negated(self) -> "ConicInterval":
        """Return the interval of -p*."""
        return replace(
            self, lower=-self.upper, upper=-self.lower, no_lower=self.no_upper, no_upper=self.no_lower
        )


def nothing(reason: str, relative_tolerance: float) -> ConicInterval:
    """Return the interval that says nothing, and why."""
    return ConicInterval(-math.inf, math.inf, relative_tolerance, reason, reason)


def prove(
    program: ConeProgram, x: Floats, z: Floats, again: Again, relative_tolerance: float
) -> ConicInterval:
    """Bound the optimal value of a cone program from an answer.

    Parameters
    ----------
    program : ConeProgram
    x : float64 (n,)
        The answer; wherever it comes from.
    z : float64 (m,)
        Its dual.
    again : callable
        From a b (m,) to the x of the program with that b, or None.
    relative_tolerance : float
    """
    if not (np.isfinite(x).all() and np.isfinite(z).all()):
        return nothing("the solver's answer is not finite", relative_tolerance)
    with precision(BITS):
        upper, no_upper = _upper(program, x, again)
        lower, no_lower = _lower(program, x, z, upper)
    if lower > upper:
        return nothing(
            "the two bounds contradict each other: an assumption on the machine fails", relative_tolerance
        )
    return ConicInterval(lower, upper, relative_tolerance, no_lower, no_upper)


def _upper(program: ConeProgram, x: Floats, again: Again) -> tuple[float, str]:
    """The objective at a feasible point, or why none is known."""
    try:
        repair = Repair.of(program)
        found, violated = _attempt(repair, x)
        for times in MARGINS:
            if found < math.inf or not repair.hard:
                break
            margin = min(max(times * violated, times * LEAST_MARGIN), MOST_MARGIN)
            other = again(repair.tightened(margin))
            if other is not None and np.isfinite(other).all():
                found, _ = _attempt(repair, other)
    except NoBoundError as reason:
        return math.inf, str(reason)
    return (
        found,
        "" if found < math.inf else f"no point was proved feasible; the answer misses by {violated:.1e}",
    )


def _attempt(repair: Repair, x: Floats) -> tuple[float, float]:
    """The objective at a point near x, infinite unless it is proved feasible; and what it may miss by."""
    point = repair.near(x)
    violated = repair.violation(point)
    value = math.inf if violated > 0.0 else upper_bound(repair.program, point)
    return value if math.isfinite(value) else math.inf, violated


def _lower(program: ConeProgram, x: Floats, z: Floats, upper: float) -> tuple[float, str]:
    """The better of the bounds that the answer and 0 give, or why there is none."""
    value = float(program.objective(exact(x)).mid())
    level = upper if math.isfinite(upper) else value + 1.0 + abs(value)
    best, why = -math.inf, ""
    try:
        below = curvature(program.P)
    except NoBoundError as reason:
        return best, str(reason)
    terms = Terms(program, below, level_box(program, below, level))
    for point, dual in ((x, z), (np.zeros_like(x), np.zeros_like(z))):
        try:
            found = float_below(lower_bound(terms, point, dual))
            if math.isfinite(found):  # min and max would take NaN for anything
                best = max(best, min(level, found))
            else:
                why = why or "the lower bound is beyond the range of float64"
        except NoBoundError as reason:
            why = why or str(reason)
    return best, "" if best > -math.inf else why
