"""Reweighted loops: an objective, the order in which its blocks are updated, and the exact update.

The update of a block minimises the objective with each loss replaced by weight(r_i) square(r), r_i being
the residual at the iterate; a block of Gauss-Seidel sees the new values of those before it, one of Jacobi
does not.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np
import sympy as sp
from flint import arb, arb_mat, fmpq, fmpq_mat
from numpy.typing import NDArray

from convexperc.errors import InputError, SolverError
from verification.exact.balls import Numbers, UnresolvedError, exact, inner, precision, root
from verification.reweighted.dimensions import degree
from verification.reweighted.expressions import VARIABLE, exactly
from verification.reweighted.objective import (
    Objective,
    Part,
    fractions,
    function_at,
    grows_without_bound,
    weight_in_floats,
)

Floats = NDArray[np.float64]
ORDERS = ("gauss_seidel", "jacobi")
AT_ZERO = ("hold", "undefined", "leave")

Point = Mapping[str, Numbers]
Step = Callable[[Point], Point]


class UndefinedUpdateError(SolverError):
    """The update divides by a residual of 0, or its matrix is singular."""


@dataclass(frozen=True, eq=False)
class Loop:
    """A reweighted loop.

    Parameters
    ----------
    objective : Objective
    blocks : sequence of sequences of str
        Names of variables that are updated together, in order; default: all at once.
    order : {"gauss_seidel", "jacobi"}
    at_zero : {"hold", "undefined", "leave"}
        At a residual of 0 where the weight grows without bound: it is held at 0, which is the limit of the
        update; the update does not exist; or, by Vardi and Zhang's rule, it is left if that lowers F (where
        the residual is the whole block less a point).
    start : mapping of str to sequence of numbers, or None
        None: any start.
    stop : function of two float64 points, or None
        Says of an iterate and the next one, each a mapping of names to arrays, whether the loop ends there.
    update : function of a point, or None
        Another update than the one above, on mappings of names to lists of exact numbers.

    Raises
    ------
    InputError
        Blocks are not a partition of the variables, or see above.
    """

    objective: Objective
    blocks: Sequence[Sequence[str]] = ()
    order: str = "gauss_seidel"
    at_zero: str = "hold"
    start: Mapping[str, Any] | None = None
    stop: Callable[[Any, Any], bool] | None = None
    update: Step | None = None

    def __post_init__(self) -> None:
        for name, value, known in (("order", self.order, ORDERS), ("at_zero", self.at_zero, AT_ZERO)):
            if value not in known:
                raise InputError(name, value=value, must=f"must be one of {', '.join(known)}")
        named = [name for block in self.blocks for name in block]
        if self.blocks and sorted(named) != sorted(self.objective.sizes):
            must = f"must name each of {', '.join(self.objective.sizes)} once"
            raise InputError("blocks", value=self.blocks, must=must)

    @property
    def groups(self) -> tuple[tuple[str, ...], ...]:
        """The blocks, in order."""
        return tuple(map(tuple, self.blocks)) or (tuple(self.objective.sizes),)

    @property
    def is_reweighted(self) -> bool:
        """Whether the update is the reweighted one and no other."""
        return self.update is None and self.at_zero != "leave"

    def step(self, point: Point) -> dict[str, Numbers]:
        """The next iterate in exact numbers.

        Raises
        ------
        UndefinedUpdateError
            There is none.
        UnresolvedError
            Balls do not tell.
        """
        if self.update is not None:
            return dict(self.update(point))
        weights = [None if part.term is None else self._weight(part, point) for part in self.objective.parts]
        found = dict(point)
        for block in self.groups:
            seen = found if self.order == "gauss_seidel" else point
            found |= _Block(self, block, weights).solved(seen)
        return found

    def _weight(self, part: Part, point: Point) -> Any:
        """Coefficient, factor of the square and weight together; INFINITE where it does not exist."""
        assert part.term is not None
        if not part.coefficient:
            return fmpq(0)
        try:
            weight = function_at(part.term, part.affine.at(point), "weight")
        except ZeroDivisionError:
            weight = None
        if weight is not None:
            return exact(part.coefficient) * fmpq(int(part.term.factor.p), int(part.term.factor.q)) * weight
        if self.at_zero == "undefined":
            raise UndefinedUpdateError(
                "the update", value="a residual of 0", must="must divide by a number other than 0"
            )
        return INFINITE


FLOAT_BITS = 128
"""Of an exact update that is rounded to float64."""

HELD = 1e20
"""Weight in float64 that holds a residual at 0, as a multiple of the largest other one."""

LARGEST = 1e200
"""Weight in float64 above which a system is not formed from it."""

INFINITE = "infinite"
"""A weight that grows without bound."""


@dataclass(frozen=True)
class _Block:
    """The linear system of one block."""

    loop: Loop
    names: tuple[str, ...]
    weights: Sequence[Any]

    def solved(self, point: Point) -> dict[str, Numbers]:
        """The values of the block that minimise the weighted squares, the others being fixed."""
        size = sum(self.loop.objective.sizes[name] for name in self.names)
        matrix = [[fmpq(0)] * size for _ in range(size)]
        gradient = [fmpq(0)] * size
        held: list[Numbers] = []
        left: list[Part] = []
        for part, weight in zip(self.loop.objective.parts, self.weights, strict=True):
            rows = self._rows(part)
            if rows is None:
                continue
            if weight is INFINITE or isinstance(weight, str):
                held += rows
                left.append(part)
                continue
            factor = exact(part.coefficient) if part.term is None else weight
            self._add(matrix, gradient, rows, part.affine.at(point), factor)
        if left and self.loop.at_zero == "leave":
            move = self._left(matrix, gradient, left)
        else:
            move = _minimised(matrix, gradient, held)
        return self._moved(point, move)

    def _rows(self, part: Part) -> list[Numbers] | None:
        """The matrix of a part with respect to the block; None where the block is not in it."""
        if not any(name in part.affine.parts and part.affine.parts[name].any() for name in self.names):
            return None
        rows: list[Numbers] = []
        for i in range(part.affine.size):
            row: Numbers = []
            for name in self.names:
                matrix = part.affine.parts.get(name)
                size = self.loop.objective.sizes[name]
                row += [fmpq(0)] * size if matrix is None else [exact(a) for a in matrix[i]]
            rows.append(row)
        return rows

    @staticmethod
    def _add(
        matrix: list[Numbers], gradient: Numbers, rows: list[Numbers], values: Numbers, factor: Any
    ) -> None:
        """Add factor times the square: its matrix, and half its gradient."""
        for row, value in zip(rows, values, strict=True):
            used = [k for k, a in enumerate(row) if a != 0]
            for k in used:
                gradient[k] = gradient[k] + factor * row[k] * value
                for j in used:
                    matrix[k][j] = matrix[k][j] + factor * row[k] * row[j]

    def _left(self, matrix: list[Numbers], gradient: Numbers, left: list[Part]) -> Numbers:
        """Vardi and Zhang: the step of the rest, shortened by what the held norms pull back."""
        rows = [self._rows(part) for part in self.loop.objective.parts]
        if not all(each is None or _is_multiple_of_unit(each) for each in rows):
            must = "must be for objectives of ||x - a|| and its square alone"
            raise InputError("at_zero='leave'", value="another expression", must=must)
        pull = sum((exact(part.coefficient) for part in left), fmpq(0))
        force, size = 2 * root(inner(gradient, gradient)), matrix[0][0]
        if bool(force <= pull):
            return [fmpq(0)] * len(gradient)
        if not bool(force > pull):
            raise UnresolvedError("a force", value=str(force), must=f"must differ from {pull}")
        return [-g / size * (1 - pull / force) for g in gradient]

    def _moved(self, point: Point, move: Numbers) -> dict[str, Numbers]:
        found, at = {}, 0
        for name in self.names:
            size = self.loop.objective.sizes[name]
            found[name] = [x + dx for x, dx in zip(point[name], move[at : at + size], strict=True)]
            at += size
        return found


def _is_multiple_of_unit(rows: list[Numbers]) -> bool:
    """Whether a matrix is a number times the identity."""
    return all(a == (rows[0][0] if i == j else 0) for i, row in enumerate(rows) for j, a in enumerate(row))


def _minimised(matrix: list[Numbers], gradient: Numbers, held: list[Numbers]) -> Numbers:
    """The step dz that minimises dz'M dz + 2 g'dz where the held rows stay at 0."""
    size = len(gradient)
    basis = _kernel(held, size)
    if not basis:
        return [fmpq(0)] * size
    reduced = [[_form(matrix, a, b) for b in basis] for a in basis]
    right = [-_dot(a, gradient) for a in basis]
    found = _solve(reduced, right)
    return [sum((y * a[k] for y, a in zip(found, basis, strict=True)), fmpq(0)) for k in range(size)]


def _kernel(rows: list[Numbers], size: int) -> list[Numbers]:
    """A basis of the vectors on which rational rows vanish; unit vectors where there are none."""
    if not rows:
        return [[fmpq(int(i == j)) for j in range(size)] for i in range(size)]
    echelon, rank = fmpq_mat(len(rows), size, [a for row in rows for a in row]).rref()
    table = echelon.tolist()[:rank]
    pivots = [next(k for k, a in enumerate(row) if a != 0) for row in table]
    basis = []
    for free in (k for k in range(size) if k not in pivots):
        vector = [fmpq(0)] * size
        vector[free] = fmpq(1)
        for row, pivot in zip(table, pivots, strict=True):
            vector[pivot] = -row[free]
        basis.append(vector)
    return basis


def _dot(a: Numbers, b: Numbers) -> Any:
    return sum((x * y for x, y in zip(a, b, strict=True) if x != 0), fmpq(0))


def _form(matrix: list[Numbers], a: Numbers, b: Numbers) -> Any:
    return _dot(a, [_dot(b, row) for row in matrix])


def _solve(matrix: list[Numbers], right: Numbers) -> Numbers:
    """A solution of the system, the one that leaves free entries at 0 where there are several."""
    size = len(right)
    entries = [a for row in matrix for a in row]
    if all(isinstance(a, fmpq) for a in (*entries, *right)):
        return _rationally(matrix, right)
    try:
        found = arb_mat(size, size, entries).solve(arb_mat(size, 1, right), algorithm="precond")
    except ZeroDivisionError:
        must = "must be invertible throughout"
        raise UnresolvedError("the matrix of the update", value="balls", must=must) from None
    return list(found.entries())


def _rationally(matrix: list[Numbers], right: Numbers) -> Numbers:
    size = len(right)
    whole = [a for row, b in zip(matrix, right, strict=True) for a in (*row, b)]
    echelon, rank = fmpq_mat(size, size + 1, whole).rref()
    found = [fmpq(0)] * size
    for row in echelon.tolist()[:rank]:
        pivot = next(k for k, a in enumerate(row) if a != 0)
        if pivot == size:
            must = "must have a solution"
            raise UndefinedUpdateError("the system of the update", value="a singular matrix", must=must)
        found[pivot] = row[size]
    return found


def unbounded_at_zero(objective: Objective, point: Point) -> bool:
    """Whether a residual whose weight grows without bound is 0 at a rational point."""
    return any(
        part.term is not None
        and part.coefficient
        and grows_without_bound(part.term)
        and all(value == 0 for value in part.affine.at(point))
        for part in objective.parts
    )


def in_unit(loop: Loop, unit: Fraction) -> Loop | None:
    """The same loop for data in another unit: every residual is multiplied by `unit`, and F stays as it is.

    Weights, start and stopping rule are kept as they are stated, but for widths, which have the unit of a
    residual.

    Returns
    -------
    Loop or None
        None where a loss has a unit of its own.
    """
    parts = []
    for part in loop.objective.parts:
        term, power = part.term, sp.Integer(2)
        if term is not None:
            power = degree(term.loss_expression, {VARIABLE: 1} | dict.fromkeys(term.widths, 1))
            if power is None or not power.is_Integer:
                return None
            widths = {name: exactly(value) * exactly(unit) for name, value in term.widths.items()}
            term = replace(term, widths=widths)
        affine = replace(part.affine, constant=part.affine.constant * unit)
        parts.append(Part(part.coefficient / unit ** int(power), affine, term))
    start = (
        None
        if loop.start is None
        else {name: fractions(values) * unit for name, values in loop.start.items()}
    )
    return replace(loop, objective=Objective(tuple(parts)), start=start)


@dataclass(frozen=True)
class FloatRun:
    """Iterates in float64.

    Attributes
    ----------
    points : list of dict of str to float64 array
    ended : bool
        Whether the stopping rule was met.
    """

    points: list[dict[str, Floats]]
    ended: bool


def float_run(loop: Loop, start: Mapping[str, Floats], iterations: int, small: float) -> FloatRun:
    """Run in float64, until the loop's own rule says stop or, without one, a step is small by its share."""
    points = [dict(start)]
    for _ in range(iterations):
        found = _float_step(loop, points[-1])
        if found is None:
            return FloatRun(points, False)
        points.append(found)
        if _stops(loop, points[-2], found, small):
            return FloatRun(points, True)
    return FloatRun(points, False)


def _stops(loop: Loop, before: Mapping[str, Floats], after: Mapping[str, Floats], small: float) -> bool:
    if loop.stop is not None:
        return bool(loop.stop(before, after))
    step = max(float(np.abs(after[name] - before[name]).max()) for name in after)
    return step <= small * max(float(np.abs(values).max()) for values in after.values())


def _float_step(loop: Loop, point: Mapping[str, Floats]) -> dict[str, Floats] | None:
    """The next iterate; None where it is not finite. A residual of 0 is held by a large weight."""
    if loop.update is not None:
        return _rounded_step(loop, point)
    objective, found = loop.objective, dict(point)
    with np.errstate(all="ignore"):
        weights = [_float_weight(part, k, objective, point) for k, part in enumerate(objective.parts)]
    leaves = loop.at_zero == "leave" and np.isinf(weights).any()
    if leaves or any(np.isnan(weight) or weight < 0 for weight in weights):
        return _rounded_step(loop, point)
    held = min(HELD * max((weight for weight in weights if np.isfinite(weight)), default=1.0), LARGEST)
    for block in loop.groups:
        seen = found if loop.order == "gauss_seidel" else point
        rows, values = [], []
        for weight, (matrices, b) in zip(weights, objective.in_arrays, strict=True):
            root = np.sqrt(min(weight, held))
            with np.errstate(all="ignore"):
                whole = sum((A @ seen[name] for name, A in matrices.items()), b)
            columns = [matrices.get(name, np.zeros((len(b), objective.sizes[name]))) for name in block]
            rows.append(root * np.hstack(columns))
            values.append(root * whole)
        with np.errstate(all="ignore"):
            system, right = np.vstack(rows), -np.concatenate(values)
        if not (np.isfinite(system).all() and np.isfinite(right).all()):
            return None
        move = np.linalg.lstsq(system, right, rcond=None)[0]
        at = 0
        for name in block:
            found[name] = seen[name] + move[at : at + objective.sizes[name]]
            at += objective.sizes[name]
    return found if all(np.isfinite(values).all() for values in found.values()) else None


def _rounded_step(loop: Loop, point: Mapping[str, Floats]) -> dict[str, Floats] | None:
    """The exact update of a float64 point, rounded; None if there is none."""
    try:
        with precision(FLOAT_BITS):
            moved = loop.step({name: [exact(float(x)) for x in values] for name, values in point.items()})
    except (SolverError, ZeroDivisionError):
        return None
    return {name: np.array([float(arb(x).mid()) for x in values]) for name, values in moved.items()}


def _float_weight(part: Part, k: int, objective: Objective, point: Mapping[str, Floats]) -> float:
    if part.term is None or not part.coefficient:
        return float(part.coefficient)
    matrices, b = objective.in_arrays[k]
    values = sum((A @ point[name] for name, A in matrices.items()), b)
    return float(part.coefficient) * float(part.term.factor) * weight_in_floats(part.term, values)
