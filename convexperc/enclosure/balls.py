"""The reduced problem in ball arithmetic, of any precision and without overflow or underflow.

Every number is an `arb` of python-flint: a midpoint with a radius that encloses the real number meant.
"""

import math
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import flint
import numpy as np

from convexperc.certificate.rationals import RowSpace
from convexperc.problem.arrays import Matrix
from convexperc.problem.problem import Problem

Number = Any
"""A flint.arb."""
Numbers = list[Any]
"""A list of flint.arb."""


_ALONE = threading.RLock()
"""Held by the thread that works in balls: FLINT has one precision for the whole process."""


@contextmanager
def precision(bits: int) -> Iterator[None]:
    """Work with `bits` bits inside the block, which other threads wait for; then as before."""
    with _ALONE:
        before = flint.ctx.prec
        try:
            flint.ctx.prec = bits
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
    X : float64 (n, d)
    blocks : tuple of arb_mat (n, d_i)
    targets : tuple of arb_mat (d_i, 1)
    """

    X: Matrix
    blocks: tuple[Any, ...]
    targets: tuple[Any, ...]

    @classmethod
    def of(cls, problem: Problem) -> "ExactData":
        """Take over the floats."""
        blocks = tuple(exact_matrix(block) for block in problem.blocks())
        targets = tuple(exact_matrix(problem.o[columns, None]) for columns in problem.modalities)
        return cls(problem.X, blocks, targets)

    @cached_property
    def space(self) -> RowSpace:
        """The span of the rows of X."""
        return RowSpace.of(self.X)

    def columns(self, parts: list[Numbers]) -> list[Numbers]:
        """X_i' y_i of every modality."""
        return [times(block.transpose(), y) for block, y in zip(self.blocks, parts, strict=True)]


@dataclass(frozen=True, eq=False)
class ReducedBalls:
    """K_i = X_i X_i', G, c = X o and ||o||^2 of the normalised problem, enclosed; and its lambdas.

    Attributes
    ----------
    K : list of arb_mat (n, n)
    G : arb_mat (n, n)
    c : list of n arb
    target : arb
        ||o||^2.
    lambdas : tuple of three arb
    null : arb_mat (n, n) or None
        The orthogonal projection onto {b : X'b = 0}; only where lambda3 = 0 < lambda1, and None where that
        space is {0}.
    space : RowSpace or None
        Where lambda3 = 0 < lambda1 or lambda1 = lambda2 = 0.
    """

    K: list[Any]
    G: Any
    c: Numbers
    target: Number
    lambdas: tuple[Number, Number, Number]
    null: Any
    space: RowSpace | None

    @classmethod
    def of(
        cls, problem: Problem, exponents: tuple[int, int], data: ExactData | None = None
    ) -> "ReducedBalls":
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
        null, space = None, None
        if problem.lambda3 == 0.0 < problem.lambda1 or problem.lambda1 == problem.lambda2 == 0.0:
            space = data.space
            null = null_projection(space) if problem.lambda1 > 0.0 else None
        G = sum(K, _zeros(problem.n, problem.n))
        coupled = lambdas[0], lambdas[1], lambdas[2]
        return cls(K, G, column(c * units[1]), target * units[2], coupled, null, space)

    @property
    def n(self) -> int:
        """Number of views."""
        return len(self.c)


def _zeros(rows: int, columns: int) -> Any:
    return flint.arb_mat(rows, columns)


def null_projection(space: RowSpace) -> Any:
    """The orthogonal projection I - M (M'M)^-1 M' onto {b : X'b = 0}, arb_mat (n, n); None where that is {0}.

    Every entry is known to the bits of the precision in force, however long the numbers of M'M must be for
    that: M has full column rank, so that enough bits make M'M invertible.
    """
    n, bits = space.A.nrows(), flint.ctx.prec
    if space.rank == n:
        return None
    more, error = bits, flint.arb(2) ** -bits
    while True:
        more *= 2
        with precision(more), suppress(ZeroDivisionError):
            M = flint.arb_mat(space.image)
            found = flint.arb_mat(n, n, 1) - M * (M.transpose() * M).inv() * M.transpose()
            if all(value.rad() <= error for value in found.entries()):
                return found
