"""The objective and an answer to it, in units in which X and y are about 1, with bounds of their rounding."""

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy.typing import NDArray

from convexperc.certificate.rounding import (
    UNDERFLOW,
    Ball,
    Groups,
    U,
    down,
    gamma,
    norms_by_group,
    sum_bounds,
    up,
)
from convexperc.lasso.design import Design
from convexperc.lasso.objective import Coefficients, LeastSquares
from convexperc.problem.arrays import Vector, times_power_of_two
from convexperc.problem.scaling import Bounds

MODERATE = 64
"""Data whose largest entry has a binary exponent of at most this stay as they are."""
UNITS = 2.0**-48
"""Coefficients are known to 16 units in the last place: more than P can lose by it, as a share."""


@dataclass(frozen=True, eq=False)
class ScaledData:
    """X = 2^x X_, y = 2^k y_, b = 2^(k-x) b_, P = 2^2k P_.

    The lower coefficients make dual points, the upper ones bound P: smaller ones can only lower the optimum.

    Attributes
    ----------
    design : Design
        X_, each entry within `entry_error`.
    y : Ball of shape (n,)
    loss : Coefficients (n,)
        K w_i, all > 0.
    l1, ridge : Coefficients (p,)
    group : Coefficients (m,)
    groups : Groups or None
    intercept, positive : bool
    x, k : int
    lengths : float64 (p,)
        Upper bounds of sqrt(sum_i K w_i x_ij^2).
    entry_error : float
    """

    design: Design
    y: Ball
    loss: Coefficients
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
    def of(cls, given: LeastSquares) -> "ScaledData":
        """Scale by powers of two where the data are far from 1."""
        x, k = _exponent(given.design.largest()), _exponent(float(np.abs(given.y).max()))
        design, y = given.design.scaled(-x), times_power_of_two(given.y, -k)
        error = 0.0 if x == k == 0 else 2.0**-1074
        n = y.size
        loss = Coefficients.of(given.loss.factor, given.loss.weights, 0, "the loss")
        if loss.upper.size == 1:
            lengths = _lengths(design, None) * math.sqrt(float(loss.upper[0])) * (1.0 + 4 * U)
            loss = Coefficients(np.repeat(loss.lower, n), np.repeat(loss.upper, n))
        else:
            lengths = _lengths(design, loss.upper)
        l1, group = (
            Coefficients.of(each.factor, each.weights, -x - k, f"the {name} penalty")
            for name, each in (("l1", given.l1), ("group", given.group))
        )
        ridge = Coefficients.of(given.ridge.factor, given.ridge.weights, -2 * x, "the ridge penalty")
        return cls(
            design, Ball(y, np.full(y.shape, error)), loss, l1, group, ridge, given.groups, given.intercept,
            given.positive, x, k, lengths, error,
        )  # fmt: skip

    @property
    def target(self) -> Bounds:
        """Half the sum of K w_i y_i^2, the value of b = 0, b0 = 0."""
        return half(self.loss_of(self.y))

    def loss_of(self, residual: Ball) -> Bounds:
        """Bounds of the sum of K w_i r_i^2."""
        return weighted(self.loss, squares(sizes(residual)))

    @property
    def free(self) -> NDArray[np.bool_]:
        """The columns that nothing penalises."""
        found: NDArray[np.bool_] = (self.l1.upper == 0.0) & (self.ridge.upper == 0.0)
        if self.groups is not None:
            found &= self.by_column(self.group.upper) == 0.0
        return found

    def by_column(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """The value of each group for each of its columns."""
        assert self.groups is not None
        found = np.empty(self.l1.upper.size)
        order = slice(None) if self.groups.order is None else self.groups.order
        found[order] = np.repeat(values, self.groups.sizes.astype(np.int64))
        return found


def _exponent(largest: float) -> int:
    exponent = math.frexp(largest)[1]
    return exponent if abs(exponent) > MODERATE else 0


def _lengths(design: Design, weights: Vector | None) -> Float[np.ndarray, " p"]:
    """Upper bounds of the lengths of the columns (as Lemma R21); infinite where one overflows."""
    n = design.shape[0]
    found = design.squares(weights) * (1.0 + 4 * (n + 12) * U) + n * UNDERFLOW
    return np.asarray(np.nextafter(np.sqrt(found), np.inf))


def sizes(x: Ball) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Bounds of the absolute values."""
    return np.maximum(np.abs(x.mid) - x.rad, 0.0) * (1.0 - 4 * U), x.magnitude()


def squares(
    bounds: tuple[NDArray[np.float64], NDArray[np.float64]],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Bounds of the squares of numbers >= 0."""
    return bounds[0] * bounds[0] * (1.0 - 4 * U), np.where(
        bounds[1] > 0.0, bounds[1] * bounds[1] * (1.0 + 4 * U) + UNDERFLOW, 0.0
    )


def half(bounds: Bounds) -> Bounds:
    """Half of a number >= 0."""
    return max(0.0, down(0.5 * bounds[0])) if bounds[0] else 0.0, up(0.5 * bounds[1]) if bounds[1] else 0.0


def weighted(
    coefficients: Coefficients,
    values: tuple[NDArray[np.float64], NDArray[np.float64]],
    used: NDArray[np.int64] | slice = slice(None),
) -> Bounds:
    """Bounds of the sum of c_j s_j, both >= 0 (as Lemma R8)."""
    lower, upper = coefficients.lower[used], coefficients.upper[used]
    k = lower.size
    if not k or not upper.any() or not values[1].any():
        return 0.0, 0.0
    charged = gamma(k + 4)
    low, high = float(lower @ values[0]), float(upper @ values[1])
    return max(0.0, down(low * (1.0 - 2 * charged) - k * UNDERFLOW)), up(
        high * (1.0 + 2 * charged) + k * UNDERFLOW
    )


@dataclass(frozen=True, eq=False)
class ScaledAnswer:
    """An answer (b, b0); columns that b does not use are left out.

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
    def of(cls, data: ScaledData, coefficients: Vector, intercept: float) -> "ScaledAnswer":
        """Evaluate P at an answer in the units of the data as given."""
        used = coefficients.nonzero()[0]
        b = _moved(coefficients[used], data.x - data.k)
        residual = data.y.plus(data.design.fitted(used, b, data.entry_error), -1.0)
        if intercept:
            residual = residual.plus(_moved(np.full(data.y.mid.shape, intercept), -data.k), -1.0)
        lengths = np.zeros(0), np.zeros(0)
        if data.groups is not None:
            lengths = norms_by_group(scattered(b, used, coefficients.size), data.groups)
        entries = sizes(b)
        low, high = sum_bounds(
            half(data.loss_of(residual)), weighted(data.l1, entries, used), weighted(data.group, lengths),
            half(weighted(data.ridge, squares(entries), used)),
        )  # fmt: skip
        known = math.isfinite(high) and not (data.positive and bool((coefficients < 0.0).any()))
        return cls(used, b, residual, lengths, (low, high) if known else (0.0, math.inf), up(UNITS * high))


def _moved(values: Vector, exponent: int) -> Ball:
    """Values times a power of two; what underflows has the radius of that (Lemma R20)."""
    if exponent == 0:
        return Ball.exact(values)
    with np.errstate(over="ignore", under="ignore"):
        moved = times_power_of_two(values, exponent)
    return Ball(moved, np.where((np.abs(moved) < 2.0**-1000) & (values != 0.0), UNDERFLOW, 0.0))


def scattered(x: Ball, places: NDArray[np.int64], size: int) -> Ball:
    """A vector with the entries of x at these places, and 0 elsewhere."""
    every = Ball.exact(np.zeros(size))
    every.mid[places], every.rad[places] = x.mid, x.rad
    return every
