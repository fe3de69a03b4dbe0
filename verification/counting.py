"""Numbers that count the multiplications they take part in, and elimination on them."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Row = list["Counted"]


@dataclass
class Counter:
    """Multiplications and divisions so far."""

    operations: int = 0


@dataclass(frozen=True)
class Counted:
    """A float that counts the multiplications and divisions that it takes part in."""

    value: float
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
