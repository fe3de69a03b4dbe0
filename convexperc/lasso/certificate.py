"""Bounds of the optimum of a penalised least-squares fit, and of how far an answer is from it.

With K, l, c, r of `convexperc.lasso.objective`, v = X't for t with 1't = 0 where there is an intercept, and
S(v, l) = sign(v) (|v| - l)+, or (v - l)+ where b >= 0 is asked for, the dual is

    maximise  D(t) = y't - ||t||^2 / (2K) - sum_g sup over b_g of (v_g'b_g - penalties of b_g),

    where the last part of a group is 0                     if e_g = (||S(v_g, l_g)|| - c_g)+ = 0,
                                  at most e_g^2 / (2 r_g)    with r_g the least of its r_j > 0,
                                  at most e_g B_g            if every optimum has ||b_g|| <= B_g.

B_g follows from the value of the answer: the penalties of an optimum are at most that. So a dual point that
is not quite feasible gives a bound as well, and nothing is accepted within a tolerance. The answer's residual
suggests t = K (y - X b - b0). The gap is bounded as a sum of terms >= 0, without subtracting the bounds:

    P(b, b0) - D(t) = ||K (y - X b - b0) - t||^2 / (2K) + sum_g (penalties of b_g - v_g'b_g + its last part).

Source: Boyd and Vandenberghe, Convex Optimization, section 5.1; Ndiaye et al., Gap Safe screening rules for
sparsity enforcing penalties, JMLR 18 (2017).
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy.typing import NDArray

from convexperc.certificate.arithmetic import broken_assumption
from convexperc.certificate.rounding import (
    UNDERFLOW,
    Ball,
    Groups,
    U,
    down,
    gamma,
    inner,
    inner_by_group,
    norms_by_group,
    product,
    scaled_bounds,
    squared_norm,
    sum_bounds,
    up,
)
from convexperc.certificate.tolerances import Tolerances
from convexperc.lasso.objective import Coefficients, LeastSquares
from convexperc.problem.arrays import Matrix, Vector, times_power_of_two
from convexperc.problem.scaling import Bounds

STEPS = 60
"""Halvings of the search for a scale: more than float64 has digits."""
MODERATE = 64
"""Data whose lengths have a binary exponent of at most this stay as they are."""


@dataclass(frozen=True, eq=False)
class LassoCertificate:
    """What is proved of an answer (b, b0) to a penalised least-squares fit; rounding is included.

    Attributes
    ----------
    lower, upper : float
        lower <= P* <= upper, in the units of the objective; upper is the least known value.
    objective : (float, float)
        Bounds of P(b, b0); infinite where b >= 0 is asked for and an entry is negative.
    gap : float
        Upper bound of P(b, b0) - P*.
    relative_gap : float
        Upper bound of (P(b, b0) - P*) / P*: 0 where the gap is 0, else infinite where P* may be 0.
    share_of_target : float
        Upper bound of (P(b, b0) - P*) / (K/2 ||y||^2), the value without any feature.
    tolerances : Tolerances
        Certified means that relative_gap or share_of_target meets them.
    zero_features : bool (p,)
        True where b*_j = 0 is proved of every optimal b*.
    zero_groups : bool (m,)
        True where b*_g = 0 is proved; empty without groups.
    assumed : str
        The objective that was judged, as a formula.
    method : str
        How the gap was proved; or why nothing is.
    """

    lower: float
    upper: float
    objective: Bounds
    gap: float
    relative_gap: float
    share_of_target: float
    tolerances: Tolerances
    zero_features: NDArray[np.bool_]
    zero_groups: NDArray[np.bool_]
    assumed: str
    method: str

    @property
    def certified(self) -> bool:
        """Whether the gap is within the tolerances; false for NaN."""
        return self.tolerances.met_by_shares(self.relative_gap, self.share_of_target)


@dataclass(frozen=True, eq=False)
class _Data:
    """The objective in units in which X and y are about 1.

    X = 2^x X_, y = 2^k y_, b = 2^(k-x) b_, P = 2^2k P_. The lower coefficients make dual points, the upper
    ones bound P: smaller ones can only lower the optimum.
    """

    X: Matrix
    y: Ball
    K: Bounds
    l1: Coefficients
    group: Coefficients
    ridge: Coefficients
    groups: Groups | None
    intercept: bool
    positive: bool
    x: int
    k: int
    lengths: Float[np.ndarray, " p"]
    entry_error: float

    @classmethod
    def of(cls, given: LeastSquares) -> "_Data":
        lengths = _lengths(given.X)
        x, k = _exponent(lengths), _exponent(np.abs(given.y))
        X, y = times_power_of_two(given.X, -x) if x else given.X, times_power_of_two(given.y, -k)
        error = 0.0 if x == k == 0 else 2.0**-1074
        lengths = lengths if x == 0 else _lengths(X)
        K = Coefficients.of(given.loss, np.ones(1), 0, "the factor of the loss")
        l1, group = (
            Coefficients.of(each.factor, each.weights, -x - k, f"the {name} penalty")
            for name, each in (("l1", given.l1), ("group", given.group))
        )
        ridge = Coefficients.of(given.ridge.factor, given.ridge.weights, -2 * x, "the ridge penalty")
        return cls(
            X, Ball(y, np.full(y.shape, error)), (float(K.lower[0]), float(K.upper[0])), l1, group, ridge,
            given.groups, given.intercept, given.positive, x, k, lengths, error,
        )  # fmt: skip

    @property
    def target(self) -> Bounds:
        """K/2 ||y||^2, the value of b = 0, b0 = 0."""
        return _half(scaled_bounds(self.K, squared_norm(self.y)))


def _exponent(lengths: NDArray[np.float64]) -> int:
    largest = float(lengths.max(initial=0.0))
    exponent = math.frexp(largest)[1] if 0.0 < largest < math.inf else 0
    return exponent if abs(exponent) > MODERATE else 0


def _lengths(X: Matrix) -> Float[np.ndarray, " p"]:
    """Upper bounds of the lengths of the columns (as Lemma R21); infinite where one overflows."""
    n = X.shape[0]
    squares = np.einsum("ij,ij->j", X, X) * (1.0 + 4 * (n + 8) * U) + n * UNDERFLOW
    return np.asarray(np.nextafter(np.sqrt(squares), np.inf))


@dataclass(frozen=True, eq=False)
class _Answer:
    """An answer (b, b0), normalised; columns that b does not use are left out.

    Attributes
    ----------
    used : int (s,)
    b : Ball of shape (s,)
    residual : Ball of shape (n,)
        y - X b - b0.
    lengths : float64 (m,), (m,)
        Bounds of ||b_g||; none without groups.
    objective : (float, float)
        Bounds of P.
    slack : float
        Upper bound of what P loses if the lower coefficients stand in it.
    """

    used: NDArray[np.int64]
    b: Ball
    residual: Ball
    lengths: tuple[NDArray[np.float64], NDArray[np.float64]]
    objective: Bounds
    slack: float

    @classmethod
    def of(cls, data: _Data, coefficients: Vector, intercept: float) -> "_Answer":
        used = coefficients.nonzero()[0]
        b = _moved(coefficients[used], data.x - data.k)
        residual = data.y.plus(product(data.X[:, used], b, data.entry_error), -1.0)
        if intercept:
            residual = residual.plus(_moved(np.full(data.y.mid.shape, intercept), -data.k), -1.0)
        lengths = np.zeros(0), np.zeros(0)
        if data.groups is not None:
            lengths = norms_by_group(_scattered(b, used, coefficients.size), data.groups)
        sizes = np.maximum(np.abs(b.mid) - b.rad, 0.0) * (1.0 - 4 * U), b.magnitude()
        squares = sizes[0] * sizes[0] * (1.0 - 4 * U), sizes[1] * sizes[1] * (1.0 + 4 * U) + UNDERFLOW
        square = squared_norm(residual)
        ridge = _weighted(data.ridge, squares, used)
        low, high = sum_bounds(
            _half(scaled_bounds(data.K, square)), _weighted(data.l1, sizes, used),
            _weighted(data.group, lengths), _half(ridge),
        )  # fmt: skip
        slack = up(2.0**-48 * high)  # the coefficients are known to 16 units in the last place
        known = math.isfinite(high) and not (data.positive and bool((coefficients < 0.0).any()))
        return cls(used, b, residual, lengths, (low, high) if known else (0.0, math.inf), slack)


def _moved(values: Vector, exponent: int) -> Ball:
    """Values times a power of two; what underflows has the radius of that (Lemma R20)."""
    if exponent == 0:
        return Ball.exact(values)
    with np.errstate(over="ignore", under="ignore"):
        moved = times_power_of_two(values, exponent)
    return Ball(moved, np.where((np.abs(moved) < 2.0**-1000) & (values != 0.0), UNDERFLOW, 0.0))


def _scattered(x: Ball, places: NDArray[np.int64], size: int) -> Ball:
    """A vector with the entries of x at these places, and 0 elsewhere."""
    every = Ball.exact(np.zeros(size))
    every.mid[places], every.rad[places] = x.mid, x.rad
    return every


def _half(bounds: Bounds) -> Bounds:
    return max(0.0, down(0.5 * bounds[0])) if bounds[0] else 0.0, up(0.5 * bounds[1]) if bounds[1] else 0.0


def _weighted(
    coefficients: Coefficients,
    sizes: tuple[NDArray[np.float64], NDArray[np.float64]],
    used: NDArray[np.int64] | slice = slice(None),
) -> Bounds:
    """Bounds of the sum of c_j s_j, both >= 0 (as Lemma R8)."""
    lower, upper = coefficients.lower[used], coefficients.upper[used]
    k = lower.size
    if not k or not upper.any():
        return 0.0, 0.0
    charged = gamma(k + 4)
    low, high = float(lower @ sizes[0]), float(upper @ sizes[1])
    return max(0.0, down(low * (1.0 - 2 * charged) - k * UNDERFLOW)), up(
        high * (1.0 + 2 * charged) + k * UNDERFLOW
    )


@dataclass(frozen=True, eq=False)
class _Ray:
    """A dual point t before it is scaled, orthogonal to 1 where there is an intercept.

    Attributes
    ----------
    t : Ball of shape (n,)
    v : Ball of shape (p,)
        X't.
    linear, quadratic : Bounds
        D(s t) = s linear - s^2 quadratic - what the penalties take.
    """

    t: Ball
    v: Ball
    linear: Bounds
    quadratic: Bounds

    @classmethod
    def of(cls, data: _Data, t: Vector) -> "_Ray":
        n = t.size
        point, pull = Ball.exact(t), _correlations(data, t)
        if data.intercept:
            total = inner(point, Ball.exact(np.ones(n)))
            mean = Ball(np.array([0.5 * (total[0] + total[1]) / n]), np.zeros(1))
            mean = Ball(
                mean.mid, np.array([up(up((total[1] - total[0]) / n) + 4 * U * abs(float(mean.mid[0])))])
            )
            every = Ball(np.repeat(mean.mid, n), np.repeat(mean.rad, n))
            sums = _correlations(data, np.ones(n))
            point, pull = point.plus(every, -1.0), pull.plus(_products(sums, mean), -1.0)
        low, high = squared_norm(point)
        quadratic = max(0.0, down(down(0.5 * low) / data.K[1])), up(up(0.5 * high) / data.K[0])
        return cls(point, pull, inner(data.y, point), quadratic)


def _correlations(data: _Data, t: Vector) -> Ball:
    """X't: each entry errs by at most gamma_n times the two lengths (as Lemma R24)."""
    n, length = t.size, up(math.sqrt(squared_norm(Ball.exact(t))[1]))
    size = float(np.abs(t).sum())
    outside = (UNDERFLOW + data.entry_error) * (n + size * (1.0 + 4 * (n + 8) * U))
    rad = (gamma(n + 2) * length) * data.lengths + outside
    return Ball(t @ data.X, rad * (1.0 + 16 * U))


def _products(x: Ball, factor: Ball) -> Ball:
    """Each entry of x times one number that is known up to its radius (as Lemma R6)."""
    mid, size = float(factor.mid[0]), float(factor.magnitude()[0])
    exact = x.times(mid)
    return Ball(
        exact.mid,
        (exact.rad + (np.abs(x.mid) + x.rad) * float(factor.rad[0]) + UNDERFLOW * (1.0 + size))
        * (1.0 + 16 * U),
    )


@dataclass(frozen=True, eq=False)
class _Limits:
    """What every optimum obeys, by group or by column without groups: ||b_g|| <= B_g; the least r_j of each.

    Attributes
    ----------
    most : float64 (k,)
    ridge : float64 (k,)
    """

    most: NDArray[np.float64]
    ridge: NDArray[np.float64]

    @classmethod
    def of(cls, data: _Data, upper: float) -> "_Limits":
        """From an upper bound of P*, which no penalty of an optimum exceeds."""
        l1, ridge = _least(data, data.l1.lower), _least(data, data.ridge.lower)
        with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
            sums = (l1 + (data.group.lower if data.groups is not None else 0.0)) * (1.0 - 4 * U)
            by_norm = np.where(sums > 0.0, upper / sums, np.inf)
            by_square = np.where(ridge > 0.0, np.sqrt(2.0 * upper / ridge), np.inf)
        return cls(np.minimum(by_norm, by_square) * (1.0 + 16 * U), ridge)


def _least(data: _Data, values: NDArray[np.float64]) -> NDArray[np.float64]:
    """The least of each group; the values without groups."""
    if data.groups is None:
        return values
    ordered = values if data.groups.order is None else values[data.groups.order]
    return np.asarray(np.minimum.reduceat(ordered, data.groups.starts))


def _excess(data: _Data, v: Ball, s: float) -> NDArray[np.float64]:
    """Upper bounds of (||S(s v_g, l_g)|| - c_g)+; 0 only where that is proved."""
    reached = s * ((v.mid if data.positive else np.abs(v.mid)) + v.rad) * (1.0 + 8 * U)
    beyond = np.where(reached > data.l1.lower, (reached - data.l1.lower) * (1.0 + 4 * U), 0.0)
    if data.groups is None:
        return np.asarray(beyond)
    squares = data.groups.sums(beyond * beyond)
    lengths = np.sqrt(squares) * (1.0 + 2 * (data.groups.sizes + 8.0) * U)
    lengths = np.where(squares > 0.0, lengths, data.groups.sums(beyond))
    limit = data.group.lower
    return np.where(lengths > limit, (lengths - limit) * (1.0 + 4 * U), 0.0)


@dataclass(frozen=True, eq=False)
class _DualPoint:
    """s t, and what the penalties take off its value."""

    ray: _Ray
    scale: float
    charge: float

    @property
    def lower(self) -> float:
        """A lower bound of P*."""
        s, ray = self.scale, self.ray
        value = down(down(s * ray.linear[0]) - up(up(s * s) * ray.quadratic[1]))
        return down(value - self.charge) if self.charge else value


def _dual_points(data: _Data, ray: _Ray, limits: _Limits) -> Iterator[_DualPoint]:
    if not (math.isfinite(ray.linear[0]) and math.isfinite(ray.quadratic[1])):
        return
    best = 0.5 * (ray.linear[0] + ray.linear[1]) / (2.0 * ray.quadratic[1]) if ray.quadratic[1] > 0.0 else 1.0
    room = _room(data, ray.v, limits.ridge, max(best, 0.0))
    for s in dict.fromkeys((room, min(best, 1.0), 1.0)):
        if s > 0.0:
            excess = _excess(data, ray.v, s)
            beyond = excess.nonzero()[0]
            e, most, ridge = excess[beyond], limits.most[beyond], limits.ridge[beyond]
            with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
                by_ridge = np.where(ridge > 0.0, e * e / (2.0 * ridge), np.inf)
                parts = np.minimum(by_ridge, e * most) * (1.0 + 16 * U)
            charge = float(parts.sum()) * (1.0 + 4 * (parts.size + 8) * U)
            charge = up(charge) + UNDERFLOW if beyond.size else 0.0
            yield _DualPoint(ray, s, math.inf if math.isnan(charge) else charge)


def _room(data: _Data, v: Ball, ridge: NDArray[np.float64], best: float) -> float:
    """About the largest s <= best at which no group without a ridge penalty has an excess."""
    tight = ridge == 0.0
    if not (_excess(data, v, best)[tight] > 0.0).any():
        return best
    low, high = 0.0, best
    for _ in range(STEPS):
        middle = 0.5 * (low + high)
        if (_excess(data, v, middle)[tight] > 0.0).any():
            high = middle
        else:
            low = middle
    return low


def _gap(data: _Data, answer: _Answer, dual: _DualPoint) -> float:
    """Upper bound of P - D as a sum of terms >= 0; see the module."""
    s = dual.scale
    off = answer.residual.times(data.K[0]).plus(dual.ray.t.times(s), -1.0)
    loss = up(up(0.5 * squared_norm(off)[1]) / data.K[0])
    b, v = answer.b, dual.ray.v
    pull = Ball(v.mid[answer.used], v.rad[answer.used]).times(s)
    slope = np.sign(b.mid) * data.l1.lower[answer.used]
    curve = 0.5 * data.ridge.lower[answer.used] * b.mid
    error = np.where(
        b.rad > 0.0, 2.0 * data.l1.lower[answer.used] + data.ridge.lower[answer.used] * b.rad, 0.0
    )
    own = Ball(slope + curve, error + 4 * U * (np.abs(slope) + np.abs(curve)) + UNDERFLOW).plus(pull, -1.0)
    if data.groups is None:
        penalties = inner(b, own)[1]
    else:
        whole, other = (_scattered(each, answer.used, v.mid.size) for each in (b, own))
        norms = _weighted(Coefficients(data.group.lower, data.group.lower), answer.lengths)
        parts = inner_by_group(whole, other, data.groups)[1]
        penalties = up(
            norms[1] + up(float(parts.sum()) + (parts.size + 8) * 2 * U * float(np.abs(parts).sum()))
        )
    total = up(loss + up(penalties + dual.charge))  # beside a ridge penalty the second part may be negative
    return math.inf if math.isnan(total) else up(max(0.0, total) + answer.slack)


def _zeros(data: _Data, dual: _DualPoint, gap: float) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Columns and groups that no optimum uses: ||t* - s t|| <= sqrt(2 K gap) (as Lemma R38).

    With ||b_g|| <= B_g the dual is as strongly concave, and t* = K (y - X b* - b0*) is its maximum as well.
    """
    root = up(math.sqrt(up(up(2.0 * data.K[1]) * gap)))
    v, reach = dual.ray.v, root * data.lengths
    far = ((dual.scale * ((v.mid if data.positive else np.abs(v.mid)) + v.rad)) + reach) * (
        1.0 + 16 * U
    ) + UNDERFLOW
    columns = far < data.l1.lower
    if data.groups is None:
        return columns, np.zeros(0, dtype=bool)
    beyond = np.maximum(far - data.l1.lower, 0.0) * (1.0 + 4 * U)
    k = data.groups.sizes
    lengths = np.sqrt(data.groups.sums(beyond * beyond) * (1.0 + 4 * (k + 8.0) * U) + k * UNDERFLOW) * (
        1.0 + 4 * U
    )
    groups = lengths < data.group.lower
    places = np.repeat(groups, k.astype(np.int64))
    every = np.empty_like(columns)
    every[np.arange(columns.size) if data.groups.order is None else data.groups.order] = places
    return columns | every, groups


def certificate(
    given: LeastSquares, coefficients: Vector, intercept: float, tolerances: Tolerances, assumed: str
) -> LassoCertificate:
    """Bound how far (b, b0) is from the optimum; see `certify_lasso`."""
    p, m = given.X.shape[1], 0 if given.groups is None else given.groups.starts.size
    zeros = np.zeros(p, dtype=bool), np.zeros(m, dtype=bool)
    broken = broken_assumption(min(given.X.shape))
    if broken:
        unknown = (0.0, math.inf, (0.0, math.inf), math.inf, math.inf, math.inf)
        return LassoCertificate(*unknown, tolerances, *zeros, assumed, broken)
    with np.errstate(all="ignore"):
        data = _Data.of(given)
        answer = _Answer.of(data, coefficients, intercept)
        upper = min(answer.objective[1], data.target[1])
        lower, gap, method = 0.0, answer.objective[1], "P >= 0"
        t = data.K[0] * answer.residual.mid
        duals = _dual_points(data, _Ray.of(data, t), _Limits.of(data, upper)) if np.isfinite(t).all() else ()
        for dual in duals:
            lower = max(lower, dual.lower)
            total = _gap(data, answer, dual) if math.isfinite(answer.objective[1]) else math.inf
            if total < gap:
                gap, method = total, f"dual point, {'charged' if dual.charge else 'feasible'}"
            found = _zeros(data, dual, up(max(0.0, upper - min(dual.lower, upper))))
            zeros = zeros[0] | found[0], zeros[1] | found[1]
        lower = min(lower, upper)
        gap = min(gap, max(0.0, up(answer.objective[1] - lower)))
        lower = max(lower, down(answer.objective[0] - gap)) if math.isfinite(gap) else lower
        lower = min(max(lower, 0.0), upper)
    ends = [_back(end, data.k) for end in (lower, upper, *answer.objective, gap)]
    values = ends[0][0], ends[1][1], (ends[2][0], ends[3][1]), ends[4][1]
    return LassoCertificate(
        *values, _share(gap, lower), _share(gap, data.target[0]), tolerances, *zeros, assumed, method
    )


def _back(value: float, k: int) -> Bounds:
    """Value * 2^2k as (lower, upper) (as Lemma R19)."""
    moved = float(np.ldexp(value, 2 * k))
    if k == 0 or (math.isfinite(moved) and float(np.ldexp(moved, -2 * k)) == value):
        return moved, moved
    return max(0.0, down(min(moved, 2.0**1023))), up(moved)


def _share(gap: float, of: float) -> float:
    if gap == 0.0:
        return 0.0
    return up(gap / of) if of > 0.0 and math.isfinite(gap) else math.inf
