"""What is proved of F* in ball arithmetic, as floats."""

import math
from dataclasses import dataclass, field, replace
from fractions import Fraction

import numpy as np

from convexperc.certificate.certificate import Certificate
from convexperc.enclosure.exact_point import ExactPoint
from convexperc.problem.arrays import Vector
from convexperc.problem.problem import Problem


@dataclass(frozen=True, eq=False)
class Enclosure:
    """lower <= F* <= upper, proved, on the original data, and the point that attains the upper end.

    Attributes
    ----------
    lower, upper : float
        Rounded outward.
    relative_width : float
        Upper bound of (upper - lower) / F* before that rounding; infinite where F* may be 0.
    share_of_target : float
        Upper bound of (upper - lower) / ||o||^2.
    w : float64 (n,)
        The point's view weights, rounded to nearest; 0 where no budget was left for a point.
    u : float64 (d,)
    bits : int
        Precision that was needed.
    steps : int
        Newton steps.
    exact : ExactPoint
        The point and the interval before rounding to float64.
    method : str
        How the interval was proved; or which assumption on the arithmetic fails, so that nothing is.
    reason : str
        Why the interval is wider than was asked; empty where it is not.
    """

    lower: float
    upper: float
    relative_width: float
    share_of_target: float
    w: Vector
    u: np.ndarray
    bits: int
    steps: int
    exact: ExactPoint = field(repr=False)
    method: str
    reason: str = ""

    @classmethod
    def of_nothing(cls, problem: Problem, bits: int, reason: str = "F >= 0") -> "Enclosure":
        """F* >= 0 alone."""
        point, unknown = (np.zeros(problem.n), np.zeros(problem.d)), (math.inf,) * 3
        exact = ExactPoint.zero(problem.n, problem.m)
        return cls(0.0, *unknown, *point, bits, 0, exact, reason, reason)

    def within(self, proof: Certificate) -> "Enclosure":
        """The same with the interval cut to that of a certificate of the same problem, in float64."""
        lower, upper = max(self.lower, proof.lower), min(self.upper, proof.upper)
        if (lower, upper) == (self.lower, self.upper):
            return self
        exact = self.exact
        low, high = max(exact.lower, Fraction(lower)), exact.upper
        if math.isfinite(upper):
            high = min(high, Fraction(upper))
        return replace(
            self,
            lower=lower,
            upper=upper,
            relative_width=min(self.relative_width, _quotient(high - low, lower)),
            share_of_target=min(self.share_of_target, _quotient(high - low, proof.target)),
            exact=replace(exact, lower=low, upper=high),
            method=f"{self.method}; {proof.method}" if self.steps else proof.method,
        )


def _quotient(width: Fraction, value: float) -> float:
    """Upper bound of width / value for numbers >= 0; infinite where the value may be 0."""
    if width <= 0:
        return 0.0
    if value == 0.0:
        return math.inf
    exact = width / Fraction(value)
    try:
        near = float(exact)
    except OverflowError:
        return math.inf
    return near if Fraction(near) >= exact else math.nextafter(near, math.inf)
