"""The interval of F* in one precision, narrowed by point after point: F and its dual in ball arithmetic.

Upper bounds come from exact points, lower bounds from exact dual points.
"""

import math
from typing import Any

import flint
import numpy as np

from convexperc.certificate.tolerances import Tolerances
from convexperc.enclosure.active_set import ActiveSetNewton, Start
from convexperc.enclosure.balls import (
    Number,
    Numbers,
    column,
    dot,
    exact_matrix,
    float_above,
    times,
)
from convexperc.enclosure.central_path import Central, CentralPath
from convexperc.enclosure.exact_data import ExactData
from convexperc.enclosure.reduced import ReducedBalls
from convexperc.problem.arrays import Vector
from convexperc.problem.problem import Problem


class Interval:
    """The narrowest interval of F* so far, normalised, in one precision; at first 0 <= F* <= ||o||^2."""

    def __init__(self, reduced: ReducedBalls, exact: Number | None, tolerances: Tolerances) -> None:
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
        return self.tolerances.met_by_shares(self.relative, self.share)

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


def primal_value(reduced: ReducedBalls, point: Central) -> Number:
    """F at w and u^i = t_i X_i' q; with lambda3 = 0 at the u for which Xu is the projection of w."""
    lambda1, lambda2, lambda3 = reduced.lambdas
    w, q = point.w, point.q
    total = dot(w, times(reduced.G, w)) - 2 * dot(reduced.c, w) + reduced.target
    total += lambda2 * sum((abs(v) for v in w), flint.arb(0))
    if lambda1 == 0 or (lambda3 == 0 and reduced.null is None):
        return total
    if lambda3 == 0:
        outside = times(reduced.null, w)
        return total + lambda1 * dot(outside, outside)
    residual = [-v for v in w]
    for weight, gram in zip(point.t, reduced.K, strict=True):
        pull = times(gram, q)
        residual = [r + weight * v for r, v in zip(residual, pull, strict=True)]
        total += lambda3 * weight * dot(q, pull).nonnegative_part().sqrt()
    return total + lambda1 * dot(residual, residual)


def dual_value(reduced: ReducedBalls, point: Central) -> Number:
    """D at a = 2(X'w - o) and b, scaled into the feasible set by proof; see `convexperc.certificate.duality`.

    No scale repairs X a = b, which lambda2 = 0 asks; there b is X a itself, or F* is a squared distance.
    """
    lambda1, lambda2, lambda3 = reduced.lambdas
    w = point.w
    if lambda2 == 0 and (lambda1 == 0 or lambda3 == 0):
        return _squared_distance(reduced)
    Gw = times(reduced.G, w)
    Xa = [2 * (g - c) for g, c in zip(Gw, reduced.c, strict=True)]
    b = _dual_coupling(reduced, point, Xa)
    scale = flint.arb(1)
    if lambda2 > 0:
        for pull, value in zip(Xa, b, strict=True):
            scale = _limited(scale, lambda2, abs(pull - value))
    if lambda3 > 0:
        for gram in reduced.K:
            scale = _limited(scale, lambda3, dot(b, times(gram, b)).nonnegative_part().sqrt())
    linear = 2 * (reduced.target - dot(reduced.c, w))
    quadratic = dot(w, Gw) - 2 * dot(reduced.c, w) + reduced.target
    if lambda1 > 0:
        quadratic += dot(b, b) / (4 * lambda1)
    return scale * linear - scale * scale * quadratic


def _squared_distance(reduced: ReducedBalls) -> Number:
    """min_w ||X'w - o||^2 = ||o||^2 - c_B' G_BB^-1 c_B for a row basis B; 0 where G_BB may be singular."""
    B = range(reduced.n) if reduced.space is None else reduced.space.rows
    if not B:
        return reduced.target
    block, c = flint.arb_mat([[reduced.G[i, k] for k in B] for i in B]), [reduced.c[i] for i in B]
    try:
        return reduced.target - dot(c, column(block.solve(flint.arb_mat(len(B), 1, c))))
    except ZeroDivisionError:
        return flint.arb(0)


def _dual_coupling(reduced: ReducedBalls, point: Central, Xa: Numbers) -> Numbers:
    """b: Xa itself where lambda2 = 0, else 0, a null vector, or -2q."""
    lambda1, lambda2, lambda3 = reduced.lambdas
    if lambda1 == 0 or (lambda3 == 0 and reduced.null is None):
        return [flint.arb(0)] * reduced.n
    if lambda3 == 0:
        return [-2 * lambda1 * v for v in times(reduced.null, point.w)]
    if lambda2 == 0:
        return Xa
    return [-2 * v for v in point.q]


def _limited(scale: Number, limit: Number, norm: Number) -> Number:
    """The scale, lowered until scale * norm <= limit for sure."""
    top = norm.upper()
    if not top > 0 or scale * top <= limit:
        return scale
    return (limit / top).lower()


def objective_at(problem: Problem, w: Vector, u: np.ndarray) -> Number:
    """F(w, u) at floats, on the original data, enclosed in the precision in force."""
    data, one = ExactData.of(problem), flint.arb(1)
    point_w = exact_matrix(w[:, None])
    q, total = -point_w, one * problem.lambda2 * sum((abs(v) for v in column(point_w)), flint.arb(0))
    for block, o, columns in zip(data.blocks, data.targets, problem.modalities, strict=True):
        part, p = exact_matrix(u[columns, None]), block.transpose() * point_w - o
        q = q + block * part
        total += _square(p) + one * problem.lambda3 * _square(part).sqrt()
    return total + one * problem.lambda1 * _square(q)


def _square(x: Any) -> Number:
    """||x||^2 of one column."""
    return (x.transpose() * x)[0, 0].nonnegative_part()
