"""One iteration of Algorithm 1 in exact arithmetic, in every variant, derived anew from the paper's box.

It is the general update of `reweighting` with the weights of D^w and D^u: rationals wherever every size in
them is rational, and balls of 256 bits or more elsewhere. Every answer holds: a ball contains the true
number. It reads the data of a `Problem` and uses nothing else of `convexperc`.
"""

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from flint import arb, fmpq, fmpq_mat, fmpz_mat

from convexperc.errors import InputError
from convexperc.problem.problem import Problem
from verification.exact.balls import Numbers, UnresolvedError, exact, inner, root
from verification.exact.problem import ExactProblem
from verification.exact.reweighting import WeightedSquares

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
        self.rows = self.X.tolist()
        self.squares = self._squares()

    def _squares(self) -> WeightedSquares:
        """||X'w - o||^2 + lambda1 ||Xu - w||^2, then w_i^2 of each view and ||u^i||^2 of each modality."""
        views, one, zero = range(self.n), fmpq(1), fmpq(0)
        columns = zip(*self.rows, strict=True)
        match = [(dict(enumerate(column)), -x) for column, x in zip(columns, self.o, strict=True)]
        consensus = [
            ({i: -one} | {self.n + k: x for k, x in enumerate(row)}, zero) for i, row in enumerate(self.rows)
        ]
        weighted = [[({i: one}, zero)] for i in views]
        weighted += [[({self.n + k: one}, zero) for k in group] for group in self.groups]
        return WeightedSquares(self.n + self.d, [(one, match), (self.lambda1, consensus)], weighted)

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

    def step(self, update: Update, w: Numbers, u: Numbers) -> tuple[Numbers, Numbers]:
        """Lines 4-8: the next (w, u).

        Raises
        ------
        SingularStepError
            A matrix is singular.
        UnresolvedError
            Balls do not tell.
        """
        factor = exact(update.factor)
        sizes = update.view_sizes(w) + [update.modality_size([u[k] for k in group]) for group in self.groups]
        lambdas = [self.lambda2 * factor] * self.n + [self.lambda3 * factor] * len(self.groups)
        weights = [_weight(weight, size) for weight, size in zip(lambdas, sizes, strict=True)]
        views, features = range(self.n), range(self.n, self.n + self.d)
        new_w = self.squares.system(views, [*w, *u], weights).solved("w", unique=True)
        seen = new_w if update.order == "gauss_seidel" else w
        new_u = self.squares.system(features, [*seen, *u], weights).solved("u", unique=True)
        return new_w, new_u


def _weight(weight: Any, size: Any) -> Any:
    """Return weight / (2 size); None, the limit that holds the entry at 0, where size = 0 and weight > 0."""
    if weight == 0:
        return fmpq(0)
    if size == 0:
        return None
    if isinstance(size, arb) and size.contains(0):
        raise UnresolvedError("a size in D", value=str(size), must="must exclude 0", remedy="Use more bits.")
    return weight / (2 * size)
