"""The optimum of a convex objective of squares, norms and losses, between two rational numbers.

Clarabel suggests a point and a dual vector on data that are moved to a least squares fit and divided by
powers of two. Newton's method in long numbers improves the point where no kink is met, and holds it where
one is. From there on everything is exact, or a ball: F at the point from above; from below the dual vector,
moved over the rationals until sum A'v = 0, and shortened until each part allows it (`conjugates`). Both
bounds hold whatever the suggestion was.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from typing import Any

import clarabel
import numpy as np
import scipy.linalg
from flint import arb, fmpq, fmpq_mat
from numpy.typing import NDArray
from scipy import sparse

from verification.exact.balls import Numbers, enclosed, exact, inner, precision
from verification.lassos.referee import ends, norm, rational
from verification.reweighted.objectives.conjugates import Block, Growth, blocks
from verification.reweighted.objectives.objective import Objective

Floats = NDArray[np.float64]

BITS = 256
"""Of every ball, and of the numbers that are kept of them."""
STEPS = 30
"""Newton steps: they double the digits, or where the matrix is nearly singular add some."""
FINE = Fraction(1, 1 << 120)
"""A Newton step, beside the point, that ends it."""
INSIDE = 1 - fmpq(1, 1 << 200)
"""Dual vectors are made this much shorter than allowed, so that rounding leaves them inside."""
HELD = 1e-6
"""Norms below this, of residuals of size 1, may be zeros."""
ENOUGH = Fraction(1, 1 << 100)
"""Relative width of the optimum with which the search for better bounds ends."""
PASSES = 6
"""Of the least squares that bring sum A'v to 0 before the exact step."""
BALANCING = 4
"""Passes over rows and columns that bring their largest entries near 1."""
TOLERANCE = 1e-13
"""Asked of Clarabel; it need not reach it."""


@dataclass(frozen=True)
class Optimum:
    """lower <= F* <= upper = F(point).

    Attributes
    ----------
    lower : Fraction or None
        None: no lower bound was found.
    upper : Fraction
        At least F(point), to 2**-200 or so.
    point : mapping of str to tuples of Fraction
        Entries of each variable.
    reason : str
        Why there is no lower bound.
    """

    lower: Fraction | None
    upper: Fraction
    point: Mapping[str, tuple[Fraction, ...]]
    reason: str = ""

    @property
    def gap(self) -> float:
        """(upper - lower)/upper; 0 where both are 0, infinite without a lower bound."""
        if self.lower is None:
            return float("inf")
        return float((self.upper - self.lower) / self.upper) if self.upper else 0.0


def optimum(objective: Objective) -> Optimum:
    """Enclose F*.

    Parameters
    ----------
    objective : Objective
        Convex: of squares and of the losses that `conjugates` reads.

    Raises
    ------
    NotCoveredError
        It has another loss.
    """
    parts = blocks(objective)
    with precision(BITS):
        if not objective.sizes or not parts:
            value = enclosed(objective.at({name: [fmpq(0)] * k for name, k in objective.sizes.items()}))
            zeros = {name: (Fraction(0),) * size for name, size in objective.sizes.items()}
            return Optimum(value.lower, value.upper, zeros)
        scaled = _Scaled.of(System(parts))
        primal, dual = _suggested(scaled.system)
        bounds = _Bounds(scaled.system)
        bounds.try_(primal, dual)
        bounds.try_([fmpq(0)] * scaled.system.n, None)
        for better, vector in () if dual is None else _polished(scaled.system, primal, dual):
            bounds.try_(better, vector)
            if bounds.tight:
                break
        point = _named(objective, scaled.point(bounds.point))
        upper = enclosed(objective.at({name: list(map(exact, part)) for name, part in point.items()})).upper
        lower = None if bounds.lower is None else scaled.factor * bounds.lower
    if lower is None:
        return Optimum(None, upper, point, "Clarabel returned no dual vector of finite numbers.")
    return Optimum(Fraction(int(lower.p), int(lower.q)), upper, point)


@dataclass
class _Bounds:
    """The best point and the best lower bound so far."""

    system: "System"
    point: Numbers = field(default_factory=list)
    upper: Any = None
    lower: Any = None

    def try_(self, point: Numbers, vector: Numbers | None) -> None:
        """Take what is better."""
        upper = ends(arb(self.system.value(point)))[1]
        if self.upper is None or upper < self.upper:
            self.point, self.upper = point, upper
        vector = None if vector is None else self.system.feasible(vector)
        if vector is not None:
            lower = self.system.below(vector)
            self.lower = lower if self.lower is None else max(self.lower, lower)

    @property
    def tight(self) -> bool:
        """Whether no better bounds are needed."""
        return self.lower is not None and bool(self.upper - self.lower <= exact(ENOUGH) * self.upper)


def _named(objective: Objective, z: Numbers) -> dict[str, tuple[Fraction, ...]]:
    found, at = {}, 0
    for name, size in objective.sizes.items():
        found[name] = tuple(Fraction(int(x.p), int(x.q)) for x in z[at : at + size])
        at += size
    return found


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
        return _floats(self.matrix.entries()).reshape(len(self.d), self.n)

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
            length = np.linalg.norm(_floats(v[rows]))
            found.append(1.0 if radius is None else 1 - length / float(radius) if radius else 0.0)
        return np.array(found)

    def feasible(self, v: Numbers) -> Numbers | None:
        """A vector near v with A'v = 0, exactly; changed in a basis of rows that have the most slack."""
        weights = np.clip(self.spread(self.slack(v)), 1e-9, None)
        order = scipy.linalg.qr((self.floats * weights[:, None]).T, mode="r", pivoting=True)[1]
        table = self.matrix.tolist()
        rows = [int(order[k]) for k in _pivots([table[i] for i in order])]
        if not rows:
            return list(v)
        columns = _pivots([[table[i][j] for i in rows] for j in range(self.n)])
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


def _floats(values: Any) -> Floats:
    """Rationals in float64, however long they are."""
    return np.array([int(x.p) / int(x.q) for x in values], dtype=np.float64)


def _pivots(rows: list[Numbers]) -> list[int]:
    """The first rows that span all of them."""
    echelon, rank = fmpq_mat(rows).transpose().rref()
    return [next(j for j in range(len(rows)) if echelon[i, j] != 0) for i in range(rank)]


@dataclass(frozen=True, eq=False)
class _Scaled:
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
    def of(cls, given: System) -> "_Scaled":
        rows, columns = _balance(given)
        sized = [_resized(block, r, columns) for block, r in zip(given.blocks, rows, strict=True)]
        system = System(sized)
        size = _binade(max(map(abs, system.d)))
        fit = np.linalg.lstsq(system.floats, -_floats([b / size for b in system.d]), rcond=1e-12)[0]
        center = [exact(x) * size for x in fit]
        u = system.residuals(center)
        unit = _binade(max(map(abs, u))) if any(u) else size
        slopes = [
            x
            for block in sized
            for growth in block.growths
            for x in (growth.times(unit, unit**2).radius, growth.times(unit, unit**2).curve)
            if x
        ]
        factor = _binade(max(slopes, default=fmpq(0)))
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


def _suggested(system: System) -> tuple[Numbers, Numbers | None]:
    """A point, and a dual vector or None, from Clarabel, whatever it says of them."""
    n, m = system.n, len(system.d)
    columns: list[Floats] = []
    squares: list[float] = [0.0] * n
    costs: list[float] = [0.0] * n
    bounds: list[tuple[list[int], Any]] = []

    def add(rows: Sequence[int], sign: float, square: float, cost: float) -> list[int]:
        first = n + len(columns)
        for i in rows:
            column = np.zeros(m)
            column[i] = -sign
            columns.append(column)
            squares.append(square)
            costs.append(cost)
        return list(range(first, n + len(columns)))

    for block, where in zip(system.blocks, system.slices, strict=True):
        rows = range(where.start, where.stop)
        if len(rows) == 1:
            for sign, growth in zip((1.0, -1.0), (block.growths[0], block.growths[-1]), strict=True):
                for square, cost in _kinds(growth):
                    bounds.append((add(rows, sign, square, cost), clarabel.NonnegativeConeT(1)))
            continue
        for square, cost in _kinds(block.growths[0]):
            inside = add(rows, 1.0, square, 0.0)
            if not square:
                length = add([0], 0.0, 0.0, cost)
                bounds.append((length + inside, clarabel.SecondOrderConeT(1 + len(rows))))
    size = n + len(columns)
    top = np.hstack([system.floats, np.array(columns).T]) if columns else system.floats
    entries = [k for places, _ in bounds for k in places]
    below = sparse.csc_matrix(
        (-np.ones(len(entries)), (range(len(entries)), entries)), shape=(len(entries), size)
    )
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = TOLERANCE
    solver = clarabel.DefaultSolver(
        sparse.diags(2 * np.array(squares)).tocsc(),
        np.array(costs),
        sparse.vstack([sparse.csc_matrix(top), below]).tocsc(),
        np.concatenate([-_floats(system.d), np.zeros(len(entries))]),
        [clarabel.ZeroConeT(m), *(cone for _, cone in bounds)],
        settings,
    )
    found = solver.solve()
    z, v = np.array(found.x)[:n], np.array(found.z)[:m]
    primal = [exact(x) for x in z] if np.isfinite(z).all() else [fmpq(0)] * n
    return primal, [exact(x) for x in v] if np.isfinite(v).all() else None


def _kinds(growth: Growth) -> list[tuple[float, float]]:
    """What a residual is divided into: a share with a square, and one with a slope."""
    squares = [] if growth.curve is None else [(float(growth.curve), 0.0)]
    return squares + ([] if growth.radius is None else [(0.0, float(growth.radius))])


def _polished(system: System, z: Numbers, v: Numbers) -> Iterator[tuple[Numbers, Numbers]]:
    """Better points and dual vectors, one for each guess of the residuals that are 0."""
    u, slack = system.residuals(z), system.slack(v)
    lengths = np.array([np.linalg.norm(_floats(u[rows])) for rows in system.slices])
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
        N = np.array([_floats(vector) for vector in basis]).T
        shares, z, before = [fmpq(0)] * len(basis), start, np.inf
        for _ in range(STEPS if basis else 0):
            pulled = self.system.pulls(self._slopes(z, [fmpq(0)] * len(v)))
            gradient = [inner(vector, pulled) for vector in basis]
            power = _binade(max(map(abs, gradient)))
            curvature = N.T @ self._hessian(z) @ N
            step = np.linalg.lstsq(curvature, -_floats([g / power for g in gradient]), rcond=1e-13)[0]
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
        chosen = [rows[i] for i in _pivots([row for row, _ in rows])] if rows else []
        if not chosen:
            return z, [[fmpq(int(i == j)) for j in range(n)] for i in range(n)]
        columns = _pivots([[row[j] for row, _ in chosen] for j in range(n)])
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
        u = _floats(self.system.residuals(z))
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
            power = _binade(max(map(abs, pulled)))
            move = (
                np.linalg.lstsq(A.T, -_floats([x / power for x in pulled]), rcond=1e-12)[0] * weights[places]
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


def _binade(value: Any) -> Any:
    """A power of two near a rational >= 0, which may be too small for float64; 1 for 0."""
    if not value:
        return fmpq(1)
    return fmpq(2) ** (int(value.p).bit_length() - int(value.q).bit_length())
