"""The parts of an objective as one matrix: values, residuals, and bounds from dual vectors, exactly."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy.linalg
from flint import fmpq, fmpq_mat
from numpy.typing import NDArray

from verification.exact.balls import Numbers, inner
from verification.lassos.referee import ends, norm
from verification.reweighted.objectives.conjugates import Block

Floats = NDArray[np.float64]
BITS = 256
"""Of every ball, and of the numbers that are kept of them."""


@dataclass(frozen=True, eq=False)
class System:
    """The parts of an objective with all their rows in one matrix.

    Attributes
    ----------
    blocks : list of Block
    """

    blocks: Sequence[Block]

    @property
    def n(self) -> int:
        """Number of variables."""
        return len(self.blocks[0].rows[0])

    @cached_property
    def slices(self) -> list[slice]:
        """The rows of each block."""
        stops = np.cumsum([len(block.rows) for block in self.blocks])
        return [
            slice(int(stop) - len(block.rows), int(stop))
            for stop, block in zip(stops, self.blocks, strict=True)
        ]

    @cached_property
    def matrix(self) -> Any:
        """All rows (m, n)."""
        rows = [row for block in self.blocks for row in block.rows]
        return fmpq_mat(len(rows), self.n, [a for row in rows for a in row])

    @cached_property
    def transpose(self) -> Any:
        """The transpose (n, m)."""
        return self.matrix.transpose()

    @cached_property
    def d(self) -> Numbers:
        """All offsets (m,)."""
        return [b for block in self.blocks for b in block.offset]

    @cached_property
    def floats(self) -> Floats:
        """A in float64."""
        return floats_of(self.matrix.entries()).reshape(len(self.d), self.n)

    def residuals(self, z: Numbers) -> Numbers:
        """A z + d."""
        return [a + b for a, b in zip((self.matrix * fmpq_mat(self.n, 1, z)).entries(), self.d, strict=True)]

    def pulls(self, v: Numbers) -> Numbers:
        """A'v."""
        return list((self.transpose * fmpq_mat(len(v), 1, v)).entries())

    def value(self, z: Numbers) -> Any:
        """F(z), a rational or a ball."""
        u = self.residuals(z)
        return sum(
            (_loss(block, u[rows]) for block, rows in zip(self.blocks, self.slices, strict=True)), fmpq(0)
        )

    def slack(self, v: Numbers) -> Floats:
        """1 - ||v||/radius of each block; 1 where there is no radius."""
        found = []
        for block, rows in zip(self.blocks, self.slices, strict=True):
            radius = block.growth(v[rows]).radius
            length = np.linalg.norm(floats_of(v[rows]))
            found.append(1.0 if radius is None else 1 - length / float(radius) if radius else 0.0)
        return np.array(found)

    def feasible(self, v: Numbers) -> Numbers | None:
        """A vector near v with A'v = 0, exactly; changed in a basis of rows that have the most slack."""
        weights = np.clip(self.spread(self.slack(v)), 1e-9, None)
        order = scipy.linalg.qr((self.floats * weights[:, None]).T, mode="r", pivoting=True)[1]
        table = self.matrix.tolist()
        rows = [int(order[k]) for k in pivots([table[i] for i in order])]
        if not rows:
            return list(v)
        columns = pivots([[table[i][j] for i in rows] for j in range(self.n)])
        square = fmpq_mat([[table[i][j] for i in rows] for j in columns])
        pulled = self.pulls(v)
        move = square.solve(fmpq_mat(len(rows), 1, [-pulled[j] for j in columns])).entries()
        found = list(v)
        for i, change in zip(rows, move, strict=True):
            found[i] += change
        return found if not any(self.pulls(found)) else None

    def spread(self, values: Floats) -> Floats:
        """One value of each block for each of its rows."""
        return np.repeat(values, [len(block.rows) for block in self.blocks])

    def below(self, v: Numbers) -> Any:
        """A lower bound of F from a vector with A'v = 0: max over t of t v'd - t^2 sum ||v||^2/(4a)."""
        longest, quadratic = fmpq(1), fmpq(0)
        for block, rows in zip(self.blocks, self.slices, strict=True):
            growth, square = block.growth(v[rows]), inner(v[rows], v[rows])
            if growth.curve:
                quadratic += square / (4 * growth.curve)
            if growth.radius is not None and square > growth.radius**2:
                longest = min(longest, growth.radius / ends(norm(v[rows]))[1])
        linear = inner(v, self.d)
        if linear <= 0:
            return fmpq(0)
        t = min(longest, linear / (2 * quadratic)) if quadratic != 0 else longest
        return t * linear - t * t * quadratic


def _loss(block: Block, u: Numbers) -> Any:
    square, growth = inner(u, u), block.growth(u)
    if growth.curve is None:
        return growth.radius * norm(u)
    if growth.bend is None or square <= growth.bend**2:
        return growth.curve * square
    return growth.radius * norm(u) - growth.curve * growth.bend**2


def floats_of(values: Any) -> Floats:
    """Rationals in float64, however long they are."""
    return np.array([int(x.p) / int(x.q) for x in values], dtype=np.float64)


def pivots(rows: list[Numbers]) -> list[int]:
    """The first rows that span all of them."""
    echelon, rank = fmpq_mat(rows).transpose().rref()
    return [next(j for j in range(len(rows)) if echelon[i, j] != 0) for i in range(rank)]


def binade(value: Any) -> Any:
    """A power of two near a rational >= 0, which may be too small for float64; 1 for 0."""
    if not value:
        return fmpq(1)
    return fmpq(2) ** (int(value.p).bit_length() - int(value.q).bit_length())
