"""Problems in whole numbers, in order of size, and the loop on thousands of them at once in float64.

A screen only: what it finds is confirmed in exact arithmetic, and what it misses is below its tolerance.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from verification.exact.algorithm import SIZES, Update
from verification.exact.problem import ExactProblem

Floats = NDArray[np.float64]
Whole = NDArray[np.int64]

BATCH = 20000
WORST = 1e12
"""Systems of a larger condition number, after scaling their diagonal to 1, leave the screen."""

ZERO = 1e-12
"""A smaller entry of the start is rounding of an exact 0: the data are small whole numbers."""


def shapes(largest: int) -> Iterator[tuple[int, tuple[int, ...]]]:
    """Every n and every partition of d columns with n + d = `largest`."""
    for n in range(1, largest):
        for sizes in _partitions(largest - n):
            yield n, sizes


@cache
def problems(n: int, sizes: tuple[int, ...], total: int, lambda1: int = 1) -> tuple[tuple[int, ...], ...]:
    """Every (X, o, lambda1, lambda2, lambda3) in whole numbers whose sizes add up to `total`.

    No row of X is 0, lambda1 >= `lambda1`, and the first entry of X is > 0: columns can be exchanged, with
    their modalities, and change their sign with that of o without any change to w or F.
    """
    d = sum(sizes)
    return tuple(
        numbers
        for numbers in _whole(n * d + d + 3, total, signed=n * d + d)
        if numbers[0] > 0
        and numbers[-3] >= lambda1
        and all(any(numbers[i * d : i * d + d]) for i in range(n))
    )


def whole_problem(n: int, sizes: tuple[int, ...], numbers: Whole) -> ExactProblem:
    """Put a row of `problems` together."""
    d, values = sum(sizes), [int(x) for x in numbers]
    rows = [values[i * d : i * d + d] for i in range(n)]
    return ExactProblem.small(rows, values[n * d : n * d + d], sizes, *values[-3:])


@dataclass(frozen=True, eq=False)
class Batch:
    """Many problems of one shape in float64.

    Attributes
    ----------
    X : float64 (k, n, d)
    o : float64 (k, d)
    lambdas : float64 (3, k)
    groups : float64 (m, d)
        1 where the column belongs to the modality.
    """

    X: Floats
    o: Floats
    lambdas: Floats
    groups: Floats

    @classmethod
    def of(cls, n: int, sizes: tuple[int, ...], rows: Whole) -> "Batch":
        """Read rows of `problems`."""
        d, numbers = sum(sizes), rows.astype(np.float64)
        X, o = numbers[:, : n * d].reshape(-1, n, d), numbers[:, n * d : n * d + d]
        return cls(X, o, numbers[:, -3:].T, np.repeat(np.eye(len(sizes)), sizes, axis=1))

    def start(self) -> tuple[Floats, Floats]:
        """The paper's start, exact zeros restored."""
        inverse = np.linalg.pinv(self.X)
        w = _cleaned(np.einsum("bdn,bd->bn", inverse, self.o))
        return w, _cleaned(np.einsum("bdn,bn->bd", inverse, w))

    def residuals(self, w: Floats, u: Floats) -> tuple[Floats, Floats]:
        """X'w - o and Xu - w."""
        return np.einsum("bnd,bn->bd", self.X, w) - self.o, np.einsum("bnd,bd->bn", self.X, u) - w

    def norms(self, u: Floats) -> Floats:
        """||u^i|| by modality, shape (k, m)."""
        return np.asarray(np.sqrt((u * u) @ self.groups.T))

    def objective(self, w: Floats, u: Floats) -> Floats:
        """F, shape (k,)."""
        (l1, l2, l3), (p, q) = self.lambdas, self.residuals(w, u)
        smooth = (p * p).sum(1) + l1 * (q * q).sum(1)
        return np.asarray(smooth + l2 * np.abs(w).sum(1) + l3 * self.norms(u).sum(1))

    def step(self, update: Update, w: Floats, u: Floats) -> tuple[Floats, Floats]:
        """One iteration; NaN where a matrix is (nearly) singular."""
        l1, l2, l3 = self.lambdas
        half, eps, X = float(update.factor) / 2, float(update.eps), self.X
        absolute = np.abs(w)
        sizes = {
            "w_i": w,
            "|w_i|": absolute,
            "||w||_1": np.broadcast_to(absolute.sum(1, keepdims=True), w.shape),
            "sqrt(w_i^2 + eps^2)": np.hypot(w, eps),
        }[SIZES[update.reading][0]]
        blocks = np.hypot(self.norms(u), eps) @ self.groups
        grams = X @ X.transpose(0, 2, 1) + l1[:, None, None] * np.eye(w.shape[1])
        target = np.einsum("bnd,bd->bn", X, self.o + l1[:, None] * u)
        new_w = _solved(grams, _ridge(half * l2, sizes), target)
        seen = new_w if update.order == "gauss_seidel" else w
        features = l1[:, None, None] * (X.transpose(0, 2, 1) @ X)
        right = l1[:, None] * np.einsum("bnd,bn->bd", X, seen)
        return new_w, _solved(features, _ridge(half * l3, blocks), right)


def _ridge(weights: Floats, sizes: Floats) -> Floats:
    """Infinite where a size is 0 and the weight is not."""
    with np.errstate(divide="ignore", invalid="ignore"):
        ridge = weights[:, None] / sizes
    return np.where(weights[:, None] == 0, 0.0, ridge)


def _solved(grams: Floats, ridge: Floats, right: Floats) -> Floats:
    """Solve; 0 where the ridge is infinite, NaN where the matrix is (nearly) singular."""
    held = ~np.isfinite(ridge)
    k = right.shape[1]
    A = grams + np.where(held, 0.0, ridge)[:, :, None] * np.eye(k)
    A = np.where(held[:, :, None] | held[:, None, :], np.eye(k), A)
    scale = 1.0 / np.sqrt(np.maximum(np.abs(np.einsum("bii->bi", A)), 1e-300))
    A = np.nan_to_num(A * scale[:, :, None] * scale[:, None, :], nan=0.0, posinf=0.0, neginf=0.0)
    bad = ~(np.linalg.cond(A) < WORST)
    A[bad] = np.eye(k)
    solution = scale * np.linalg.solve(A, scale[:, :, None] * np.where(held, 0.0, right)[:, :, None])[:, :, 0]
    solution[bad] = np.nan
    return np.asarray(solution)


def _cleaned(values: Floats) -> Floats:
    return np.where(np.abs(values) < ZERO, 0.0, values)


def batches(rows: Sequence[tuple[int, ...]]) -> Iterator[Whole]:
    """Rows of `problems` by the `BATCH`."""
    for start in range(0, len(rows), BATCH):
        yield np.array(rows[start : start + BATCH])


def _whole(count: int, total: int, signed: int) -> Iterator[tuple[int, ...]]:
    """Every tuple of integers whose sizes add up to `total`; the first `signed` of either sign."""
    if count == 0:
        if total == 0:
            yield ()
        return
    for size in range(total + 1):
        signs = (1, -1) if signed > 0 and size else (1,)
        for rest in _whole(count - 1, total - size, signed - 1):
            for sign in signs:
                yield sign * size, *rest


def _partitions(d: int) -> Iterator[tuple[int, ...]]:
    if d == 0:
        yield ()
    for first in range(1, d + 1):
        for rest in _partitions(d - first):
            yield first, *rest
