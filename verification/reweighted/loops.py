"""Reweighted loops: an objective, the order in which its blocks are updated, and the exact update.

The update of a block minimises the objective with each loss replaced by weight(r_i) square(r), r_i being the residual
at the iterate; a block of Gauss-Seidel sees the new values of those before it, one of Jacobi does not.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from flint import arb_mat, fmpq, fmpq_mat
from numpy.typing import NDArray

from convexperc.errors import InputError, SolverError
from verification.exact.balls import Numbers, UnresolvedError, exact
from verification.reweighted.objective import Objective, Part, function_at, weight_in_floats

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
        At a residual of 0 where the weight grows without bound: it is held at 0, which is the limit of the update;
        the update does not exist; or, by Vardi and Zhang's rule, it is left if that lowers F (where the residual is
        the whole block less a point).
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
    _: Any = field(default=None, repr=False)

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
        size, scale = len(matrix), matrix[0][0]
        alone = all(matrix[i][j] == (scale if i == j else 0) for i in range(size) for j in range(size))
        units = all(_is_identity(self._rows(part)) for part in left)
        if not (alone and units):
            must = "must be the whole block less a point, and the weighted squares a multiple of its square"
            raise InputError("at_zero='leave'", value="another term at 0", must=must)
        pull = sum((exact(part.coefficient) for part in left), fmpq(0))
        force = 2 * _norm(gradient)
        if bool(force <= pull):
            return [fmpq(0)] * size
        if not bool(force > pull):
            raise UnresolvedError("a force", value=str(force), must=f"must differ from {pull}")
        return [-g / scale * (1 - pull / force) for g in gradient]

    def _moved(self, point: Point, move: Numbers) -> dict[str, Numbers]:
        found, at = {}, 0
        for name in self.names:
            size = self.loop.objective.sizes[name]
            found[name] = [x + dx for x, dx in zip(point[name], move[at : at + size], strict=True)]
            at += size
        return found


def _is_identity(rows: list[Numbers] | None) -> bool:
    return (
        rows is not None
        and all(a == (1 if i == j else 0) for i, row in enumerate(rows) for j, a in enumerate(row))
        and len(rows) == len(rows[0])
    )


def _norm(values: Numbers) -> Any:
    from verification.exact.balls import inner, root  # noqa: PLC0415

    return root(inner(values, values))


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
    size = len(right)
    entries = [a for row in matrix for a in row]
    if all(isinstance(a, fmpq) for a in (*entries, *right)):
        try:
            return list(fmpq_mat(size, size, entries).solve(fmpq_mat(size, 1, right)).entries())
        except ZeroDivisionError:
            raise UndefinedUpdateError(
                "the matrix of the update", value="singular", must=f"must have full rank {size}"
            ) from None
    try:
        found = arb_mat(size, size, entries).solve(arb_mat(size, 1, right), algorithm="precond")
    except ZeroDivisionError:
        raise UnresolvedError(
            "the matrix of the update", value="balls", must="must be invertible throughout"
        ) from None
    return list(found.entries())


def run_in_floats(
    loop: Loop, start: Mapping[str, NDArray[np.float64]], iterations: int
) -> list[dict[str, Any]]:
    """The iterates in float64, from the start on, until the loop stops or has no update."""
    points = [dict(start)]
    for _ in range(iterations):
        found = _float_step(loop, points[-1])
        if found is None:
            break
        points.append(found)
        if loop.stop is not None and loop.stop(points[-2], points[-1]):
            break
    return points


def _float_step(loop: Loop, point: Mapping[str, NDArray[np.float64]]) -> dict[str, Any] | None:
    if loop.update is not None:
        moved = loop.update({name: [exact(float(x)) for x in values] for name, values in point.items()})
        return {name: np.array([float(x) for x in values]) for name, values in moved.items()}
    objective, found = loop.objective, dict(point)
    floats = objective._floats
    weights = [_float_weight(part, floats[k], point) for k, part in enumerate(objective.parts)]
    for block in loop.groups:
        seen = found if loop.order == "gauss_seidel" else point
        rows, values = [], []
        for weight, (matrices, b) in zip(weights, floats, strict=True):
            whole = sum((A @ seen[name] for name, A in matrices.items()), b)
            columns = [matrices.get(name, np.zeros((len(b), objective.sizes[name]))) for name in block]
            if weight is None or not np.isfinite(weight) or weight < 0:
                if not np.hstack(columns).any():
                    continue
                return None
            rows.append(np.sqrt(weight) * np.hstack(columns))
            values.append(np.sqrt(weight) * whole)
        move = np.linalg.lstsq(np.vstack(rows), -np.concatenate(values), rcond=None)[0]
        at = 0
        for name in block:
            found[name] = seen[name] + move[at : at + objective.sizes[name]]
            at += objective.sizes[name]
    return found


def _float_weight(part: Part, floats: Any, point: Mapping[str, Any]) -> float | None:
    if part.term is None or not part.coefficient:
        return float(part.coefficient)
    values = sum((A @ point[name] for name, A in floats[0].items()), floats[1])
    return float(part.coefficient) * float(part.term.factor) * weight_in_floats(part.term, values)
