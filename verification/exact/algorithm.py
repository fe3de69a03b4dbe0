"""One iteration of Algorithm 1 in exact arithmetic, in every variant, derived anew from the paper's box.

Two arithmetics: rationals wherever every size in D^w and D^u is rational, and balls (midpoint and radius,
python-flint's `arb`) of 256 bits or more elsewhere. Every answer holds: a ball contains the true number.
It reads the data of a `Problem` and uses nothing else of `convexperc`.
"""

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import flint
from flint import arb, arb_mat, fmpq, fmpq_mat, fmpz_mat

from convexperc.errors import InputError, SolverError
from convexperc.problem.problem import Problem
from verification.exact.balls import Numbers, UnresolvedError, exact, inner, root
from verification.exact.problem import ExactProblem

SIZES = {
    "printed": ("w_i", Fraction(1, 2)),
    "absolute": ("|w_i|", Fraction(1, 2)),
    "corrected": ("|w_i|", Fraction(1)),
    "appendix_half": ("||w||_1", Fraction(1, 2)),
    "appendix_full": ("||w||_1", Fraction(1)),
    "smoothed": ("sqrt(w_i^2 + eps^2)", Fraction(1)),
}
"""What stands for |w_i| in D^w = diag(1/(2 |w_i|)), and the factor of lambda2 D^w and lambda3 D^u."""

ORDERS = ("gauss_seidel", "jacobi")


class SingularStepError(SolverError):
    """A matrix of an update is singular, proved by its exact rank.

    Attributes
    ----------
    system : {"w", "u"}
    order, rank : int
        Of the matrix, after rows and columns that are held at 0 were left out.
    """

    def __init__(self, system: str, order: int, rank: int) -> None:
        self.system, self.order, self.rank = system, order, rank
        must = f"must have full rank {order}"
        super().__init__(f"the matrix of the update of {system}", value=f"rank {rank}", must=must)

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle by the three numbers."""
        return type(self), (self.system, self.order, self.rank)


@dataclass(frozen=True)
class Update:
    """One variant of the two updates.

    Attributes
    ----------
    reading : str
        A key of `SIZES`.
    order : {"gauss_seidel", "jacobi"}
        Whether u is computed from w(i+1) or from w(i).
    eps : Fraction
        Of the smoothed variant; 0 elsewhere.

    Raises
    ------
    InputError
        There is no such variant or order, or eps does not suit it.
    """

    reading: str
    order: str
    eps: Fraction = Fraction(0)

    def __post_init__(self) -> None:
        for name, value, known in (("reading", self.reading, SIZES), ("order", self.order, ORDERS)):
            if value not in known:
                raise InputError(name, value=value, must=f"must be one of {', '.join(known)}")
        if (self.eps > 0) != (self.reading == "smoothed") or self.eps < 0:
            must = "must be > 0 in the smoothed variant and 0 in the others"
            raise InputError("eps", value=str(self.eps), must=must)

    @property
    def factor(self) -> Fraction:
        """Of lambda2 D^w and lambda3 D^u."""
        return SIZES[self.reading][1]

    def view_sizes(self, w: Numbers) -> Numbers:
        """What stands for |w_i|, by entry."""
        if self.reading == "printed":
            return w
        if self.reading == "smoothed":
            return [self._smooth(x * x) for x in w]
        if self.reading.startswith("appendix"):
            return [sum((abs(x) for x in w), fmpq(0))] * len(w)
        return [abs(x) for x in w]

    def modality_size(self, block: Numbers) -> Any:
        """||u^i||_2, smoothed in the smoothed variant."""
        square = inner(block, block)
        return self._smooth(square) if self.reading == "smoothed" else root(square)

    def _smooth(self, square: Any) -> Any:
        return root(square + exact(self.eps * self.eps))


class Systems:
    """The linear systems of Algorithm 1 for one problem, and the products that every step needs."""

    def __init__(self, problem: Problem | ExactProblem) -> None:
        self.problem = data = ExactProblem.of(problem)
        self.n, self.d, self.groups = data.n, data.d, data.groups
        self.o = [fmpq(x, data.target_unit) for x in data.target]
        self.lambda1, self.lambda2, self.lambda3 = (exact(x) for x in data.lambdas)
        self.X = fmpq_mat(fmpz_mat([list(row) for row in data.rows])) / data.unit
        transposed = self.X.transpose()
        self.rows, self.columns = self.X.tolist(), transposed.tolist()
        self.views, self.features = (self.X * transposed).tolist(), (transposed * self.X).tolist()

    def start(self) -> tuple[Numbers, Numbers]:
        """Line 2: w = argmin ||X'w - o||, then u = argmin ||Xu - w||, each of least norm, exactly.

        Formula: with X = C R, C its pivot columns and R the nonzero rows of its echelon form, the
        pseudo-inverse of X is R'(RR')^-1 (C'C)^-1 C'.
        """
        echelon, rank = self.X.rref()
        if rank == 0:
            return [fmpq(0)] * self.n, [fmpq(0)] * self.d
        rows = echelon.tolist()[:rank]
        pivots = [next(k for k, x in enumerate(row) if x != 0) for row in rows]
        R = fmpq_mat(rank, self.d, [x for row in rows for x in row])
        C = fmpq_mat(self.n, rank, [row[k] for row in self.rows for k in pivots])
        outer, gram = R * R.transpose(), C.transpose() * C
        w = C * gram.solve(outer.solve(R * fmpq_mat(self.d, 1, self.o)))
        u = R.transpose() * outer.solve(gram.solve(C.transpose() * w))
        return list(w.entries()), list(u.entries())

    def step(self, update: Update, w: Numbers, u: Numbers, *, balls: bool = False) -> tuple[Numbers, Numbers]:
        """Lines 4-8: the next (w, u); with `balls` no rational system is solved.

        Raises
        ------
        SingularStepError
            A matrix is singular.
        UnresolvedError
            Balls do not tell.
        """
        factor = exact(update.factor)
        weight2, weight3 = self.lambda2 * factor, self.lambda3 * factor
        ridge_w = [_ridge(weight2, size) for size in update.view_sizes(w)]
        ridge_u = [fmpq(0)] * self.d
        for group in self.groups:
            for k in group:
                ridge_u[k] = _ridge(weight3, update.modality_size([u[j] for j in group]))
        target = [t + self.lambda1 * x for t, x in zip(self.o, u, strict=True)]
        coupled = [
            [x + self.lambda1 * (i == j) for j, x in enumerate(row)] for i, row in enumerate(self.views)
        ]
        new_w = _solve("w", coupled, ridge_w, [inner(row, target) for row in self.rows], balls)
        seen = new_w if update.order == "gauss_seidel" else w
        scaled = [[self.lambda1 * x for x in row] for row in self.features]
        new_u = _solve("u", scaled, ridge_u, [self.lambda1 * inner(c, seen) for c in self.columns], balls)
        return new_w, new_u


def _ridge(weight: Any, size: Any) -> Any:
    """Return weight / (2 size); None, the limit that holds the entry at 0, where size = 0 and weight > 0."""
    if weight == 0:
        return fmpq(0)
    if size == 0:
        return None
    if isinstance(size, arb) and size.contains(0):
        raise UnresolvedError("a size in D", value=str(size), must="must exclude 0", remedy="Use more bits.")
    return weight / (2 * size)


def _solve(name: str, matrix: list[Numbers], ridge: Numbers, rhs: Numbers, balls: bool) -> Numbers:
    free = [i for i, entry in enumerate(ridge) if entry is not None]
    order, result = len(free), [fmpq(0)] * len(rhs)
    if not free:
        return result
    entries = [matrix[i][j] + ridge[i] if i == j else matrix[i][j] for i in free for j in free]
    right = [rhs[i] for i in free]
    rational = not balls and all(isinstance(x, fmpq) for x in entries + right)
    solution = (
        _rationally(name, order, entries, right) if rational else _in_balls(name, order, entries, right)
    )
    for i, found in zip(free, solution, strict=True):
        result[i] = found
    return result


def _rationally(name: str, order: int, entries: Numbers, right: Numbers) -> Numbers:
    matrix = fmpq_mat(order, order, entries)
    try:
        return list(matrix.solve(fmpq_mat(order, 1, right)).entries())
    except ZeroDivisionError:
        raise SingularStepError(name, order, int(matrix.rank())) from None


def _in_balls(name: str, order: int, entries: Numbers, right: Numbers) -> Numbers:
    matrix = arb_mat(order, order, [arb(x) for x in entries])
    try:
        return list(matrix.solve(arb_mat(order, 1, [arb(x) for x in right]), algorithm="precond").entries())
    except ZeroDivisionError:
        if all(isinstance(x, fmpq) for x in entries):
            rank = int(fmpq_mat(order, order, entries).rank())
            if rank < order:
                raise SingularStepError(name, order, rank) from None
        must = "must be invertible throughout its balls"
        what = f"the matrix of the update of {name}"
        raise UnresolvedError(what, value=f"{flint.ctx.prec} bits", must=must, remedy="Use more.") from None
