"""The interval of F* in one precision, narrowed by point after point."""

import math

import flint

from convexperc.enclosure.active_set import ActiveSetNewton, Start
from convexperc.enclosure.ball_duality import dual_value, primal_value
from convexperc.enclosure.balls import Number, ReducedBalls, float_above
from convexperc.enclosure.central_path import Central, CentralPath


class Interval:
    """The narrowest interval of F* so far, normalised, in one precision; at first 0 <= F* <= ||o||^2."""

    def __init__(self, reduced: ReducedBalls, exact: Number | None, tolerances: tuple[float, float]) -> None:
        self.reduced, self.tolerances, self.steps = reduced, tolerances, 0
        zero = flint.arb(0)
        self.lower, self.upper = zero, reduced.target.upper()
        if exact is not None:
            self.lower, self.upper = exact.lower(), exact.upper()
        self.value = reduced.target.upper()
        self.point = Central([zero] * reduced.n, [zero] * len(reduced.K), [zero] * reduced.n, zero)

    def try_point(self, point: Central) -> tuple[Number, Number]:
        """Bound F* by what the point gives; returns these bounds from above and from below."""
        value, low = primal_value(self.reduced, point).upper(), dual_value(self.reduced, point).lower()
        if value < self.value:
            self.value, self.point = value, point
        self.upper = min(self.upper, value)
        self.lower = max(self.lower, low)
        return value, low

    @property
    def relative(self) -> float:
        """Upper bound of (upper - lower) / F*."""
        return quotient(self.upper - self.lower, self.lower)

    @property
    def share(self) -> float:
        """Upper bound of (upper - lower) / ||o||^2."""
        return quotient(self.upper - self.lower, self.reduced.target.lower())

    @property
    def narrow(self) -> bool:
        """Whether the interval is within the tolerances."""
        return self.relative <= self.tolerances[0] or self.share <= self.tolerances[1]

    def refine(self, near: Start) -> None:
        """Try where Newton's method leads from a float64 answer."""
        newton = ActiveSetNewton(self.reduced, near)
        self.try_point(newton.point())
        self.steps += newton.steps

    def follow(self) -> None:
        """Try points along the central path until the interval is narrow, or no more is gained."""
        path, before, stalled = CentralPath(self.reduced), self.steps, 0
        best, least = self.reduced.target.upper(), flint.arb(0)  # of the path: another point may be far ahead
        while stalled <= 3 and path.mu >= self.reduced.target * flint.arb(2) ** (-flint.ctx.prec):
            path.advance()
            value, low = self.try_point(path.point())
            stalled = 0 if value < best or low > least else stalled + 1
            best, least = min(best, value), max(least, low)
            self.steps = before + path.steps
            if self.narrow:
                break


def quotient(width: Number, value: Number) -> float:
    """Upper bound of width / value for numbers >= 0; infinite where the value may be 0, or for NaN."""
    if width <= 0:
        return 0.0
    return float_above(width / value) if value > 0 and width.is_finite() else math.inf
