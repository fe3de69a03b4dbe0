"""A primal point in normalised units, with bounds of F and of all that its certificates share."""

import math
from dataclasses import dataclass

import numpy as np

from convexperc.certificate.frame import Frame
from convexperc.certificate.rounding import (
    UNDERFLOW,
    Ball,
    Floats,
    inner,
    scaled_bounds,
    squared_norm,
    sum_bounds,
)
from convexperc.problem.arrays import FeatureVector, Vector
from convexperc.problem.scaling import Bounds, Scaling


@dataclass(frozen=True, eq=False)
class PrimalPoint:
    """A point (w, u); all 0 where it is not finite.

    Attributes
    ----------
    w, u : Ball of shape (n,) and (d,)
    p, q : Ball of shape (d,) and (n,)
        X'w - o and Xu - w.
    lengths : (lower, upper), float64 (m,) each
        Bounds of ||u^i||.
    finite : bool
    objective : (lower, upper)
        Bounds of F(w, u).
    """

    w: Ball
    u: Ball
    p: Ball
    q: Ball
    lengths: tuple[Floats, Floats]
    finite: bool
    objective: Bounds

    @classmethod
    def of(cls, frame: Frame, scaling: Scaling, w: Vector, u: FeatureVector) -> "PrimalPoint":
        """Normalise a point (w, u) on the original data and evaluate it."""
        w_, u_ = scaling.point(w, u)
        finite = bool(np.isfinite(w_).all() and np.isfinite(u_).all())
        if finite:
            balls = _allowing_underflow(w_, w), _allowing_underflow(u_, u)
        else:
            balls = Ball.exact(np.zeros_like(w)), Ball.exact(np.zeros_like(u))
        p = frame.times_columns(balls[0]).plus(frame.target, -1.0)
        q = frame.times_rows(balls[1]).plus(balls[0], -1.0)
        lengths = frame.modality_norms(balls[1])
        lower, upper = objective_bounds(frame, balls[0], p, q, lengths) if finite else (0.0, math.inf)
        bounds = (0.0, math.inf) if math.isnan(upper) else (max(0.0, lower), upper)
        return cls(*balls, p, q, lengths, finite, bounds)


def _allowing_underflow(scaled: Floats, given: Floats) -> Ball:
    """Entries so small that scaling may have rounded them, even to 0, get the radius of that rounding."""
    return Ball(scaled, np.where((np.abs(scaled) < 2.0**-1000) & (given != 0.0), UNDERFLOW, 0.0))


def objective_bounds(frame: Frame, w: Ball, p: Ball, q: Ball, lengths: tuple[Floats, Floats]) -> Bounds:
    """Enclose F = ||p||^2 + lambda1 ||q||^2 + lambda2 ||w||_1 + lambda3 sum_i ||u^i||."""
    low, high = inner(Ball(np.abs(w.mid), w.rad), Ball.exact(np.ones_like(w.mid)))
    norms = sum_bounds(*zip(lengths[0].tolist(), lengths[1].tolist(), strict=True))
    return sum_bounds(
        squared_norm(p),
        scaled_bounds(frame.lambda1, squared_norm(q)),
        scaled_bounds(frame.lambda2, (max(0.0, low), high)),
        scaled_bounds(frame.lambda3, norms),
    )
