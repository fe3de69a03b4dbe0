"""The reduced problem in ball arithmetic, of any precision and without overflow or underflow.

Every number is an `arb` of python-flint: a midpoint with a radius that encloses the real number meant.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import flint
import numpy as np

from convexperc.exact import integers, row_basis, solve
from convexperc.problem import Problem

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


def exact_matrix(values: np.ndarray, exponent: int) -> Any:
    """Floats times 2^-exponent, exactly."""
    whole, own = integers(values)
    power = flint.arb(2) ** (own - exponent)
    return flint.arb_mat([[flint.arb(int(v)) * power for v in row] for row in whole])


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
    return [row[0] for row in (A * flint.arb_mat([[v] for v in x])).tolist()]


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
        A row basis of X; only where lambda3 = 0 < lambda1.
    """

    K: list[Any]
    G: Any
    c: Numbers
    target: Number
    lambdas: tuple[Number, Number, Number]
    null: Any
    rows: tuple[int, ...]

    @classmethod
    def of(cls, problem: Problem, exponents: tuple[int, int]) -> "BallFrame":
        """Enclose the data of `problem`, scaled by 2^-x and 2^-o, in the precision in force."""
        x, t = exponents
        rows = exact_matrix(problem.X, x)
        o = exact_matrix(problem.o[:, None], t)
        K = []
        for columns in problem.modalities:
            block = exact_matrix(problem.X[:, columns], x)
            K.append(block * block.transpose())
        G = K[0]
        for gram in K[1:]:
            G = G + gram
        two = flint.arb(2)
        powers = (two ** (-2 * x), two ** (-x - t), two ** (-2 * x - t))
        lambdas = [flint.arb(v) * power for v, power in zip(problem.lambdas, powers, strict=True)]
        null, basis = _left_null_space(problem) if problem.lambda3 == 0.0 < problem.lambda1 else (None, ())
        c = [row[0] for row in (rows * o).tolist()]
        return cls(K, G, c, (o.transpose() * o)[0, 0], (lambdas[0], lambdas[1], lambdas[2]), null, basis)

    @property
    def n(self) -> int:
        """Number of views."""
        return len(self.c)


def _left_null_space(problem: Problem) -> tuple[Any, tuple[int, ...]]:
    """A basis of {b : X'b = 0} and a row basis of X.

    For each dependent row: its coefficients over the row basis, verified exactly. None stands for {0}.
    """
    basis = row_basis(problem.X)
    n = problem.n
    free = [i for i in range(n) if i not in basis.rows]
    if not free:
        return None, basis.rows
    A, _ = integers(problem.X)
    rows, columns = list(basis.rows), list(basis.columns)
    result = [[flint.arb(0) for _ in free] for _ in range(n)]
    for k, row in enumerate(free):
        result[row][k] = flint.arb(1)
    if rows:
        Y, det = solve(A[np.ix_(rows, columns)].T.copy(), A[np.ix_(free, columns)].T.copy())
        if (A[rows].T @ Y - det * A[free].T).any():
            raise ArithmeticError("the rank modulo the prime is not the rank over the rationals")
        for i, row in enumerate(rows):
            for k in range(len(free)):
                value = Fraction(-int(Y[i, k]), det)
                result[row][k] = flint.arb(flint.fmpq(value.numerator, value.denominator))
    return flint.arb_mat(result), basis.rows
