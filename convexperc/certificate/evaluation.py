"""F at a point in normalised units, rounding included; and what all points of one problem share."""

import math
from dataclasses import dataclass

import numpy as np

from convexperc.caching import cached_property
from convexperc.certificate.rounding import (
    UNDERFLOW,
    Ball,
    Floats,
    Groups,
    U,
    inner,
    norms_by_group,
    product,
    scaled_bounds,
    smallest_singular_value,
    squared_norm,
    sum_bounds,
)
from convexperc.problem.arrays import FeatureVector, Matrix, Vector
from convexperc.problem.modalities import Modalities
from convexperc.problem.problem import Problem
from convexperc.problem.scaling import Bounds, Scaling


@dataclass(frozen=True, eq=False)
class NormalizedData:
    """The normalised data; what many points share is computed once.

    Attributes
    ----------
    X, o : float64 (n, d) and (d,)
        Normalised data, each entry within `entry_error`.
    lambda1, lambda2, lambda3 : (lower, upper)
        Normalised lambdas. The lower ones make dual points, the upper ones bound F from above: a smaller
        lambda can only lower the optimum.
    modalities : Modalities
    entry_error : float
        Bound on the error of every entry of X and o: 0 unless one underflowed.
    """

    X: Matrix
    o: FeatureVector
    modalities: Modalities
    lambda1: Bounds
    lambda2: Bounds
    lambda3: Bounds
    entry_error: float

    @classmethod
    def of(cls, problem: Problem, scaling: Scaling) -> "NormalizedData":
        """Normalise `problem` by `scaling`."""
        X, o, error = scaling.data(problem)
        one, two, three = scaling.lambdas(problem)
        return cls(X, o, problem.modalities, one, two, three, error)

    @cached_property
    def target(self) -> Ball:
        """o with its entry error."""
        return Ball(self.o, np.full(self.o.shape, self.entry_error))

    @cached_property
    def target_square(self) -> Bounds:
        """Bounds of ||o||^2."""
        return squared_norm(self.target)

    @cached_property
    def groups(self) -> Groups:
        """The columns of each modality."""
        return Groups.of(tuple(self.modalities), self.modalities.sizes)

    @cached_property
    def absolute(self) -> Matrix:
        """|X|, entry by entry."""
        return np.asarray(np.abs(self.X))

    @cached_property
    def row_squares(self) -> Floats:
        """Upper bounds of ||x^j||^2, shape (n,) (Lemma R21)."""
        d = self.X.shape[1]
        return np.asarray(np.einsum("ij,ij->i", self.X, self.X) * (1.0 + 4 * (d + 8) * U) + d * UNDERFLOW)

    @cached_property
    def block_lengths(self) -> Floats:
        """Upper bounds of the Frobenius norms ||X_i||_F, shape (m,) (Lemma R22)."""
        squares = self.groups.sums(np.einsum("ij,ij->j", self.X, self.X))
        squares = squares * (1.0 + 4 * (self.X.size + 8) * U) + self.X.size * UNDERFLOW
        return np.asarray(np.nextafter(np.sqrt(squares), np.inf))

    @cached_property
    def smallest_singular_value(self) -> float:
        """Lower bound of sigma_min(X')."""
        return smallest_singular_value(self.X, self.entry_error)

    def times_rows(self, x: Ball) -> Ball:
        """X x for x of shape (d,)."""
        return product(self.X, x, self.entry_error, self.absolute)

    def times_columns(self, x: Ball) -> Ball:
        """X' x for x of shape (n,)."""
        return product(self.X.T, x, self.entry_error, self.absolute.T)

    def modality_norms(self, x: Ball) -> tuple[Floats, Floats]:
        """Lower and upper bounds, shape (m,), of the 2-norm of each modality's part of x of shape (d,)."""
        return norms_by_group(x, self.groups)


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
    def of(cls, data: NormalizedData, scaling: Scaling, w: Vector, u: FeatureVector) -> "PrimalPoint":
        """Normalise a point (w, u) on the original data and evaluate it (Lemma R23)."""
        w_, u_ = scaling.point(w, u)
        finite = bool(np.isfinite(w_).all() and np.isfinite(u_).all())
        if finite:
            balls = _allowing_underflow(w_, w), _allowing_underflow(u_, u)
        else:
            balls = Ball.exact(np.zeros_like(w)), Ball.exact(np.zeros_like(u))
        p = data.times_columns(balls[0]).plus(data.target, -1.0)
        q = data.times_rows(balls[1]).plus(balls[0], -1.0)
        lengths = data.modality_norms(balls[1])
        lower, upper = objective_bounds(data, balls[0], p, q, lengths) if finite else (0.0, math.inf)
        bounds = (0.0, math.inf) if math.isnan(upper) else (max(0.0, lower), upper)
        return cls(*balls, p, q, lengths, finite, bounds)


def _allowing_underflow(scaled: Floats, given: Floats) -> Ball:
    """Give entries so small that scaling may have rounded them the radius of that rounding (Lemma R20)."""
    return Ball(scaled, np.where((np.abs(scaled) < 2.0**-1000) & (given != 0.0), UNDERFLOW, 0.0))


def objective_bounds(
    data: NormalizedData, w: Ball, p: Ball, q: Ball, lengths: tuple[Floats, Floats]
) -> Bounds:
    """Enclose F = ||p||^2 + lambda1 ||q||^2 + lambda2 ||w||_1 + lambda3 sum_i ||u^i|| (Lemma R23)."""
    low, high = inner(Ball(np.abs(w.mid), w.rad), Ball.exact(np.ones_like(w.mid)))
    norms = sum_bounds(*zip(lengths[0].tolist(), lengths[1].tolist(), strict=True))
    return sum_bounds(
        squared_norm(p),
        scaled_bounds(data.lambda1, squared_norm(q)),
        scaled_bounds(data.lambda2, (max(0.0, low), high)),
        scaled_bounds(data.lambda3, norms),
    )
