"""D1 and D2 by cases: the difference quotients of a convex function enclose its derivative, exactly."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

import numpy as np

from convexperc.problem import optimality
from convexperc.problem.arrays import FeatureVector, Vector
from convexperc.problem.problem import Problem
from convexperc.solvers.paper import systems as paper_systems
from convexperc.solvers.paper.variants import CORRECTED, PRINTED
from verification.checks.interface import Check, Observation
from verification.checks.measures import LARGE, ULP, drawn_point, magnitudes, number, share, size, underflow
from verification.exact.formulation import norms, objective, residuals
from verification.exact.numbers import Enclosure, Rationals, inner, rationals
from verification.exact.problem import ExactProblem
from verification.ledger.evidence import Outcome
from verification.problems.sources import Source

PARTS = ("D1/printed", "D1/corrected", "D2/printed", "D2/corrected")
STEP = Fraction(1, 2**120)
"""Step of the quotients, as a share of |w_j| or ||u^i||: far above what the roots of 400 bits leave open."""
RESOLVED = Fraction(1, 2**20)
"""Quotients further apart than this share of the penalty's slope do not tell the readings apart."""
BLUNT = 2.0**400
"""The library takes norms of blocks by squares: its KKT residual is compared between 1/this and this."""
ROUNDING = 16
"""The library's derivative may be off by this many units, times n + d, of the magnitudes behind it."""


@dataclass(frozen=True)
class Slope:
    """One partial derivative of F, enclosed, and the two equations for it.

    Attributes
    ----------
    claim : str
        D1 or D2.
    quotients : Enclosure
        Contains the derivative of F, whatever anybody's formula says.
    printed, corrected : Enclosure
        The paper's equation, and the one with |w_i| and without the factor 1/2; exact but for a root.
    penalty : Fraction
        Size of the penalty's slope: lambda2 or lambda3.
    magnitude : Fraction
        The sum behind the derivative with every sign taken as +.
    peak : Fraction
        The largest number on the way to it.
    slack : Fraction
        What rounding and underflow may change in float64.
    library : (tuple of float, tuple of float)
        The library's numbers for either equation.
    """

    claim: str
    quotients: Enclosure
    printed: Enclosure
    corrected: Enclosure
    penalty: Fraction
    magnitude: Fraction
    peak: Fraction
    slack: Fraction
    library: tuple[tuple[float, ...], tuple[float, ...]]

    def observations(self) -> Iterator[Observation]:
        """One of either equation."""
        yield self._judged(f"{self.claim}/printed", self.printed, self.library[0])
        yield self._judged(f"{self.claim}/corrected", self.corrected, self.library[1])

    def _judged(self, part: str, value: Enclosure, library: tuple[float, ...]) -> Observation:
        outside = max(value.lower - self.quotients.upper, self.quotients.lower - value.upper)
        measure = share(outside, self.magnitude)
        if outside > 0:
            ends = f"[{number(self.quotients.lower)!r}, {number(self.quotients.upper)!r}]"
            detail = f"{number(value.lower)!r} lies outside the difference quotients {ends}"
            return Observation(part, Outcome.FAILED, measure, detail)
        for found in library:
            if self._is_off(found, value):
                detail = f"the library has {found!r}, exact is {number(value.lower)!r}"
                return Observation(part, Outcome.FAILED, 1.0, detail)
        resolved = not self.penalty or self.quotients.width <= RESOLVED * self.penalty
        if resolved:
            return Observation(part, Outcome.HELD, measure)
        return Observation(part, Outcome.UNDECIDED, measure, "the quotients do not resolve the penalty")

    def _is_off(self, found: float, value: Enclosure) -> bool:
        """Whether rounding does not explain the library's number; never where float64 may overflow."""
        if self.peak > LARGE:
            return False
        if not math.isfinite(found):
            return True
        return max(value.lower - Fraction(found), Fraction(found) - value.upper) > self.slack


@dataclass(frozen=True, eq=False)
class _Place:
    """A problem and a point, as floats and exactly."""

    problem: Problem
    w: Vector
    u: FeatureVector

    @cached_property
    def data(self) -> ExactProblem:
        return ExactProblem.of(self.problem)

    def slack(self, magnitude: Fraction) -> Fraction:
        """What rounding may change in a derivative."""
        data = self.data
        lost = underflow(data, rationals(self.w), rationals(self.u))
        return ROUNDING * size(data) * (ULP * magnitude + lost)

    def quotients(self, which: int, index: int, step: Fraction) -> Enclosure:
        """(F(z) - F(z - h e)) / h <= dF/de <= (F(z + h e) - F(z)) / h."""
        here = objective(self.problem, self.w, self.u)
        back, forth = (self._moved(which, index, step * sign) for sign in (-1, 1))
        return Enclosure((here.lower - back.upper) / step, (forth.upper - here.lower) / step)

    def _moved(self, which: int, index: int, step: Fraction) -> Enclosure:
        point: list[Rationals] = [rationals(self.w), rationals(self.u)]
        point[which][index] += step
        return objective(self.problem, point[0], point[1])


def observe(problem: Problem, source: Source) -> Iterator[Observation]:
    """Look at one view and at one feature of a drawn point."""
    place = _Place(problem, *drawn_point(problem, source))
    j, k = source.integer(0, problem.n - 1), source.integer(0, problem.d - 1)
    i = next(i for i, part in enumerate(place.data.groups) if k in part)
    with np.errstate(all="ignore"):
        if place.w[j] == 0.0:
            yield from _skipped("D1", f"w_{j} = 0")
        else:
            yield from _view(place, j).observations()
        if not place.u[list(place.data.groups[i])].any():
            yield from _skipped("D2", f"u^{i} = 0")
        else:
            yield from _feature(place, i, k).observations()


def _skipped(claim: str, reason: str) -> Iterator[Observation]:
    for name in ("printed", "corrected"):
        yield Observation(f"{claim}/{name}", Outcome.SKIPPED, detail=f"{reason}: F has no derivative there")


def _view(place: _Place, j: int) -> Slope:
    """dF/dw_j: 2 x_j'(X'w - o) - 2 lambda1 (Xu - w)_j, and lambda2/2 as printed or lambda2 sign(w_j)."""
    data, problem, w, u = place.data, place.problem, place.w, place.u
    point = rationals(w), rationals(u)
    (p, q), (sizes_p, sizes_q) = residuals(data, *point), magnitudes(data, *point)
    smooth = 2 * inner(data.X[j], p) - 2 * data.lambda1 * q[j]
    magnitude = 2 * inner(map(abs, data.X[j]), sizes_p) + 2 * data.lambda1 * sizes_q[j] + data.lambda2
    printed = smooth + data.lambda2 / 2
    corrected = smooth + (data.lambda2 if w[j] > 0 else -data.lambda2)
    true = float(paper_systems.derivative_w(problem, CORRECTED, w, u)[j])
    residual = math.copysign(float(optimality.optimality_residual(problem, w, u).views[j]), true)
    plain = max(sizes_p), (1 + 2 * data.lambda1) * max(sizes_q), data.lambda2 / abs(point[0][j])
    return Slope(
        "D1",
        place.quotients(0, j, STEP * abs(point[0][j])),
        Enclosure(printed, printed),
        Enclosure(corrected, corrected),
        data.lambda2,
        magnitude,
        max(magnitude, *plain),
        place.slack(magnitude),
        ((float(paper_systems.derivative_w(problem, PRINTED, w, u)[j]),), (true, residual)),
    )


def _feature(place: _Place, i: int, k: int) -> Slope:
    """dF/du_k: 2 lambda1 X_k'(Xu - w), and lambda3 u_k / ||u^i||, half of it as printed."""
    data, problem, w, u = place.data, place.problem, place.w, place.u
    point = rationals(w), rationals(u)
    q, sizes_q = residuals(data, *point)[1], magnitudes(data, *point)[1]
    column = data.columns[k]
    smooth = 2 * data.lambda1 * inner(column, q)
    magnitude = 2 * data.lambda1 * inner(map(abs, column), sizes_q) + data.lambda3
    length = norms(data, point[1])[i]
    slopes = sorted(data.lambda3 * point[1][k] / end for end in (length.lower, length.upper))
    true = float(paper_systems.derivative_u(problem, CORRECTED, w, u)[k])
    known: tuple[float, ...] = (true,)
    if len(data.groups[i]) == 1 and 1.0 / BLUNT < magnitude < BLUNT:
        residual = float(optimality.optimality_residual(problem, w, u).modalities[i])
        known = true, math.copysign(residual, true)
    pull = inner(map(abs, column), sizes_q)
    plain = pull, (1 + 2 * data.lambda1) * max(sizes_q), data.lambda3 / length.lower
    return Slope(
        "D2",
        place.quotients(1, k, STEP * length.lower),
        Enclosure(smooth + slopes[0] / 2, smooth + slopes[1] / 2),
        Enclosure(smooth + slopes[0], smooth + slopes[1]),
        data.lambda3 * abs(point[1][k]) / length.upper,
        magnitude,
        max(magnitude, *plain),
        place.slack(magnitude),
        ((float(paper_systems.derivative_u(problem, PRINTED, w, u)[k]),), known),
    )


CHECKS = (Check("derivatives", PARTS, observe, share=1.5),)
