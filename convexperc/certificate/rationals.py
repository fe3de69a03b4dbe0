"""Exact rational arithmetic for the equality cases, where rounding would change the answer.

Rank cannot be proved in floating point. Here floats are taken as the rationals that they are; a basis is
found modulo a large prime, where an independent set is independent over Q too, and every dependence that is
used is then verified exactly.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from convexperc.certificate.rounding import Ball
from convexperc.problem.arrays import FeatureVector, Matrix, Vector
from convexperc.problem.problem import Problem

PRIMES = (2**31 - 1, 2**31 - 19, 2**31 - 61)
"""Tried in turn: where a dependence found modulo one is not one over the rationals, the next is used."""
WORK_LIMIT = 2_000_000
"""Products of long integers that one exact step may cost (about a second); beyond it nothing is proved."""
RANK_LIMIT = 200_000_000
"""n^2 d up to which the rank modulo the prime is computed (about a second)."""

Integers = NDArray[np.object_]


@dataclass(frozen=True)
class RowBasis:
    """Rows and columns of X whose r x r block is invertible, r = rank modulo a prime <= rank over Q."""

    rows: tuple[int, ...]
    columns: tuple[int, ...]

    @property
    def rank(self) -> int:
        """Number of rows."""
        return len(self.rows)


def integers(values: NDArray[np.float64]) -> tuple[Integers, int]:
    """Write floats as integers times one power of two: values = result * 2^exponent, exactly."""
    mantissas, exponents = np.frexp(values)
    scaled = np.ldexp(mantissas, 53).astype(np.int64)
    exponents = np.where(scaled == 0, 0, exponents.astype(np.int64) - 53)
    lowest = int(exponents[scaled != 0].min(initial=np.iinfo(np.int64).max)) if scaled.any() else 0
    shifts = np.where(scaled == 0, 0, exponents - lowest)
    whole = scaled.astype(object) * np.left_shift(np.ones_like(shifts, dtype=object), shifts.astype(object))
    return whole, lowest


def row_basis(X: Matrix, prime: int = PRIMES[0]) -> RowBasis:
    """Find a maximal independent set of rows modulo a prime, with its pivot columns.

    Rows found independent are independent over the rationals (a minor that is not 0 modulo p is not 0).
    """
    whole, _ = integers(X)
    work = np.array(whole % prime, dtype=np.int64)
    free = list(range(X.shape[0]))
    rows: list[int] = []
    columns: list[int] = []
    for column in range(X.shape[1]):
        pivot = next((i for i in free if work[i, column]), None)
        if pivot is None:
            continue
        free.remove(pivot)
        rows.append(pivot)
        columns.append(column)
        if not free:
            break
        inverse = pow(int(work[pivot, column]), -1, prime)
        for i in free:
            if work[i, column]:
                factor = int(work[i, column]) * inverse % prime
                work[i] = (work[i] - factor * work[pivot] % prime) % prime
    order = np.argsort(rows)
    return RowBasis(tuple(rows[i] for i in order), tuple(columns[i] for i in order))


def solve(A: Integers, B: Integers) -> tuple[Integers, int]:
    """Solve for integers exactly, by Bareiss elimination: returns (Y, det) with A (Y / det) = B."""
    size = A.shape[0]
    work = np.concatenate([A, B], axis=1)
    previous = 1
    for k in range(size):
        pivot = next(i for i in range(k, size) if work[i, k])
        if pivot != k:
            work[[k, pivot]] = work[[pivot, k]]
        top = work[k].copy()
        others = np.arange(size) != k
        work[others] = (work[others] * top[k] - np.outer(work[others, k], top)) // previous
        previous = int(top[k])
    return work[:, size:], previous


def squared_distance(X: Matrix, o: FeatureVector) -> Fraction | None:
    """min_w ||X'w - o||^2 as an exact rational, or None beyond `WORK_LIMIT`.

    Formula: o'o - c_B' (X_B X_B')^-1 c_B with c = X o and B a row basis; that the other rows depend on B
    is verified by X_j r = 0 for the exact residual r.
    """
    return next((found for basis in _bases(X) if (found := _distance(X, o, basis)) is not None), None)


def exact_optimum(problem: Problem) -> Fraction | None:
    """F* as an exact rational where lambda2 = 0 and lambda1 or lambda3 is 0: then it is a squared distance.

    None in every other case, and beyond `WORK_LIMIT`.
    """
    lambda1, lambda2, lambda3 = problem.lambdas
    if lambda2 > 0.0 or (lambda1 > 0.0 and lambda3 > 0.0):
        return None
    return squared_distance(problem.X, problem.o)


def into_left_null_space(X: Matrix, b: Vector) -> Ball | None:
    """Move b into {b : X'b = 0} exactly, and enclose the result; None beyond `WORK_LIMIT`.

    The free entries of b are kept as they are; the pivot entries follow from X_P' b_P = -X_F' b_F, solved
    over the rationals and verified on every column.
    """
    return next((found for basis in _bases(X) if (found := _null_vector(X, b, basis)) is not None), None)


def _bases(X: Matrix) -> Iterator[RowBasis]:
    """A row basis modulo each prime, as long as the work is bounded."""
    n, d = X.shape
    if n * n * d > RANK_LIMIT:
        return
    for prime in PRIMES:
        basis = row_basis(X, prime)
        if basis.rank == n or n * d * max(1, basis.rank) <= WORK_LIMIT:
            yield basis


def _distance(X: Matrix, o: FeatureVector, basis: RowBasis) -> Fraction | None:
    """`squared_distance` for one basis; None where it turns out to be none, or beyond `WORK_LIMIT`."""
    if X.size * max(1, basis.rank) > WORK_LIMIT:
        return None
    (A, _), (t, exponent) = integers(X), integers(o)
    total, unit = int(t @ t), Fraction(2) ** (2 * exponent)
    B = A[list(basis.rows)]
    c = B @ t
    y, det = solve(B @ B.T, c[:, None]) if basis.rank else (c[:, None], 1)
    residual = t * det - B.T @ y[:, 0]
    if any(A @ residual):
        return None
    return Fraction(int(total * det - c @ y[:, 0]), det) * unit


def _null_vector(X: Matrix, b: Vector, basis: RowBasis) -> Ball | None:
    """`into_left_null_space` for one basis; None where it is none, or a result leaves float64."""
    n = X.shape[0]
    if basis.rank == n:
        return Ball.exact(np.zeros(n))
    A, _ = integers(X)
    whole, exponent = integers(b)
    P, F, C = list(basis.rows), [i for i in range(n) if i not in basis.rows], list(basis.columns)
    right = -(A[F].T @ whole[F])
    y, det = solve(A[np.ix_(P, C)].T.copy(), right[C][:, None]) if P else (right[:0, None], 1)
    if any(A[P].T @ y[:, 0] - det * right):
        return None
    unit = Fraction(2) ** exponent
    result = [int(value) * unit for value in whole]
    for row, value in zip(P, y[:, 0], strict=True):
        result[row] = Fraction(int(value), det) * unit
    try:
        mid = np.array([float(value) for value in result])
    except OverflowError:
        return None
    errors = [
        0.0 if Fraction(m) == value else np.spacing(abs(m)) for m, value in zip(mid, result, strict=True)
    ]
    return Ball(mid, np.array(errors))
