"""One update of a reweighted loop in exact arithmetic: a weighted sum of squares, minimised over a block.

It is the update of any loop of this kind, whatever its weights: `algorithm` computes those of the paper,
`verification.reweighted.loops.loop` those of a loss that is stated. Rationals where every number is one, else
balls (midpoint and radius, python-flint's `arb`) of the bits that are set.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import flint
from flint import arb_mat, fmpq, fmpq_mat

from convexperc.errors import SolverError
from verification.exact.balls import Numbers, UnresolvedError, inner

Row = Mapping[int, Any]
"""A row of a matrix: its entries that are not 0, rational, by column."""

Square = Sequence[tuple[Row, Any]]
"""||A z + b||^2: the rows of A, each with its entry of b, all rational."""


class UndefinedUpdateError(SolverError):
    """There is no update: it divides by a residual of 0, or its system has no solution."""


class SingularStepError(UndefinedUpdateError):
    """A matrix of an update is singular, proved by its exact rank.

    Attributes
    ----------
    system : str
        Names of the variables of the block.
    order, rank : int
        Of the matrix, after what is held was left out.
    """

    def __init__(self, system: str, order: int, rank: int) -> None:
        self.system, self.order, self.rank = system, order, rank
        must = f"must have full rank {order}"
        super().__init__(f"the matrix of the update of {system}", value=f"rank {rank}", must=must)

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle by the three numbers."""
        return type(self), (self.system, self.order, self.rank)


@dataclass(frozen=True)
class System:
    """The normal equations M z = -c of one block, where what is held keeps its value.

    Attributes
    ----------
    matrix : list of lists
        M.
    linear : list
        c, half the gradient at z = 0.
    held : list of lists
        Rows A of the block with A z as it is at `point`.
    point : list
        The block where the update starts.
    """

    matrix: list[Numbers]
    linear: Numbers
    held: list[Numbers]
    point: Numbers

    def gradient(self, z: Numbers) -> Numbers:
        """Half the gradient, M z + c."""
        return [inner(row, z) + c for row, c in zip(self.matrix, self.linear, strict=True)]

    def solved(self, name: str, *, unique: bool = False) -> Numbers:
        """The z that solves it: the minimiser where M is positive definite.

        Parameters
        ----------
        name : str
            Of the variables, for errors.
        unique : bool
            Whether a singular M is an error; else entries that are free keep their value.

        Raises
        ------
        SingularStepError
            M is singular, and `unique`.
        UndefinedUpdateError
            There is no solution.
        UnresolvedError
            Balls do not tell.
        """
        size = len(self.point)
        kernel = _kernel(self.held, size)
        basis, free = list(kernel.values()), [self.point[k] for k in kernel]
        met = _combined(kernel, self.point, size)
        kept = [fmpq(0) if k in kernel else self.point[k] - met[k] for k in range(size)]
        gradient = self.gradient(kept)
        matrix = [_form(self.matrix, a, b) for a in basis for b in basis]
        right = [-sum((a * gradient[k] for k, a in vector.items()), fmpq(0)) for vector in basis]
        moved = _solve(name, matrix, right, None if unique else free)
        found = _combined(dict(enumerate(basis)), moved, size)
        return [x + y for x, y in zip(kept, found, strict=True)]


class WeightedSquares:
    """sum_p k_p ||A_p z + b_p||^2 + sum_q weight_q ||A_q z + b_q||^2, the weights given for each update.

    Parameters
    ----------
    size : int
        Of z.
    fixed : sequence of (fmpq, Square)
        With their factors k.
    weighted : sequence of Square
    """

    def __init__(self, size: int, fixed: Sequence[tuple[Any, Square]], weighted: Sequence[Square]) -> None:
        matrix, linear = fmpq_mat(size, size), fmpq_mat(size, 1)
        for factor, square in fixed:
            A = fmpq_mat(len(square), size, [row.get(k, 0) for row, _ in square for k in range(size)])
            scaled = A.transpose() * factor
            matrix += scaled * A
            linear += scaled * fmpq_mat(len(square), 1, [b for _, b in square])
        self.matrix, self.linear, self.weighted = matrix.tolist(), linear.entries(), weighted

    def system(self, block: Sequence[int], point: Numbers, weights: Sequence[Any]) -> System:
        """The equations of the columns of a block, the others fixed at `point`; a weight of None holds."""
        place = {k: i for i, k in enumerate(block)}
        others = [0 if k in place else x for k, x in enumerate(point)]
        matrix = [[self.matrix[k][j] for j in block] for k in block]
        linear = [
            sum((a * x for a, x in zip(self.matrix[k], others, strict=True) if a != 0), self.linear[k])
            for k in block
        ]
        held: list[Numbers] = []
        for square, weight in zip(self.weighted, weights, strict=True):
            for row, b in square:
                inside = [(place[k], a) for k, a in row.items() if k in place]
                if inside and weight is None:
                    held.append([row.get(k, fmpq(0)) for k in block])
                    continue
                rest = sum((a * others[k] for k, a in row.items()), b)
                for i, a in inside:
                    linear[i] = linear[i] + weight * a * rest
                    for j, other in inside:
                        matrix[i][j] = matrix[i][j] + weight * a * other
        return System(matrix, linear, held, [point[k] for k in block])


def _kernel(rows: list[Numbers], size: int) -> dict[int, Row]:
    """A basis of the vectors on which rational rows vanish, each by the column in which it alone is not 0."""
    basis: dict[int, dict[int, Any]] = {k: {k: fmpq(1)} for k in range(size)}
    echelon = fmpq_mat(len(rows), size, [a for row in rows for a in row]).rref()[0]
    for row in echelon.tolist():
        entries = [(k, a) for k, a in enumerate(row) if a != 0]
        if entries:
            del basis[entries[0][0]]
        for k, a in entries[1:]:
            basis[k][entries[0][0]] = -a
    return dict(basis)


def _combined(basis: Mapping[int, Row], values: Numbers, size: int) -> Numbers:
    """The sum of the vectors of a basis, each times the value at its key."""
    found = [fmpq(0)] * size
    for key, vector in basis.items():
        for k, a in vector.items():
            found[k] = found[k] + values[key] * a
    return found


def _form(matrix: list[Numbers], a: Row, b: Row) -> Any:
    """a'M b."""
    return sum((x * matrix[i][j] * y for i, x in a.items() for j, y in b.items()), fmpq(0))


def _solve(name: str, entries: Numbers, right: Numbers, free: Numbers | None) -> Numbers:
    """The solution; of several, the one with these values in what is free, or an error without values."""
    size, rational = len(right), all(isinstance(a, fmpq) for a in entries)
    if not size:
        return []
    try:
        if rational and all(isinstance(b, fmpq) for b in right):
            return list(fmpq_mat(size, size, entries).solve(fmpq_mat(size, 1, right)).entries())
        matrix = arb_mat(size, size, entries)
        return list(matrix.solve(arb_mat(size, 1, right), algorithm="precond").entries())
    except ZeroDivisionError:
        rank = int(fmpq_mat(size, size, entries).rank()) if rational else size
    if free is None and rank < size:
        raise SingularStepError(name, size, rank)
    if not all(isinstance(a, fmpq) for a in (*entries, *right)):
        what, must = f"the matrix of the update of {name}", "must be invertible throughout its balls"
        raise UnresolvedError(what, value=f"{flint.ctx.prec} bits", must=must, remedy="Use more.")
    rows = [[*entries[i * size : (i + 1) * size], -b] for i, b in enumerate(right)]
    kernel = _kernel(rows, size + 1)  # M z = b is [M, -b] (z, 1) = 0
    if free is None or size not in kernel:
        must = "must have a solution"
        raise UndefinedUpdateError(f"the system of the update of {name}", value="none", must=must)
    return _combined(kernel, [*free, fmpq(1)], size + 1)[:size]
