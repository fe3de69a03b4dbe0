"""Rounding made visible: float64 values together with a bound on their error.

docs/rounding.md has the lemmas that the docstrings name, and what they assume of the machine;
`convexperc.certificate.arithmetic` looks whether it is so.

Source: Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., section 3.1 (gamma_k);
Rump, Verification of positive definiteness, BIT 46 (2006).
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from convexperc.caching import cached_property
from convexperc.problem.arrays import Matrix

U = 2.0**-53
"""Unit roundoff of binary64."""
UNDERFLOW = 2.0**-1020
"""More than a few operations lose by underflow."""
Floats = NDArray[np.float64]


def gamma(k: int) -> float:
    """k u / (1 - k u), the relative error of k roundings in a row, rounded up (Lemma R1)."""
    return k * U / (1.0 - k * U) * (1.0 + 8 * U)


def up(value: float) -> float:
    """The next float above (Lemma R2)."""
    return math.nextafter(value, math.inf)


def down(value: float) -> float:
    """The next float below (Lemma R3)."""
    return math.nextafter(value, -math.inf)


@dataclass(frozen=True)
class Ball:
    """Real numbers known to lie within `rad` of the floats `mid`, entry by entry.

    Attributes
    ----------
    mid, rad : float64 arrays of one shape
        rad >= 0; infinite where nothing is known.
    """

    mid: Floats
    rad: Floats

    @classmethod
    def exact(cls, values: Floats) -> "Ball":
        """Floats that stand for themselves."""
        return cls(values, np.zeros_like(values))

    def magnitude(self) -> Floats:
        """Upper bounds of the absolute values (Lemma R4)."""
        return (np.abs(self.mid) + self.rad) * (1.0 + 4 * U)

    def plus(self, other: "Ball", sign: float = 1.0) -> "Ball":
        """Self + sign * other with sign = 1 or -1 (Lemma R5)."""
        mid = self.mid + sign * other.mid
        rad = (self.rad + other.rad + U * np.abs(mid)) * (1.0 + 8 * U)
        zero = (self.mid == 0) & (other.mid == 0) & (rad == 0)
        return Ball(mid, np.where(zero, 0.0, rad + UNDERFLOW))

    def times(self, factor: float) -> "Ball":
        """The product with one float (Lemma R6)."""
        mid = self.mid * factor
        rad = (self.rad * abs(factor) + U * np.abs(mid)) * (1.0 + 8 * U)
        return Ball(mid, np.where((self.mid == 0) & (self.rad == 0), 0.0, rad + UNDERFLOW))


def product(A: Matrix, x: Ball, entry_error: float = 0.0, absolute: Matrix | None = None) -> Ball:
    """Enclose A x (Lemma R7).

    Parameters
    ----------
    A : float64 (r, k)
        Each entry within `entry_error` of the number that it stands for.
    x : Ball of shape (k,)
    absolute : float64 (r, k), optional
        |A|, where the caller has it.

    Returns
    -------
    Ball of shape (r,)
    """
    k = A.shape[1]
    size = np.abs(x.mid)
    sizes, radii = float(size.sum()), float(x.rad.sum())
    if sizes == 0.0 and radii == 0.0 and not (size.any() or x.rad.any()):
        return Ball.exact(np.zeros(A.shape[0]))
    mid = A @ x.mid
    absolute = np.abs(A) if absolute is None else absolute
    rad = gamma(k + 1) * (absolute @ size)
    if radii != 0.0:
        rad = rad + absolute @ x.rad
    outside = (UNDERFLOW + entry_error) * (k + sizes + radii)
    return Ball(mid, (rad + outside) * (1.0 + 4 * (k + 8) * U))


def inner(x: Ball, y: Ball) -> tuple[float, float]:
    """Enclose x'y as (lower, upper) (Lemma R8)."""
    k = x.mid.size
    mid = float(x.mid @ y.mid)
    ax, ay = np.abs(x.mid), np.abs(y.mid)
    rad = gamma(k + 1) * float(ax @ ay) + float(ax @ y.rad) + float(x.rad @ ay) + float(x.rad @ y.rad)
    if rad != 0.0 or ((ax.any() or x.rad.any()) and (ay.any() or y.rad.any())):
        rad = up((rad + k * UNDERFLOW) * (1.0 + 4 * (k + 8) * U))
    return _around(mid, rad)


def squared_norm(x: Ball) -> tuple[float, float]:
    """Enclose ||x||_2^2 as (lower, upper), both >= 0 (Lemma R9)."""
    k = x.mid.size
    mid = float(x.mid @ x.mid)
    rad = gamma(k + 1) * mid + 2.0 * float(np.abs(x.mid) @ x.rad) + float(x.rad @ x.rad)
    if rad != 0.0 or x.mid.any() or x.rad.any():
        rad = up((rad + k * UNDERFLOW) * (1.0 + 4 * (k + 8) * U))
    lower, upper = _around(mid, rad)
    return max(0.0, lower), upper


def norm_bounds(x: Ball) -> tuple[float, float]:
    """Enclose ||x||_2 as (lower, upper) (Lemma R10)."""
    lower, upper = squared_norm(x)
    return max(0.0, down(math.sqrt(lower))), up(math.sqrt(upper)) if upper > 0.0 else 0.0


@dataclass(frozen=True, eq=False)
class Groups:
    """A partition of 0 .. d-1 into consecutive groups, after a reordering where there must be one.

    Attributes
    ----------
    order : int (d,) or None
        What is taken first; None for the order as it is.
    starts : int (m,)
        Where each group starts.
    sizes : float64 (m,)
    """

    order: NDArray[np.int64] | None
    starts: NDArray[np.int64]
    sizes: Floats

    @classmethod
    def of(cls, columns: tuple[slice | NDArray[np.int64], ...], sizes: tuple[int, ...]) -> "Groups":
        """Group by slices or by numbers."""
        stops = np.cumsum(sizes)
        starts, lengths = stops - np.array(sizes), np.array(sizes, dtype=np.float64)
        firsts = [c.start if isinstance(c, slice) and c.step in (None, 1) else -1 for c in columns]
        if firsts == starts.tolist():
            return cls(None, starts, lengths)
        every = np.arange(stops[-1])
        return cls(np.concatenate([every[c] for c in columns]), starts, lengths)

    @cached_property
    def rounding(self) -> Floats:
        """`gamma` of one more than each size (Lemma R1)."""
        k = self.sizes + 1.0
        return k * U / (1.0 - k * U) * (1.0 + 8 * U)

    def sums(self, values: Floats) -> Floats:
        """The sum of each group."""
        return np.asarray(np.add.reduceat(self._ordered(values), self.starts))

    def any(self, values: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Whether any value of each group is true."""
        return np.asarray(np.logical_or.reduceat(self._ordered(values), self.starts))

    def _ordered(self, values: NDArray[Any]) -> NDArray[Any]:
        return values if self.order is None else values[self.order]


def inner_by_group(x: Ball, y: Ball, groups: Groups) -> tuple[Floats, Floats]:
    """Enclose the inner product of each group, as `inner` does, into (lower, upper) (Lemma R11)."""
    products, k = x.mid * y.mid, groups.sizes
    mid, rad = groups.sums(products), groups.rounding * groups.sums(np.abs(products))
    if x.rad.any() or y.rad.any():
        ax, ay = np.abs(x.mid), np.abs(y.mid)
        rad = rad + groups.sums(ax * y.rad + x.rad * ay + x.rad * y.rad)
    charged = np.nextafter((rad + (k + 1.0) * UNDERFLOW) * (1.0 + 4 * (k + 12.0) * U), np.inf)
    high = mid + charged
    lower, upper = np.nextafter(mid - charged, -np.inf), np.nextafter(high, np.inf)
    if not np.isfinite(high).all():
        known = np.isfinite(mid) & np.isfinite(charged)
        lower, upper = np.where(known, lower, -np.inf), np.where(known, upper, np.inf)
    if not rad.all():
        some = groups.any((x.mid != 0.0) | (x.rad != 0.0)) & groups.any((y.mid != 0.0) | (y.rad != 0.0))
        lower, upper = np.where(some, lower, 0.0), np.where(some, upper, 0.0)
    return lower, upper


def norms_by_group(x: Ball, groups: Groups) -> tuple[Floats, Floats]:
    """Enclose the 2-norm of each group into (lower, upper) (Lemma R12)."""
    lower, upper = inner_by_group(x, x, groups)
    low, high = np.sqrt(np.maximum(lower, 0.0)), np.sqrt(np.maximum(upper, 0.0))
    return np.maximum(np.nextafter(low, -np.inf), 0.0), np.where(high > 0.0, np.nextafter(high, np.inf), 0.0)


def sum_bounds(*parts: tuple[float, float]) -> tuple[float, float]:
    """Enclose the sum of scalars that are given as (lower, upper)."""
    return _fold_down([p[0] for p in parts]), _fold_up([p[1] for p in parts])


def scaled_bounds(factor: tuple[float, float], value: tuple[float, float]) -> tuple[float, float]:
    """Enclose the product of two numbers >= 0, each given as (lower, upper); 0 * inf is 0 (Lemma R16)."""
    low = factor[0] * value[0] if factor[0] and value[0] else 0.0
    high = factor[1] * value[1] if factor[1] and value[1] else 0.0
    return max(0.0, down(low)) if low else 0.0, up(high) if factor[1] and value[1] else 0.0


def _around(mid: float, rad: float) -> tuple[float, float]:
    """The interval mid - rad to mid + rad, rounded outwards (Lemma R13)."""
    if not (math.isfinite(mid) and math.isfinite(rad)):
        return -math.inf, math.inf
    if rad == 0.0:
        return mid, mid
    return down(mid - rad), up(mid + rad)


def _fold_up(values: list[float]) -> float:
    """The sum, rounded up (Lemma R14)."""
    total = 0.0
    for value in values:
        if value:
            total = up(total + value) if total else value
    return total


def _fold_down(values: list[float]) -> float:
    """The sum, rounded down (Lemma R15)."""
    total = 0.0
    for value in values:
        if value:
            total = down(total + value) if total else value
    return total


def smallest_singular_value(X: Matrix, entry_error: float = 0.0) -> float:
    """A proved lower bound of sigma_min(X') for n <= d (0 where nothing can be proved) (Lemma R18).

    Formula: sigma_min(X')^2 = lambda_min(X X'), whose rounding is at most gamma_d ||X||_F^2.

    Parameters
    ----------
    X : float64 (n, d)

    Returns
    -------
    float
    """
    n, d = X.shape
    if n > d:
        return 0.0
    gram = X @ X.T
    total = up(float(np.trace(gram)) * (1.0 + 4 * (n + d) * U))
    error = gamma(d + 2) * total + n * d * (UNDERFLOW + entry_error * (1.0 + total))
    return max(0.0, down(math.sqrt(smallest_eigenvalue(gram, error))))


def smallest_eigenvalue(G: Matrix, error: float) -> float:
    """A proved lower bound of lambda_min(A), ||A - G||_2 <= error, or 0 (Lemma R17).

    Formula: G - c I has a Cholesky factor in floating point only if G >= (c - e) I, where
    e = 2 gamma_(n+3) trace(G) bounds all rounding (Rump 2006).

    Parameters
    ----------
    G : float64 (n, n)
        Its lower triangle is read.
    error : float

    Returns
    -------
    float
    """
    n = G.shape[0]
    slack = error + 4 * gamma(n + 4) * up(float(np.trace(G)) * (1.0 + 4 * n * U))
    if not math.isfinite(slack):
        return 0.0
    try:
        shift = 0.5 * float(np.linalg.eigvalsh(G)[0])
        if not shift > 4 * slack:
            return 0.0
        np.linalg.cholesky(G - shift * np.eye(n))
    except np.linalg.LinAlgError:
        return 0.0
    return max(0.0, down(shift - 2 * slack))
