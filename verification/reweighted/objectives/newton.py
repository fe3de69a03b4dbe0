"""Newton's method in long numbers from a suggested point, with kinks that are met held at 0."""

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from flint import arb, fmpq, fmpq_mat
from numpy.typing import NDArray

from verification.exact.balls import Numbers, exact, inner
from verification.lassos.referee import norm, rational
from verification.reweighted.objectives.conjugates import Block, Growth
from verification.reweighted.objectives.system import Floats, System, binade, floats_of, pivots

STEPS = 30
"""Newton steps: they double the digits, or where the matrix is nearly singular add some."""
FINE = Fraction(1, 1 << 120)
"""A Newton step, beside the point, that ends it."""
INSIDE = 1 - fmpq(1, 1 << 200)
"""Dual vectors are made this much shorter than allowed, so that rounding leaves them inside."""
HELD = 1e-6
"""Norms below this, of residuals of size 1, may be zeros."""
PASSES = 6
"""Of the least squares that bring sum A'v to 0 before the exact step."""


def polished(system: System, z: Numbers, v: Numbers) -> Iterator[tuple[Numbers, Numbers]]:
    """Better points and dual vectors, one for each guess of the residuals that are 0."""
    u, slack = system.residuals(z), system.slack(v)
    lengths = np.array([np.linalg.norm(floats_of(u[rows])) for rows in system.slices])
    kinked = np.array([any(growth.kinked for growth in block.growths) for block in system.blocks])
    guesses: list[NDArray[np.bool_]] = []
    for zeros in (lengths < HELD, lengths < slack, (lengths < slack) & (lengths < HELD)):
        guess = kinked & zeros
        if not any((guess == other).all() for other in guesses):
            guesses.append(guess)
    for guess in guesses:
        yield _Newton(system, guess, lengths).run(z, v)


@dataclass(frozen=True, eq=False)
class _Newton:
    """Newton's method where the residuals of some blocks are held at 0.

    Attributes
    ----------
    system : System
    held : bool (blocks,)
    lengths : float64 (blocks,)
        Of the residuals: the shortest are held first where not all can be.
    """

    system: System
    held: NDArray[np.bool_]
    lengths: Floats

    def run(self, z: Numbers, v: Numbers) -> tuple[Numbers, Numbers]:
        """The point, and a dual vector: the gradient where F is smooth, elsewhere near the one given."""
        start, basis = self._onto(z)
        N = np.array([floats_of(vector) for vector in basis]).T
        shares, z, before = [fmpq(0)] * len(basis), start, np.inf
        for _ in range(STEPS if basis else 0):
            pulled = self.system.pulls(self._slopes(z, [fmpq(0)] * len(v)))
            gradient = [inner(vector, pulled) for vector in basis]
            power = binade(max(map(abs, gradient)))
            curvature = N.T @ self._hessian(z) @ N
            step = np.linalg.lstsq(curvature, -floats_of([g / power for g in gradient]), rcond=1e-13)[0]
            size = float(power) * float(np.max(np.abs(step)))
            if not np.isfinite(size) or size > 4 * before:
                break
            shares = [_kept(y + power * exact(dy)) for y, dy in zip(shares, step, strict=True)]
            z = [
                x + sum((y * a[k] for y, a in zip(shares, basis, strict=True)), fmpq(0))
                for k, x in enumerate(start)
            ]
            if size <= FINE:
                break
            before = size
        return z, self._balanced(self._slopes(z, v))

    def _onto(self, z: Numbers) -> tuple[Numbers, list[Numbers]]:
        """A point near z at which the blocks are 0, and a basis of the moves that keep them there."""
        n = self.system.n
        order = [int(k) for k in np.argsort(self.lengths, kind="stable") if self.held[k]]
        rows = [(row, b) for k in order for row, b in zip(*self._rows(k), strict=True)]
        chosen = [rows[i] for i in pivots([row for row, _ in rows])] if rows else []
        if not chosen:
            return z, [[fmpq(int(i == j)) for j in range(n)] for i in range(n)]
        columns = pivots([[row[j] for row, _ in chosen] for j in range(n)])
        free = [j for j in range(n) if j not in columns]
        square = fmpq_mat([[row[j] for j in columns] for row, _ in chosen])
        found = list(z)
        off = fmpq_mat(len(chosen), 1, [-b - inner(row, z) for row, b in chosen])
        for j, move in zip(columns, square.solve(off).entries(), strict=True):
            found[j] += move
        basis = []
        for f in free:
            vector = [fmpq(int(j == f)) for j in range(n)]
            follow = square.solve(fmpq_mat(len(chosen), 1, [-row[f] for row, _ in chosen])).entries()
            for j, move in zip(columns, follow, strict=True):
                vector[j] = move
            basis.append(vector)
        return found, basis

    def _rows(self, k: int) -> tuple[list[Numbers], Numbers]:
        return self.system.blocks[k].rows, self.system.blocks[k].offset

    def _slopes(self, z: Numbers, v: Numbers) -> Numbers:
        """The gradient of each block; where it is held, or at its kink, v as far as it is allowed."""
        u, found = self.system.residuals(z), list(v)
        for block, rows, held in zip(self.system.blocks, self.system.slices, self.held, strict=True):
            growth = block.growth(u[rows])
            kink = growth.kinked and (held or not any(u[rows]))
            found[rows] = _shortened(block, v[rows]) if kink else _slope(growth, u[rows])
        return found

    def _hessian(self, z: Numbers) -> Floats:
        """Of the smooth blocks, in float64; its errors cost steps, not digits."""
        u = floats_of(self.system.residuals(z))
        total = np.zeros((self.system.n, self.system.n))
        for block, rows, held in zip(self.system.blocks, self.system.slices, self.held, strict=True):
            growth, A, length = (
                block.growth(list(u[rows])),
                self.system.floats[rows],
                float(np.linalg.norm(u[rows])),
            )
            if growth.curve is not None and (growth.bend is None or length <= float(growth.bend)):
                total += 2 * float(growth.curve) * A.T @ A
            elif not held and length and len(A) > 1:
                across = A - np.outer(u[rows], (u[rows] / length) @ A) / length
                total += float(growth.radius) / length * A.T @ across
        return total

    def _balanced(self, v: Numbers) -> Numbers:
        """The held parts of v changed, where they have room, until A'v is nearly 0."""
        weights = self.system.spread(np.where(self.held, np.clip(self.system.slack(v), 1e-9, None), 0.0))
        places = np.flatnonzero(weights)
        if not places.size:
            return v
        A, found = self.system.floats[places] * weights[places, None], list(v)
        for _ in range(PASSES):
            pulled = self.system.pulls(found)
            power = binade(max(map(abs, pulled)))
            move = (
                np.linalg.lstsq(A.T, -floats_of([x / power for x in pulled]), rcond=1e-12)[0]
                * weights[places]
            )
            for i, change in zip(places, move, strict=True):
                found[i] = _kept(found[i] + power * exact(change))
        return found


def _slope(growth: Growth, u: Numbers) -> Numbers:
    """The gradient of a loss at a residual, rounded, and no longer than allowed."""
    if growth.curve is not None and (growth.bend is None or inner(u, u) <= growth.bend**2):
        return [2 * growth.curve * x for x in u]
    if not any(u):
        return [fmpq(0)] * len(u)
    length = norm(u)
    return [_kept(growth.radius * INSIDE * x / length) for x in u]


def _shortened(block: Block, v: Numbers) -> Numbers:
    growth = block.growth(v)
    if growth.radius is None or inner(v, v) <= growth.radius**2:
        return list(v)
    return [_kept(growth.radius * INSIDE * x / norm(v)) for x in v]


def _kept(value: Any) -> Any:
    """The rational of BITS bits nearest to a number or to the middle of a ball."""
    return rational(arb(value))
