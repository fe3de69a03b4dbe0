"""Exact rational arithmetic for the equality cases, where rounding would change the answer.

Rank cannot be proved in floating point. Here floats are taken as the rationals that they are, and FLINT does
the linear algebra over Q. It is loaded when the first such case is met, not when this module is imported.
"""

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from convexperc.caching import cached_property
from convexperc.certificate.rounding import Ball
from convexperc.problem.arrays import FeatureVector, Matrix, Vector
from convexperc.problem.problem import Problem

PRIME = 2**31 - 1
"""Full rank modulo a prime proves full rank over Q, at the cost of machine integers."""
WORD_BITS = 64
"""Bits of a machine word, the unit of `WORK_LIMIT`."""
READ_COST = 1000
"""Reading a float as an integer takes as long as so many products modulo a prime (0.4 us against 0.4 ns)."""
ECHELON_COST = 40
"""Words that FLINT's exact echelon form multiplies for each of (n - r) r^3 entries; measured: 9 to 75."""
PRODUCTS_PER_SECOND = 1_000_000_000
"""Products of machine words in a second: each takes 0.4 to 1.5 ns."""
LONGER = 4
"""Solving with M'M costs so many times as much as with B B': its entries are twice as long."""
WORK_LIMIT = 800_000_000
"""Products of machine words that one exact computation may cost, beyond which nothing is proved.

They take about a second at most: 0.1 s for 60 x 500 floats of one size, 0.9 s for 150 x 600, and 0.5 s for
30 x 60 floats from 1e-300 to 1e150, which make integers of 1600 bits.
"""

Integers = NDArray[np.object_]
Exact = Any
"""A flint.fmpz_mat or flint.fmpq_mat."""


def _flint() -> Any:
    import flint  # noqa: PLC0415 - certifying a point needs NumPy alone but in the equality cases

    return flint


@dataclass(frozen=True, eq=False)
class RowSpace:
    """The span of the rows of X, by a row basis that is proved over Q.

    Attributes
    ----------
    A : fmpz_mat (n, d)
        A 2^exponent = X exactly.
    exponent : int
    rows : tuple of r int
        A maximal independent set of rows, r = rank X.
    """

    A: Exact
    exponent: int
    rows: tuple[int, ...]

    @classmethod
    def of(cls, X: Matrix) -> "RowSpace":
        """Find and prove a row basis, whatever it costs."""
        whole, exponent = integers(X)
        A = _flint().fmpz_mat(*X.shape, whole.ravel().tolist())
        return cls(A, exponent, _pivots(A.transpose()))

    @classmethod
    def within_limit(cls, X: Matrix, limit: float | None = None) -> "RowSpace | None":
        """`of`, or None where its worst case is beyond so many products; without, beyond `WORK_LIMIT`."""
        n, d = X.shape
        limit = WORK_LIMIT if limit is None else limit
        if n * d * (READ_COST + min(n, d)) > limit:
            return None
        whole, exponent = integers(X)
        A = _flint().fmpz_mat(n, d, whole.ravel().tolist())
        rank = _modulo_prime(A).rank()
        if rank < min(n, d) and ECHELON_COST * (n - rank) * rank**3 * _words(A) > limit:
            return None
        return cls(A, exponent, _pivots(A.transpose()))

    @property
    def rank(self) -> int:
        """Of X."""
        return len(self.rows)

    @cached_property
    def words(self) -> float:
        """Machine words of the largest entry of A, at least one."""
        return _words(self.A)

    @property
    def work(self) -> float:
        """Products of machine words that solving with B B' costs."""
        r, d = self.rank, self.A.ncols()
        return float(r**2 * (r**2 + 2 * d) * self.words**2)

    @property
    def solvable(self) -> bool:
        """Whether that is within `WORK_LIMIT`."""
        return self.work <= WORK_LIMIT

    @cached_property
    def basis(self) -> Exact:
        """B, the basis itself: fmpz_mat (r, d)."""
        table = self.A.table()
        return _flint().fmpz_mat(self.rank, self.A.ncols(), [v for row in self.rows for v in table[row]])

    @cached_property
    def image(self) -> Exact:
        """M = A B', fmpz_mat (n, r), of full column rank; its range is that of X."""
        return self.A * self.basis.transpose()

    def solved(self, right: Exact) -> Exact:
        """(B B')^-1 right for integers (r, 1), fmpq_mat (r, 1)."""
        return (self.basis * self.basis.transpose()).solve(right)

    def residual(self, t: Exact) -> Exact:
        """Subtract from t (d, 1) its orthogonal projection onto the span: t - B'(B B')^-1 B t."""
        return _flint().fmpq_mat(t) - self.basis.transpose() * self.solved(self.basis * t)

    def fitted(self, t: Exact) -> Exact:
        """The u (d, 1) of least norm for which A'A u is the projection of t: B'(M'M)^-1 B t."""
        return self.basis.transpose() * (self.image.transpose() * self.image).solve(self.basis * t)

    def coupling(self, w: Exact) -> Exact:
        """The u (d, 1) of least norm for which A u is the projection of w (n, 1) onto the range of A."""
        if self.rank == self.A.nrows():
            return self.basis.transpose() * self.solved(w)
        return self.basis.transpose() * (self.image.transpose() * self.image).solve(
            self.image.transpose() * w
        )

    def outside(self, w: Exact) -> Exact:
        """The orthogonal projection of w (n, 1) onto {b : X'b = 0}."""
        full = self.rank == self.A.nrows()
        return 0 * w if full else _flint().fmpq_mat(w) - self.A * self.coupling(w)


def integers(values: NDArray[np.float64]) -> tuple[Integers, int]:
    """Write floats as integers times one power of two: values = result * 2^exponent, exactly."""
    mantissas, exponents = np.frexp(values)
    scaled = np.ldexp(mantissas, 53).astype(np.int64)
    exponents = np.where(scaled == 0, 0, exponents.astype(np.int64) - 53)
    lowest = int(exponents[scaled != 0].min(initial=np.iinfo(np.int64).max)) if scaled.any() else 0
    shifts = np.where(scaled == 0, 0, exponents - lowest)
    whole = scaled.astype(object) * np.left_shift(np.ones_like(shifts, dtype=object), shifts.astype(object))
    return whole, lowest


def column(whole: Integers) -> Exact:
    """Integers of shape (k,) as an fmpz_mat (k, 1)."""
    return _flint().fmpz_mat(whole.size, 1, whole.tolist())


def numerators(values: Exact) -> tuple[Integers, int]:
    """An fmpz_mat or fmpq_mat (k, 1) as integers of shape (k,) over one denominator > 0."""
    over, denominator = _flint().fmpq_mat(values).numer_denom()
    result = np.full(over.nrows(), 0, dtype=object)
    result[:] = [int(value) for value in over.entries()]
    return result, int(denominator)


def _modulo_prime(A: Exact) -> Any:
    return _flint().nmod_mat(A, PRIME)


def _pivots(A: Exact) -> tuple[int, ...]:
    """A maximal independent set of columns, proved: modulo a prime if that gives full rank, else over Q."""
    echelon, rank = _modulo_prime(A).rref()
    if rank < min(A.nrows(), A.ncols()):
        echelon, _, rank = A.rref()
    found: list[int] = []
    for row in echelon.table()[:rank]:
        found.append(next(k for k in range(found[-1] + 1 if found else 0, A.ncols()) if row[k] != 0))
    return tuple(found)


def _words(A: Exact) -> float:
    """Machine words of the largest entry, at least one."""
    return max(1.0, int(max(abs(value) for value in A.entries())).bit_length() / WORD_BITS)


def squared_distance(X: Matrix, o: FeatureVector) -> Fraction | None:
    """min_w ||X'w - o||^2 as an exact rational, or None beyond `WORK_LIMIT`.

    Formula: o'o - c'(B B')^-1 c with c = B o and a row basis B.
    """
    space = RowSpace.within_limit(X)
    if space is None or not space.solvable:
        return None
    whole, exponent = integers(o)
    t = column(whole)
    c = space.basis * t
    (share,), denominator = numerators(c.transpose() * space.solved(c))
    return (int(whole @ whole) - Fraction(share, denominator)) * Fraction(2) ** (2 * exponent)


def exact_optimum(problem: Problem) -> Fraction | None:
    """F* as an exact rational where lambda2 = 0 and lambda1 or lambda3 is 0: then it is a squared distance.

    None in every other case, and beyond `WORK_LIMIT`.
    """
    if problem.lambda2 > 0.0 or not problem.penalties.uncoupled:
        return None
    return squared_distance(problem.X, problem.o)


def into_left_null_space(X: Matrix, b: Vector) -> Ball | None:
    """Move b into {b : X'b = 0} exactly, and enclose the result; None beyond `WORK_LIMIT` (Lemma R33).

    The entries of b outside the row basis B are kept as they are; X'b = 0 gives the others: those of b less
    (B B')^-1 B X'b. None also where a result leaves float64.
    """
    space = RowSpace.within_limit(X)
    if space is None:
        return None
    if space.rank == X.shape[0]:
        return Ball.exact(np.zeros(X.shape[0]))
    if not space.solvable:
        return None
    whole, exponent = integers(b)
    pull = space.A.transpose() * column(whole)
    excess, denominator = numerators(space.solved(space.basis * pull))
    unit = Fraction(2) ** exponent
    result = [int(value) * unit for value in whole]
    for row, value in zip(space.rows, excess, strict=True):
        result[row] -= Fraction(value, denominator) * unit
    try:
        mid = np.array([float(value) for value in result])
    except OverflowError:
        return None
    errors = [
        0.0 if Fraction(m) == value else np.spacing(abs(m)) for m, value in zip(mid, result, strict=True)
    ]
    return Ball(mid, np.array(errors))
