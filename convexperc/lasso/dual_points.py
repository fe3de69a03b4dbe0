"""Dual points that the residual of an answer suggests, and what each of them proves.

With k_i = K w_i, t0 = k (y - X b - b0) in float64 is made orthogonal, up to rounding, to the columns that
nothing penalises, and to 1 where there is an intercept; these are the columns of A. The dual point meant is
the one that is orthogonal, t = t0 - diag(k) A z with A'diag(k)A z = A't0, which is never computed:

    sum_i (t - t0)_i^2 / k_i = z'A'diag(k)A z <= delta^2,    delta = ||A't0|| / sigma_min(diag(k)^(1/2) A).

In the lengths |x_j| = (sum_i k_i x_ij^2)^(1/2) and ||t|| = (sum_i t_i^2 / k_i)^(1/2), v = X't differs from
X't0 by at most |x_j| delta, and y't from y't0 by at most |y| delta.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from convexperc.certificate.rounding import (
    UNDERFLOW,
    Ball,
    U,
    down,
    gamma,
    inner,
    inner_by_group,
    norm_bounds,
    product,
    smallest_singular_value,
    up,
)
from convexperc.lasso.objective import Coefficients
from convexperc.lasso.scaled import ScaledAnswer, ScaledData, scattered, weighted
from convexperc.problem.arrays import Matrix, Vector
from convexperc.problem.scaling import Bounds

STEPS = 30
"""Newton steps of the search for a scale; they descend to it, and few are needed."""
INDEPENDENT = 2.0**-26
"""Columns whose part beside the others is a smaller share of them are taken to depend on these."""

BELOW = 2.0**-10
"""A free column with b >= 0 is left out where v_j is below 0 by this share of |x_j| ||t||."""


@dataclass(frozen=True, eq=False)
class Ray:
    """A dual point t before it is scaled.

    Attributes
    ----------
    t0 : float64 (n,)
    delta : float
        Upper bound of ||t - t0||.
    v : Ball of shape (p,)
        X't; exactly 0 for the columns that t is orthogonal to.
    linear : (float, float)
    quadratic : float
        D(s t) >= s linear[0] - s^2 quadratic - what the penalties take, for s >= 0.
    """

    t0: Vector
    delta: float
    v: Ball
    linear: Bounds
    quadratic: float

    @classmethod
    def of(cls, data: ScaledData, t: Vector, free: NDArray[np.int64]) -> "Ray":
        """From any t, which is made orthogonal to these columns."""
        root = np.sqrt(data.loss.lower)
        t0, delta, met = _orthogonal(data, t, root, free)
        size = up(_length(data.loss, t0) + delta)
        n = t0.size
        outside = (UNDERFLOW + data.entry_error) * (n + float(np.abs(t0).sum()) * (1.0 + 4 * (n + 8) * U))
        rad = (up(gamma(n + 4) * size) + delta) * data.lengths * (1.0 + 16 * U) + outside
        v = Ball(data.design.pulls(t0), rad)
        v.mid[met], v.rad[met] = 0.0, 0.0
        low, high = inner(data.y, Ball.exact(t0))
        off = up(up(math.sqrt(data.loss_of(data.y)[1])) * delta) if delta else 0.0
        linear = (down(low - off), up(high + off)) if off else (low, high)
        return cls(t0, delta, v, linear, up(0.5 * up(size * size)))


def _length(loss: Coefficients, t: Vector) -> float:
    """Upper bound of ||t||."""
    total = float((t / loss.lower) @ t) * (1.0 + 4 * (t.size + 8) * U) + t.size * UNDERFLOW
    return up(math.sqrt(total)) if t.any() else 0.0


def _orthogonal(
    data: ScaledData, t: Vector, root: Vector, free: NDArray[np.int64]
) -> tuple[Vector, float, NDArray[np.int64]]:
    """About t; how far it is from a point orthogonal to A; and the columns that this is orthogonal to."""
    if not (free.size or data.intercept):
        return t, 0.0, free
    ones = np.ones((t.size, 1)) if data.intercept else np.zeros((t.size, 0))
    columns, error = _unit(data.design.columns(free), data.entry_error)
    every = np.hstack([ones, columns])
    chosen, seen = _independent(every, root)
    met = free[seen[ones.shape[1] :]]
    A, B = every[:, chosen], root[:, None] * every[:, chosen]
    if not chosen.size:
        return t, 0.0, met
    basis = np.linalg.qr(B)[0]
    part = t / root
    for _ in range(2):  # what rounding leaves of the first time
        part = part - basis @ (basis.T @ part)
    t0 = root * part
    least = smallest_singular_value(B.T, 2 * U * float(np.abs(B).max()) + 2.0 * error * float(root.max()))
    reach = norm_bounds(product(np.ascontiguousarray(A.T), Ball.exact(t0), error))[1]
    return t0, up(up(reach / least) * (1.0 + 16 * U)) if least else math.inf, met


def _unit(columns: Matrix, entry_error: float) -> tuple[Matrix, float]:
    """Columns times powers of two, the largest entry of each in [1/2, 1); and how far entries may be off."""
    exponents = np.frexp(np.abs(columns).max(axis=0, initial=0.0))[1]
    scaled = np.ldexp(columns, -exponents[None, :])
    return scaled, 2.0**-1074 + (
        math.ldexp(entry_error, -int(exponents.min(initial=0))) if entry_error else 0.0
    )


def _independent(every: Matrix, root: Vector) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Columns that float64 tells to be independent; and which are orthogonal to t if these are.

    A column left out is among the latter if it is seen to be a multiple of one that is chosen.
    """
    chosen: list[int] = []
    met = np.zeros(every.shape[1], dtype=bool)
    basis = np.zeros((root.size, 0))
    for j, column in enumerate(every.T):
        if not column.any() or any(_parallel(column, every[:, i]) for i in chosen):
            met[j] = True
            continue
        part = length = root * column
        for _ in range(2):
            part = part - basis @ (basis.T @ part)
        size = float(np.linalg.norm(part))
        if size > INDEPENDENT * float(np.linalg.norm(length)) and len(chosen) < root.size:
            chosen.append(j)
            met[j] = True
            basis = np.column_stack([basis, part / size])
    return np.array(chosen, dtype=np.int64), met


def _parallel(one: Vector, other: Vector) -> bool:
    """Whether one is seen to be a multiple of the other: equal, opposite, or both the same everywhere."""
    if np.array_equal(one, other) or np.array_equal(one, -other):
        return True
    return bool((one == one[0]).all() and (other == other[0]).all() and other[0] != 0.0)


def rays(data: ScaledData, answer: ScaledAnswer) -> Iterator[Ray]:
    """What the residual suggests, made orthogonal to the free columns.

    With b >= 0 a free column needs v_j <= 0 alone: those that are far below are left out at first.
    """
    t = data.loss.lower * answer.residual.mid
    if not np.isfinite(t).all():
        return
    free = data.free.nonzero()[0]
    if data.positive and free.size:
        pull = data.design.pulls(Ray.of(data, t, free[:0]).t0)[free]
        ray = Ray.of(data, t, free[pull > -BELOW * data.lengths[free] * _length(data.loss, t)])
        yield ray
        if not (ray.v.mid[free] + ray.v.rad[free] > 0.0).any():
            return
    yield Ray.of(data, t, free)


@dataclass(frozen=True, eq=False)
class Limits:
    """What every optimum obeys, by group or by column without groups: ||b_g|| <= B_g; the least r_j of each.

    Attributes
    ----------
    most : float64 (k,)
    ridge : float64 (k,)
    """

    most: NDArray[np.float64]
    ridge: NDArray[np.float64]

    @classmethod
    def of(cls, data: ScaledData, upper: float) -> "Limits":
        """From an upper bound of P*, which no penalty of an optimum exceeds."""
        l1, ridge = _least(data, data.l1.lower), _least(data, data.ridge.lower)
        with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
            sums = (l1 + (data.group.lower if data.groups is not None else 0.0)) * (1.0 - 4 * U)
            by_norm = np.where(sums > 0.0, upper / sums, np.inf)
            by_square = np.where(ridge > 0.0, np.sqrt(2.0 * upper / ridge), np.inf)
        return cls(np.minimum(by_norm, by_square) * (1.0 + 16 * U), ridge)


def _least(data: ScaledData, values: NDArray[np.float64]) -> NDArray[np.float64]:
    """The least of each group; the values without groups."""
    if data.groups is None:
        return values
    ordered = values if data.groups.order is None else values[data.groups.order]
    return np.asarray(np.minimum.reduceat(ordered, data.groups.starts))


def _reach(data: ScaledData, v: Ball) -> NDArray[np.float64]:
    """Upper bounds of |v_j|, or of v_j where b >= 0."""
    return ((v.mid if data.positive else np.abs(v.mid)) + v.rad) * (1.0 + 4 * U)


def _excess(data: ScaledData, reach: NDArray[np.float64], s: float) -> NDArray[np.float64]:
    """Upper bounds of (||S(s v_g, l_g)|| - c_g)+; 0 only where that is proved."""
    reached = s * reach * (1.0 + 4 * U)
    beyond = np.where(reached > data.l1.lower, (reached - data.l1.lower) * (1.0 + 4 * U), 0.0)
    if data.groups is None:
        return np.asarray(beyond)
    together = data.groups.sums(beyond * beyond)
    lengths = np.sqrt(together) * (1.0 + 2 * (data.groups.sizes + 8.0) * U)
    lengths = np.where(together > 0.0, lengths, data.groups.sums(beyond))
    limit = data.group.lower
    return np.where(lengths > limit, (lengths - limit) * (1.0 + 4 * U), 0.0)


@dataclass(frozen=True, eq=False)
class DualPoint:
    """s t, and what the penalties take off its value."""

    ray: Ray
    scale: float
    charge: float

    @property
    def lower(self) -> float:
        """A lower bound of P*."""
        s, ray = self.scale, self.ray
        value = down(down(s * ray.linear[0]) - up(up(s * s) * ray.quadratic))
        return down(value - self.charge) if self.charge else value


def dual_points(data: ScaledData, ray: Ray, limits: Limits) -> Iterator[DualPoint]:
    """The ray at the scales that are feasible, best, and 1."""
    if not (math.isfinite(ray.linear[0]) and math.isfinite(ray.quadratic)):
        return
    best = 0.5 * (ray.linear[0] + ray.linear[1]) / (2.0 * ray.quadratic) if ray.quadratic > 0.0 else 1.0
    reach = _reach(data, ray.v)
    room = _room(data, reach, limits.ridge == 0.0, max(best, 0.0))
    for s in dict.fromkeys((room, min(best, 1.0), 1.0)):
        if s > 0.0:
            yield DualPoint(ray, s, _charge(_excess(data, reach, s), limits))


def _charge(excess: NDArray[np.float64], limits: Limits) -> float:
    beyond = excess.nonzero()[0]
    if not beyond.size:
        return 0.0
    e, most, ridge = excess[beyond], limits.most[beyond], limits.ridge[beyond]
    by_ridge = np.where(ridge > 0.0, e * e / (2.0 * ridge), np.inf)
    parts = np.minimum(by_ridge, e * most) * (1.0 + 16 * U)
    charge = up(float(parts.sum()) * (1.0 + 4 * (parts.size + 8) * U)) + UNDERFLOW
    return math.inf if math.isnan(charge) else charge


def _room(data: ScaledData, reach: NDArray[np.float64], tight: NDArray[np.bool_], best: float) -> float:
    """About the largest s <= best at which no group without a ridge penalty has an excess."""
    s = best
    for _ in range(STEPS):
        over = tight & (_excess(data, reach, s) > 0.0)
        if not over.any():
            break
        s = _nearer(data, reach, over, s)
    return s


def _nearer(data: ScaledData, reach: NDArray[np.float64], over: NDArray[np.bool_], s: float) -> float:
    """Newton's step for ||S(s v_g, l_g)|| = c_g, convex in s, of the groups that are over; the least s."""
    if data.groups is None:
        found = data.l1.lower[over] / reach[over]
    else:
        beyond = np.maximum(s * reach - data.l1.lower, 0.0)
        lengths = np.sqrt(data.groups.sums(beyond * beyond))
        slopes = data.groups.sums(beyond * reach) / lengths
        found = (s - (lengths - data.group.lower) / slopes)[over]
    least = float(np.min(found))
    return max(0.0, min(least, s) * (1.0 - 2.0**-46)) if math.isfinite(least) else 0.0


def gap_at(data: ScaledData, answer: ScaledAnswer, dual: DualPoint) -> float:
    """Upper bound of P - D as a sum of terms >= 0; see `convexperc.lasso.certificate`."""
    s = dual.scale
    residual = answer.residual
    pulled = Ball(data.loss.lower * residual.mid, data.loss.lower * residual.rad * (1.0 + 4 * U) + UNDERFLOW)
    pulled = Ball(pulled.mid, pulled.rad + U * np.abs(pulled.mid) * (1.0 + 4 * U))
    off = pulled.plus(Ball.exact(dual.ray.t0).times(s), -1.0)
    apart = up(_length(data.loss, off.magnitude()) + up(s * dual.ray.delta))
    loss = up(0.5 * up(apart * apart))
    total = up(loss + up(_penalties(data, answer, dual) + dual.charge))
    # beside a ridge penalty the second part may be negative
    return math.inf if math.isnan(total) else up(max(0.0, total) + answer.slack)


def _penalties(data: ScaledData, answer: ScaledAnswer, dual: DualPoint) -> float:
    """Upper bound of the penalties minus s v'b."""
    b, v = answer.b, dual.ray.v
    l1, ridge = data.l1.lower[answer.used], data.ridge.lower[answer.used]
    pull = Ball(v.mid[answer.used], v.rad[answer.used]).times(dual.scale)
    slope, curve = np.sign(b.mid) * l1, 0.5 * ridge * b.mid
    error = np.where(b.rad > 0.0, 2.0 * l1 + ridge * b.rad, 0.0)
    error = error + 4 * U * (np.abs(slope) + np.abs(curve)) + UNDERFLOW * ((l1 > 0.0) | (ridge > 0.0))
    own = Ball(slope + curve, error).plus(pull, -1.0)
    if data.groups is None:
        return inner(b, own)[1]
    whole, other = (scattered(each, answer.used, v.mid.size) for each in (b, own))
    norms = weighted(Coefficients(data.group.lower, data.group.lower), answer.lengths)
    parts = inner_by_group(whole, other, data.groups)[1]
    return up(norms[1] + up(float(parts.sum()) + (parts.size + 8) * 2 * U * float(np.abs(parts).sum())))


def zeros_at(data: ScaledData, dual: DualPoint, gap: float) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Columns and groups that no optimum uses: ||t* - s t|| <= sqrt(2 gap) (as Lemma R38).

    With ||b_g|| <= B_g the dual is as strongly concave, and its maximum is t* = k (y - X b* - b0*) as well.
    """
    root = up(math.sqrt(up(2.0 * gap)))
    far = (dual.scale * _reach(data, dual.ray.v) + root * data.lengths) * (1.0 + 16 * U) + UNDERFLOW
    columns = far < data.l1.lower
    if data.groups is None:
        return columns, np.zeros(0, dtype=bool)
    beyond = np.maximum(far - data.l1.lower, 0.0) * (1.0 + 4 * U)
    k = data.groups.sizes
    lengths = np.sqrt(data.groups.sums(beyond * beyond) * (1.0 + 4 * (k + 8.0) * U) + k * UNDERFLOW) * (
        1.0 + 4 * U
    )
    groups = lengths < data.group.lower
    return columns | (data.by_column(groups.astype(np.float64)) > 0.0), groups
