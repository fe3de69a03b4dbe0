"""One update of a reweighted loop in exact arithmetic: a weighted sum of squares, minimised over a block.

It is the update of any loop of this kind, whatever its weights: `algorithm` computes those of the paper,
`verification.reweighted.loops` those of a loss that is stated. Rationals where every number is one, else
balls (midpoint and radius, python-flint's `arb`) of the bits that are set.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import flint
from flint import arb, arb_mat, fmpq, fmpq_mat

from convexperc.errors import SolverError
from verification.exact.balls import Numbers, UnresolvedError

Row = Mapping[int, Any]
"""A row of a matrix: its entries that are not 0, rational, by column."""

UNSOLVABLE = "no solution"


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
class Square:
    """||A z + b||^2.

    Attributes
    ----------
    rows : sequence of Row
        Of A.
    constant : list of fmpq
        b.
    """

    rows: Sequence[Row]
    constant: Numbers


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

    @property
    def gradient(self) -> Numbers:
        """Half the gradient at `point`."""
        rows = zip(self.matrix, self.linear, strict=True)
        return [c + sum((a * x for a, x in zip(row, self.point, strict=True)), fmpq(0)) for row, c in rows]

    def solved(self, name: str, *, unique: bool = False, balls: bool = False) -> Numbers:
        """The z that solves it: the minimiser where M is positive definite.

        Parameters
        ----------
        name : str
            Of the variables, for errors.
        unique : bool
            Whether a singular M is an error; else entries that are free are 0.
        balls : bool
            Whether to solve in balls even where all numbers are rational.

        Raises
        ------
        SingularStepError
            M is singular, and `unique`.
        UndefinedUpdateError
            There is no solution.
        UnresolvedError
            Balls do not tell.
        """
        kept, basis = _kept(self.held, self.point)
        matrix = [[_form(self.matrix, a, b) for b in basis] for a in basis]
        shifted = [k for k, x in enumerate(kept) if not _is_zero(x)]
        forces = [
            c + sum((row[k] * kept[k] for k in shifted), fmpq(0))
            for row, c in zip(self.matrix, self.linear, strict=True)
        ]
        right = [-sum((a * forces[k] for k, a in vector.items()), fmpq(0)) for vector in basis]
        found = list(kept)
        for y, vector in zip(_solve(name, matrix, right, unique, balls), basis, strict=True):
            for k, a in vector.items():
                found[k] = found[k] + y * a
        return found


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
        self.weighted = tuple(weighted)
        self.matrix = [[fmpq(0)] * size for _ in range(size)]
        self.linear = [fmpq(0)] * size
        for factor, square in fixed:
            self._add(factor, square)

    def _add(self, factor: Any, square: Square) -> None:
        used = sorted({k for row in square.rows for k in row})
        if not used or not factor:
            return
        shape = len(square.rows), len(used)
        A = fmpq_mat(*shape, [row.get(k, 0) for row in square.rows for k in used])
        weighted = A.transpose() * factor
        product = (weighted * A).tolist()
        shift = (weighted * fmpq_mat(shape[0], 1, square.constant)).entries()
        for k, row, c in zip(used, product, shift, strict=True):
            self.linear[k] += c
            for j, a in zip(used, row, strict=True):
                self.matrix[k][j] += a

    def system(self, block: Sequence[int], point: Numbers, weights: Sequence[Any]) -> System:
        """The equations of the columns of a block, the others fixed at `point`; a weight of None holds."""
        place = {k: i for i, k in enumerate(block)}
        others = [k for k in range(len(point)) if k not in place and not _is_zero(point[k])]
        matrix = [[self.matrix[k][j] for j in block] for k in block]
        linear = [
            sum((self.matrix[k][j] * point[j] for j in others if self.matrix[k][j] != 0), self.linear[k])
            for k in block
        ]
        held: list[Numbers] = []
        for square, weight in zip(self.weighted, weights, strict=True):
            for row, b in zip(square.rows, square.constant, strict=True):
                inside = [(place[k], a) for k, a in row.items() if k in place]
                if not inside:
                    continue
                if weight is None:
                    held.append([fmpq(0)] * len(block))
                    for i, a in inside:
                        held[-1][i] = a
                    continue
                rest = sum((a * point[k] for k, a in row.items() if k not in place), b)
                for i, a in inside:
                    if not _is_zero(rest):
                        linear[i] = linear[i] + weight * a * rest
                    for j, other in inside:
                        matrix[i][j] = matrix[i][j] + weight * a * other
        return System(matrix, linear, held, [point[k] for k in block])


def _is_zero(value: Any) -> bool:
    """Whether a number is 0 for certain; of a ball with other numbers besides, != 0 is false as well."""
    return bool(value == 0)


def _kept(rows: list[Numbers], point: Numbers) -> tuple[Numbers, list[Row]]:
    """A vector on which the rows are as at `point`, and a basis of those on which they vanish."""
    size = len(point)
    if not rows:
        return [fmpq(0)] * size, [{k: fmpq(1)} for k in range(size)]
    echelon, rank = fmpq_mat(len(rows), size, [a for row in rows for a in row]).rref()
    kept, basis = [fmpq(0)] * size, {k: {k: fmpq(1)} for k in range(size)}
    for row in echelon.tolist()[:rank]:
        entries = [(k, a) for k, a in enumerate(row) if a != 0]
        pivot = entries[0][0]
        kept[pivot] = sum((a * point[k] for k, a in entries), fmpq(0))
        del basis[pivot]
        for k, a in entries[1:]:
            basis[k][pivot] = -a
    return kept, list(basis.values())


def _form(matrix: list[Numbers], a: Row, b: Row) -> Any:
    """a'M b."""
    return sum((x * matrix[i][j] * y for i, x in a.items() for j, y in b.items()), fmpq(0))


def _solve(name: str, matrix: list[Numbers], right: Numbers, unique: bool, balls: bool) -> Numbers:
    size, entries = len(right), [a for row in matrix for a in row]
    if not size:
        return []
    if not balls and all(isinstance(a, fmpq) for a in (*entries, *right)):
        return _rationally(name, fmpq_mat(size, size, entries), right, unique)
    try:
        whole = arb_mat(size, size, [arb(a) for a in entries])
        found = whole.solve(arb_mat(size, 1, [arb(b) for b in right]), algorithm="precond")
    except ZeroDivisionError:
        if unique and all(isinstance(a, fmpq) for a in entries):
            _check_rank(name, fmpq_mat(size, size, entries))
        what, must = f"the matrix of the update of {name}", "must be invertible throughout its balls"
        raise UnresolvedError(what, value=f"{flint.ctx.prec} bits", must=must, remedy="Use more.") from None
    return list(found.entries())


def _rationally(name: str, matrix: fmpq_mat, right: Numbers, unique: bool) -> Numbers:
    size = len(right)
    try:
        return list(matrix.solve(fmpq_mat(size, 1, right)).entries())
    except ZeroDivisionError:
        if unique:
            _check_rank(name, matrix)
    rows = zip(matrix.tolist(), right, strict=True)
    echelon, rank = fmpq_mat(size, size + 1, [a for row, b in rows for a in (*row, b)]).rref()
    found = [fmpq(0)] * size
    for row in echelon.tolist()[:rank]:
        pivot = next(k for k, a in enumerate(row) if a != 0)
        if pivot == size:
            must = "must have a solution"
            raise UndefinedUpdateError(f"the system of the update of {name}", value=UNSOLVABLE, must=must)
        found[pivot] = row[size]
    return found


def _check_rank(name: str, matrix: fmpq_mat) -> None:
    rank = int(matrix.rank())
    if rank < matrix.nrows():
        raise SingularStepError(name, int(matrix.nrows()), rank) from None
