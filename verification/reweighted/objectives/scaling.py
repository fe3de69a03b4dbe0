"""An objective moved to a least squares fit and divided by powers of two, so that its numbers are near 1."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from flint import fmpq

from verification.exact.balls import Numbers, exact
from verification.reweighted.objectives.conjugates import Block
from verification.reweighted.objectives.system import Floats, System, binade, floats_of

BALANCING = 4
"""Passes over rows and columns that bring their largest entries near 1."""


@dataclass(frozen=True, eq=False)
class Scaled:
    """F(z) = factor F'(z'), z = center + units z', with data near 1.

    Attributes
    ----------
    system : System
        Of F'.
    center, units : list of fmpq (n,)
    factor : fmpq
    """

    system: System
    center: Numbers
    units: Numbers
    factor: Any

    @classmethod
    def of(cls, given: System) -> "Scaled":
        """Move and divide a system."""
        rows, columns = _balance(given)
        sized = [_resized(block, r, columns) for block, r in zip(given.blocks, rows, strict=True)]
        system = System(sized)
        size = binade(max(map(abs, system.d)))
        fit = np.linalg.lstsq(system.floats, -floats_of([b / size for b in system.d]), rcond=1e-12)[0]
        center = [exact(x) * size for x in fit]
        u = system.residuals(center)
        unit = binade(max(map(abs, u))) if any(u) else size
        slopes = [
            x
            for block in sized
            for growth in block.growths
            for x in (growth.times(unit, unit**2).radius, growth.times(unit, unit**2).curve)
            if x
        ]
        factor = binade(max(slopes, default=fmpq(0)))
        parts = [
            Block(
                block.rows,
                [x / unit for x in u[where]],
                tuple(growth.times(unit / factor, unit**2 / factor) for growth in block.growths),
            )
            for block, where in zip(sized, system.slices, strict=True)
        ]
        moved = [x * c for x, c in zip(center, columns, strict=True)]
        return cls(System(parts), moved, [unit * c for c in columns], factor)

    def point(self, z: Numbers) -> Numbers:
        """Z in the units of the data."""
        return [c + k * x for c, k, x in zip(self.center, self.units, z, strict=True)]


def _balance(system: System) -> tuple[Numbers, Numbers]:
    """A unit for each block's residuals and one for each variable: with them, entries of A are near 1."""
    sizes = np.abs(system.floats)
    largest = np.array([sizes[where].max(axis=0) for where in system.slices])
    rows, columns = np.ones(len(largest)), np.ones(system.n)
    for _ in range(BALANCING):
        rows = rows * _powers((largest / np.outer(rows, columns)).max(axis=1))
        columns = columns * _powers((largest / np.outer(rows, columns)).max(axis=0))
    return [exact(r) for r in rows], [1 / exact(c) for c in columns]


def _powers(values: Floats) -> Floats:
    """The nearest powers of two; 1 for 0."""
    found: Floats = np.exp2(np.round(np.log2(np.where(values > 0, values, 1.0))))
    return found


def _resized(block: Block, unit: Any, columns: Numbers) -> Block:
    """With residuals in another unit, and variables in other units."""
    rows = [[a * c / unit for a, c in zip(row, columns, strict=True)] for row in block.rows]
    growths = tuple(growth.times(unit, unit**2) for growth in block.growths)
    return Block(rows, [b / unit for b in block.offset], growths)
