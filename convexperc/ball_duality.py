"""F and its dual in ball arithmetic: upper bounds at exact points, lower bounds by exact dual points."""

import flint
import numpy as np

from convexperc.arrays import Vector
from convexperc.interior import Central
from convexperc.multiprecision import BallFrame, Number, Numbers, dot, exact_matrix, times
from convexperc.problem import Problem


def primal_value(frame: BallFrame, point: Central) -> Number:
    """F at w and u^i = t_i X_i' q; with lambda3 = 0 at the u for which Xu is the projection of w."""
    lambda1, lambda2, lambda3 = frame.lambdas
    w, q = point.w, point.q
    total = dot(w, times(frame.G, w)) - 2 * dot(frame.c, w) + frame.target
    total += lambda2 * sum((abs(v) for v in w), flint.arb(0))
    if lambda1 == 0 or (lambda3 == 0 and frame.null is None):
        return total
    if lambda3 == 0:
        return total + lambda1 * _projection_length(frame, w)
    residual = [-v for v in w]
    for weight, gram in zip(point.t, frame.K, strict=True):
        pull = times(gram, q)
        residual = [r + weight * v for r, v in zip(residual, pull, strict=True)]
        total += lambda3 * weight * dot(q, pull).nonnegative_part().sqrt()
    return total + lambda1 * dot(residual, residual)


def _projection_length(frame: BallFrame, w: Numbers) -> Number:
    """||N w||^2 for the orthogonal projection N onto {X'b = 0}."""
    pulled = times(frame.null.transpose(), w)
    gram = frame.null.transpose() * frame.null
    return dot(pulled, times(gram.inv(), pulled))


def dual_value(frame: BallFrame, point: Central) -> Number:
    """D at a = 2(X'w - o) and b, scaled into the feasible set by proof; see `convexperc.duality`."""
    lambda1, lambda2, lambda3 = frame.lambdas
    w = point.w
    Gw = times(frame.G, w)
    Xa = [2 * (g - c) for g, c in zip(Gw, frame.c, strict=True)]
    b = _dual_coupling(frame, point, Xa)
    scale = flint.arb(1)
    for pull, value in zip(Xa, b, strict=True):
        scale = _limited(scale, lambda2, abs(pull - value)) if lambda2 > 0 or lambda1 == 0 else scale
    if lambda3 > 0:
        for gram in frame.K:
            scale = _limited(scale, lambda3, dot(b, times(gram, b)).nonnegative_part().sqrt())
    linear = 2 * (frame.target - dot(frame.c, w))
    quadratic = dot(w, Gw) - 2 * dot(frame.c, w) + frame.target
    if lambda1 > 0:
        quadratic += dot(b, b) / (4 * lambda1)
    return scale * linear - scale * scale * quadratic


def _dual_coupling(frame: BallFrame, point: Central, Xa: Numbers) -> Numbers:
    """b: Xa itself where lambda2 = 0, else 0, a null vector, or -2q."""
    lambda1, lambda2, lambda3 = frame.lambdas
    if lambda1 == 0 or (lambda3 == 0 and frame.null is None):
        return [flint.arb(0)] * frame.n
    if lambda3 == 0:
        gram = frame.null.transpose() * frame.null
        inside = times(gram.inv(), times(frame.null.transpose(), point.w))
        inside = [(-2 * lambda1 * v).mid() for v in inside]
        return times(frame.null, inside)
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
    X, one = exact_matrix(problem.X, 0), flint.arb(1)
    point_w, point_u = [flint.arb(float(v)) for v in w], [flint.arb(float(v)) for v in u]
    p = [v - flint.arb(float(t)) for v, t in zip(times(X.transpose(), point_w), problem.o, strict=True)]
    q = [v - x for v, x in zip(times(X, point_u), point_w, strict=True)]
    total = dot(p, p) + one * problem.lambda1 * dot(q, q)
    total += one * problem.lambda2 * sum((abs(v) for v in point_w), flint.arb(0))
    for columns in problem.modalities:
        part = list(np.array(point_u, dtype=object)[columns])
        total += one * problem.lambda3 * dot(part, part).sqrt()
    return total
