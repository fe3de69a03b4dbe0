"""Multiplications and divisions of Gaussian elimination, counted by running it on numbers that count."""

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass
class Tally:
    """What was done so far."""

    multiplications: int = 0


@dataclass(frozen=True)
class Counting:
    """A number modulo a prime that counts its own multiplications and divisions, of which none is free.

    Arithmetic modulo a prime is exact and never grows, so that every operation costs the same.
    """

    value: int
    tally: Tally

    PRIME = 2**61 - 1

    def __add__(self, other: "Counting") -> "Counting":
        return Counting((self.value + other.value) % self.PRIME, self.tally)

    def __sub__(self, other: "Counting") -> "Counting":
        return Counting((self.value - other.value) % self.PRIME, self.tally)

    def __mul__(self, other: "Counting") -> "Counting":
        self.tally.multiplications += 1
        return Counting(self.value * other.value % self.PRIME, self.tally)

    def __truediv__(self, other: "Counting") -> "Counting":
        self.tally.multiplications += 1
        return Counting(self.value * pow(other.value, -1, self.PRIME) % self.PRIME, self.tally)


def eliminate(n: int) -> int:
    """Return the multiplications and divisions that solving one dense n x n system takes, by running it.

    Formula: n^3/3 + n^2 - n/3 for elimination without a zero pivot and back substitution.
    """
    tally = Tally()
    matrix = [[Counting(_entry(i, j, n), tally) for j in range(n)] for i in range(n)]
    solution = solve(matrix, [Counting(i + 1, tally) for i in range(n)])
    count = tally.multiplications
    for row, right in zip(range(n), range(1, n + 1), strict=True):
        left = sum(_entry(row, j, n) * solution[j].value for j in range(n)) % Counting.PRIME
        if left != right:
            raise ArithmeticError(f"row {row} of {n}: {left} is not {right}; the elimination is wrong")
    return count


def solve(matrix: Sequence[Sequence[Counting]], right: Sequence[Counting]) -> list[Counting]:
    """Gaussian elimination without exchanges, then back substitution, as for a symmetric positive matrix."""
    n = len(right)
    rows = [list(row) for row in matrix]
    values = list(right)
    for k in range(n):
        for i in range(k + 1, n):
            share = rows[i][k] / rows[k][k]
            for j in range(k + 1, n):
                rows[i][j] = rows[i][j] - share * rows[k][j]
            values[i] = values[i] - share * values[k]
    for k in reversed(range(n)):
        for j in range(k + 1, n):
            values[k] = values[k] - rows[k][j] * values[j]
        values[k] = values[k] / rows[k][k]
    return values


def _entry(i: int, j: int, n: int) -> int:
    """A dense symmetric positive definite matrix of whole numbers, as step 6 and step 7 have them."""
    return min(i, j) + 1 + (n if i == j else 0)
