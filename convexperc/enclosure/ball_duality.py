"""F and its dual in ball arithmetic: upper bounds at exact points, lower bounds by exact dual points."""

from typing import Any

import flint
import numpy as np

from convexperc.enclosure.balls import (
    ExactData,
    Number,
    Numbers,
    ReducedBalls,
    column,
    dot,
    exact_matrix,
    times,
)
from convexperc.enclosure.central_path import Central
from convexperc.problem.arrays import Vector
from convexperc.problem.problem import Problem


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
