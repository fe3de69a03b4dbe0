"""Exact normalisation by powers of two, and its exact undoing.

F is homogeneous in two ways. With X = s X_, o = t o_ and s, t powers of two,

    lambda1 = s^2 lambda1_,  lambda2 = s t lambda2_,  lambda3 = s^2 t lambda3_
    w = (t / s) w_,          u = (t / s^2) u_,         F = t^2 F_

so that every solver may work on rows of norm about 1 and a target of norm about 1.
"""

import math
from dataclasses import dataclass

import numpy as np

from convexperc.errors import ProblemError, check_type
from convexperc.problem.arrays import (
    FeatureVector,
    Matrix,
    Vector,
    binary_exponent,
    is_power_of_two_times,
    times_power_of_two,
)
from convexperc.problem.penalties import Penalties
from convexperc.problem.problem import Problem
from convexperc.problem.views import Views

LARGEST_LAMBDA = 2.0**1000
"""Scaled lambdas above this are cut here for solvers; a smaller lambda can only lower F*."""

ZERO_LAMBDA2, ZERO_LAMBDA3 = 4.0, 8.0
"""Normalised lambda2, and lambda3 for each view, from which on w = 0 or u = 0; see `Scaling.normalise`."""

SMALLEST_NORMAL = 2.0**-1022
"""Underflow errs by less, also where subnormal results are flushed to 0."""

Bounds = tuple[float, float]


@dataclass(frozen=True)
class Scaling:
    """The exponents of s = 2^x and t = 2^o.

    Attributes
    ----------
    x, o : int
        Binary exponents taken out of X and of o.
    """

    x: int
    o: int

    @classmethod
    def of(cls, problem: Problem) -> "Scaling":
        """Choose the exponents: the longest row of X, and o, get a length in [1/2, 1)."""
        check_type(problem, Problem, "problem", ProblemError)
        return cls(problem.views.exponent, binary_exponent(problem.o[None, :]))

    def data(self, problem: Problem) -> tuple[Matrix, FeatureVector, float]:
        """X_, o_, and a bound on the error of each of their entries (0 unless an entry underflowed)."""
        views, o = self._views(problem), times_power_of_two(problem.o, -self.o)
        exact = views.exact and is_power_of_two_times(o[None, :], problem.o[None, :], -self.o)
        return views.X, o, 0.0 if exact else SMALLEST_NORMAL

    def _views(self, problem: Problem) -> Views:
        """The views in normalised units, which the templates of one set of views share."""
        views = problem.views
        return views.normalised if self.x == views.exponent else views.divided(self.x)

    def lambdas(self, problem: Problem) -> tuple[Bounds, Bounds, Bounds]:
        """lambda1_, lambda2_, lambda3_ as (lower, upper), equal unless one leaves the range of float64."""
        exponents = (2 * self.x, self.x + self.o, 2 * self.x + self.o)
        one, two, three = (_shifted(v, -e) for v, e in zip(problem.lambdas, exponents, strict=True))
        return one, two, three

    def point(self, w: Vector, u: FeatureVector) -> tuple[Vector, FeatureVector]:
        """(w_, u_) of a point (w, u) on the original data."""
        with np.errstate(over="ignore", under="ignore"):
            return times_power_of_two(w, self.x - self.o), times_power_of_two(u, 2 * self.x - self.o)

    def point_back(self, w: Vector, u: FeatureVector) -> tuple[Vector, FeatureVector]:
        """(w, u) on the original data of a point (w_, u_)."""
        with np.errstate(over="ignore", under="ignore"):
            return times_power_of_two(w, self.o - self.x), times_power_of_two(u, self.o - 2 * self.x)

    def dual(self, a: FeatureVector, b: Vector) -> tuple[FeatureVector, Vector]:
        """(a_, b_) of a dual point (a, b): a = t a_ and b = s t b_."""
        with np.errstate(over="ignore", under="ignore"):
            return times_power_of_two(a, -self.o), times_power_of_two(b, -self.x - self.o)

    def dual_back(self, a: FeatureVector, b: Vector) -> tuple[FeatureVector, Vector]:
        """(a, b) on the original data of a dual point (a_, b_)."""
        with np.errstate(over="ignore", under="ignore"):
            return times_power_of_two(a, self.o), times_power_of_two(b, self.x + self.o)

    def value_back(self, bounds: Bounds) -> Bounds:
        """Bounds of F on the original data from bounds of F_, rounded outward where that is no float."""
        lower, upper = bounds
        low, high = _shifted(lower, 2 * self.o), _shifted(upper, 2 * self.o)
        return low[0], high[1]

    def gradient_back(self, bounds: Bounds) -> Bounds:
        """Bounds of a lambda2 on the original data from bounds of lambda2_: lambda2 = s t lambda2_."""
        lower, upper = bounds
        return _shifted(lower, self.x + self.o)[0], _shifted(upper, self.x + self.o)[1]

    def normalise(self, problem: Problem) -> Problem:
        """The normalised problem for a solver: nearest floats, lambdas cut where no optimum changes.

        With ||x^j|| < 1 and ||o|| < 1: lambda2 >= 2 gives w = 0; and ||b||_inf <= 2 + lambda2 at the optimum,
        so that lambda3 >= n (2 + lambda2) gives u = 0. Only lambda1 beyond `LARGEST_LAMBDA` is really cut.
        """
        o = times_power_of_two(problem.o, -self.o)
        one, two, three = (min(high, LARGEST_LAMBDA) for _, high in self.lambdas(problem))
        two, three = min(two, ZERO_LAMBDA2), min(three, ZERO_LAMBDA3 * problem.n)
        return Problem.of(self._views(problem), o, Penalties(one, two, three))


def _shifted(value: float, exponent: int) -> Bounds:
    """Value * 2^exponent, value >= 0, as (lower, upper) floats (Lemma R19)."""
    try:
        moved = math.ldexp(value, exponent)
    except OverflowError:
        return LARGEST_LAMBDA, math.inf
    if not math.isfinite(moved) or _is_shifted(moved, value, exponent):
        return moved, moved
    return max(0.0, math.nextafter(moved, -math.inf)), math.nextafter(moved, math.inf)


def _is_shifted(moved: float, value: float, exponent: int) -> bool:
    """Whether moved = value * 2^exponent: only underflow rounds, and its undoing shows it."""
    try:
        return math.ldexp(moved, -exponent) == value
    except OverflowError:
        return False
