"""What a family of problems draws from, and the ordinary problem that it starts with."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, TypeVar

import numpy as np

from convexperc.problem.arrays import Matrix, Vector
from convexperc.problem.problem import Problem

T = TypeVar("T")

WEIGHTS = (1e-3, 0.01, 0.1, 1.0, 10.0)
"""Positive lambdas; the paper's grid and one step below."""


class Source(Protocol):
    """Where a family takes its numbers from."""

    @property
    def largest(self) -> tuple[int, int]:
        """Largest n and largest d."""

    def integer(self, low: int, high: int) -> int:
        """Draw an integer in low .. high, both included."""

    def choice(self, options: Sequence[T]) -> T:
        """Draw one of `options`; the first is the simplest."""

    def matrix(self, rows: int, columns: int) -> Matrix:
        """Draw float64 (rows, columns) of ordinary size."""


@dataclass(frozen=True)
class Seeded:
    """Numbers from a NumPy generator.

    Attributes
    ----------
    rng : numpy.random.Generator
    largest : (int, int)
        Largest n and largest d.
    """

    rng: np.random.Generator
    largest: tuple[int, int] = (8, 60)

    def integer(self, low: int, high: int) -> int:
        """Draw uniformly in low .. high."""
        return int(self.rng.integers(low, high + 1))

    def choice(self, options: Sequence[T]) -> T:
        """Draw uniformly."""
        return options[int(self.rng.integers(len(options)))]

    def matrix(self, rows: int, columns: int) -> Matrix:
        """Draw one of five kinds: normal or uniform in [0, 1), as it is or in unit rows; small integers."""
        kind = int(self.rng.integers(5))
        if kind == 4:
            return self.rng.integers(-3, 4, (rows, columns)).astype(np.float64)
        values = self.rng.standard_normal((rows, columns)) if kind % 2 else self.rng.random((rows, columns))
        return values / np.linalg.norm(values, axis=1, keepdims=True) if kind >= 2 else values


@dataclass
class Draft:
    """A problem in the making; a family changes the part that it is named after."""

    X: Matrix
    o: Vector
    sizes: list[int]
    lambdas: list[float]

    def problem(self) -> Problem:
        """Freeze it."""
        one, two, three = self.lambdas
        return Problem(self.X, self.o, modalities=self.sizes, lambda1=one, lambda2=two, lambda3=three)


def draft(
    source: Source, *, n: int = 0, d: int = 0, least_n: int = 1, sizes: list[int] | None = None
) -> Draft:
    """Draw an ordinary problem with positive lambdas; n, d or the sizes of the modalities may be given."""
    largest_n, largest_d = source.largest
    n = n or source.integer(least_n, largest_n)
    d = sum(sizes) if sizes else d or source.integer(1, largest_d)
    X = np.array(source.matrix(n, d))
    o = source.matrix(1, d)[0]
    if source.integer(0, 2):
        o = X.T @ source.matrix(1, n)[0] + 0.125 * o
    lambdas = [source.choice(WEIGHTS) for _ in range(3)]
    return Draft(X, np.array(o), sizes or _sizes(source, d), lambdas)


def _sizes(source: Source, d: int) -> list[int]:
    sizes: list[int] = []
    for left in range(source.integer(1, min(d, 4)), 1, -1):
        sizes.append(source.integer(1, d - sum(sizes) - left + 1))
    return [*sizes, d - sum(sizes)]
