"""Numbers that count the multiplications they take part in, and elimination on them."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

Row = list["Counted"]


@dataclass
class Counter:
    """Multiplications and divisions so far."""

    operations: int = 0


@dataclass(frozen=True)
class Counted:
    """A number that counts the multiplications and divisions that it takes part in; none is free."""

    value: Any
    counter: Counter = field(repr=False)

    def __add__(self, other: "Counted") -> "Counted":
        return Counted(self.value + other.value, self.counter)

    def __sub__(self, other: "Counted") -> "Counted":
        return Counted(self.value - other.value, self.counter)

    def __mul__(self, other: "Counted") -> "Counted":
        self.counter.operations += 1
        return Counted(self.value * other.value, self.counter)

    def __truediv__(self, other: "Counted") -> "Counted":
        self.counter.operations += 1
        return Counted(self.value / other.value, self.counter)


def counted(values: NDArray[np.float64], counter: Counter) -> list[Row]:
    """Each entry of a matrix as a counting number."""
    return [[Counted(float(x), counter) for x in row] for row in values]


def eliminated(A: list[Row], b: Row) -> Row:
    """Solve A x = b by elimination without pivoting: A is positive definite. Overwrites both."""
    n = len(A)
    for k in range(n):
        for i in range(k + 1, n):
            factor = A[i][k] / A[k][k]
            for j in range(k + 1, n):
                A[i][j] = A[i][j] - factor * A[k][j]
            b[i] = b[i] - factor * b[k]
    for i in reversed(range(n)):
        for j in range(i + 1, n):
            b[i] = b[i] - A[i][j] * b[j]
        b[i] = b[i] / A[i][i]
    return b


def inner(x: Sequence[Counted], y: Iterable[Counted]) -> Counted:
    """The inner product."""
    products = [a * b for a, b in zip(x, y, strict=True)]
    total = products[0]
    for product in products[1:]:
        total = total + product
    return total


def eliminate(n: int) -> int:
    """Return the multiplications and divisions that solving one dense n x n system takes, by running it.

    The system is positive definite, as those of steps 6 and 7, and rational: the solution is checked exactly.

    Formula: n^3/3 + n^2 - n/3 for elimination without a zero pivot and back substitution.

    Raises
    ------
    ArithmeticError
        The elimination is wrong.
    """
    counter = Counter()
    A = [[Fraction(min(i, j) + 1 + (n if i == j else 0)) for j in range(n)] for i in range(n)]
    right = [Counted(Fraction(i + 1), counter) for i in range(n)]
    x = eliminated([[Counted(entry, counter) for entry in row] for row in A], right)
    count = counter.operations
    for i, row in enumerate(A):
        left = sum((entry * each.value for entry, each in zip(row, x, strict=True)), Fraction(0))
        if left != i + 1:
            raise ArithmeticError(f"row {i} of {n}: {left} is not {i + 1}; the elimination is wrong")
    return count
