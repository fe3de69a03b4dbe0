"""The reduced problem in ball arithmetic, of any precision and without overflow or underflow.

Every number is an `arb` of python-flint: a midpoint with a radius that encloses the real number meant.
"""

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import flint
import numpy as np

from convexperc.certificate.rationals import PRIMES, RowBasis, integers, row_basis, solve
from convexperc.problem.arrays import Matrix
from convexperc.problem.problem import Problem

Number = Any
"""A flint.arb."""
Numbers = list[Any]
"""A list of flint.arb."""


@contextmanager
def precision(bits: int) -> Iterator[None]:
    """Work with `bits` bits inside the block."""
    before = flint.ctx.prec
    flint.ctx.prec = bits
    try:
        yield
    finally:
        flint.ctx.prec = before


def exact_matrix(values: np.ndarray) -> Any:
    """Floats of shape (r, k) as they are."""
    rows, columns = values.shape
    return flint.arb_mat(rows, columns, values.ravel().tolist())


def float_above(value: Number) -> float:
    """The smallest float that is not below the number."""
    near = float(value.upper())
    return near if flint.arb(near) >= value else math.nextafter(near, math.inf)


def float_below(value: Number) -> float:
    """The largest float that is not above the number."""
    near = float(value.lower())
    return near if flint.arb(near) <= value else math.nextafter(near, -math.inf)


def midpoint(values: Numbers) -> Numbers:
    """The midpoints, as exact numbers."""
    return [v.mid() for v in values]


def dot(x: Numbers, y: Numbers) -> Number:
    """The inner product."""
    total = flint.arb(0)
    for a, b in zip(x, y, strict=True):
        total += a * b
    return total


def times(A: Any, x: Numbers) -> Numbers:
    """A x."""
    return column(A * flint.arb_mat(len(x), 1, x))


def column(A: Any) -> Numbers:
    """The entries of a matrix with one column."""
    return list(A.entries())


@dataclass(frozen=True, eq=False)
class ExactData:
    """X_i and o^i of every modality as they are given, for any precision.

    Attributes
    ----------
    blocks : tuple of arb_mat (n, d_i)
    targets : tuple of arb_mat (d_i, 1)
    """

    blocks: tuple[Any, ...]
    targets: tuple[Any, ...]

    @classmethod
    def of(cls, problem: Problem) -> "ExactData":
        """Take over the floats."""
        blocks = tuple(exact_matrix(block) for block in problem.blocks())
        return cls(blocks, tuple(exact_matrix(problem.o[columns, None]) for columns in problem.modalities))

    def columns(self, parts: list[Numbers]) -> list[Numbers]:
        """X_i' y_i of every modality."""
        return [times(block.transpose(), y) for block, y in zip(self.blocks, parts, strict=True)]


@dataclass(frozen=True, eq=False)
class BallFrame:
    """K_i = X_i X_i', G, c = X o and ||o||^2 of the normalised problem, enclosed; and its lambdas.

    Attributes
    ----------
    K : list of arb_mat (n, n)
    G : arb_mat (n, n)
    c : list of n arb
    target : arb
        ||o||^2.
    lambdas : tuple of three arb
    null : arb_mat (n, k) or None
        A basis of {b : X'b = 0}, exact before rounding to balls; only where lambda3 = 0 < lambda1, and None
        where that space is {0}.
    rows : tuple of int
        A row basis of X where lambda3 = 0 < lambda1 or lambda1 = lambda2 = 0; elsewhere all rows.
    """

    K: list[Any]
    G: Any
    c: Numbers
    target: Number
    lambdas: tuple[Number, Number, Number]
    null: Any
    rows: tuple[int, ...]

    @classmethod
    def of(cls, problem: Problem, exponents: tuple[int, int], data: ExactData | None = None) -> "BallFrame":
        """Enclose the data of `problem`, scaled by 2^-x and 2^-o, in the precision in force."""
        data = ExactData.of(problem) if data is None else data
        x, t = exponents
        two = flint.arb(2)
        units = two ** (-2 * x), two ** (-x - t), two ** (-2 * t)
        K = [block * block.transpose() * units[0] for block in data.blocks]
        c = sum((block * o for block, o in zip(data.blocks, data.targets, strict=True)), _zeros(problem.n, 1))
        target = sum((o.transpose() * o for o in data.targets), _zeros(1, 1))[0, 0]
        powers = units[0], units[1], two ** (-2 * x - t)
        lambdas = [flint.arb(v) * power for v, power in zip(problem.lambdas, powers, strict=True)]
        null, rows = None, tuple(range(problem.n))
        if problem.lambda3 == 0.0 < problem.lambda1 or problem.lambda1 == problem.lambda2 == 0.0:
            found, rows = left_null_space(problem.X)
            null = found if problem.lambda1 > 0.0 else None
        G = sum(K, _zeros(problem.n, problem.n))
        coupled = lambdas[0], lambdas[1], lambdas[2]
        return cls(K, G, column(c * units[1]), target * units[2], coupled, null, rows)

    @property
    def n(self) -> int:
        """Number of views."""
        return len(self.c)


def _zeros(rows: int, columns: int) -> Any:
    return flint.arb_mat(rows, columns)


def left_null_space(X: Matrix) -> tuple[Any, tuple[int, ...]]:
    """A basis of {b : X'b = 0}, None where that is {0}, and a row basis of X.

    The basis has one column for each dependent row, from its coefficients over the row basis.

    Raises
    ------
    ArithmeticError
        No prime of `convexperc.certificate.rationals` gave the rank over the rationals.
    """
    for prime in PRIMES:
        basis = row_basis(X, prime)
        free = [i for i in range(X.shape[0]) if i not in basis.rows]
        if not free:
            return None, basis.rows
        null = _dependences(X, basis, free)
        if null is not None:
            return null, basis.rows
    raise ArithmeticError("no prime gave the rank over the rationals")


def _dependences(X: Matrix, basis: RowBasis, free: list[int]) -> Any:
    """The null vectors of the free rows, or None where one does not depend on the basis."""
    A, _ = integers(X)
    rows, columns = list(basis.rows), list(basis.columns)
    Y, det = np.zeros((0, len(free)), dtype=object), 1
    if rows:
        Y, det = solve(A[np.ix_(rows, columns)].T.copy(), A[np.ix_(free, columns)].T.copy())
    if (A[rows].T @ Y - det * A[free].T).any():
        return None
    result = flint.arb_mat(X.shape[0], len(free))
    for k, row in enumerate(free):
        result[row, k] = flint.arb(1)
        for i, own in enumerate(rows):
            value = Fraction(-int(Y[i, k]), det)
            result[own, k] = flint.arb(flint.fmpq(value.numerator, value.denominator))
    return result
