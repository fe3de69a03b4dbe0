"""A cone program with its floats as they are, and its products in ball arithmetic.

    minimise 1/2 x'Px + q'x + offset    subject to    s = b - Ax in K,

where K is a product of zeros (s = 0), of half-lines (s >= 0) and of second-order cones (s_0 >= ||s_1..||), in
this order of rows. It is what CVXPY hands to a solver.
"""

from dataclasses import dataclass
from typing import Any

import flint
import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from convexperc.caching import cached_property
from convexperc.enclosure.balls import Number, Numbers

Floats = NDArray[np.float64]
"""A vector of float64."""
BITS = 256
"""Precision of every ball of a proof: float64 data leave no more than 2^-200 of it as width."""


class NoBoundError(Exception):
    """What is asked for is not proved; the message says why. It never leaves this package."""


@dataclass(frozen=True, eq=False)
class ConeProgram:
    """The data of a cone program.

    Attributes
    ----------
    P : csr_array (n, n)
        Symmetric.
    q : float64 (n,)
    A : csr_array (m, n)
    b : float64 (m,)
    offset : float
    zeros, nonnegatives : int
        How many rows of each; the zeros come first.
    second_order : tuple of int
        Rows of each second-order cone, in order.
    kept : int (m,)
        Which rows of the data these are.
    """

    P: Any
    q: Floats
    A: Any
    b: Floats
    offset: float
    zeros: int
    nonnegatives: int
    second_order: tuple[int, ...]
    kept: NDArray[np.int_]

    @classmethod
    def of(cls, P: Any, q: Any, A: Any, b: Any, offset: float, dims: Any) -> "ConeProgram":
        """Check the data and leave out rows s >= 0 with b = inf, which hold at every x.

        Raises
        ------
        NoBoundError
            There are other cones, P is not symmetric, or a number is not finite.
        """
        others = [name for name in ("exp", "psd", "p3d", "pnd") if getattr(dims, name, None)]
        if others:
            raise NoBoundError(
                f"cones of the kind {others[0]!r} are not covered, only linear and second-order ones"
            )
        q, b = np.asarray(q, dtype=np.float64), np.asarray(b, dtype=np.float64)
        zeros, nonnegatives = int(dims.zero), int(dims.nonneg)
        rows = np.arange(b.size)
        vacuous = (rows >= zeros) & (rows < zeros + nonnegatives) & (b == np.inf)
        kept = np.flatnonzero(~vacuous)
        A = sp.csr_array(A, dtype=np.float64)[kept]
        P = sp.csr_array((q.size, q.size)) if P is None else sp.csr_array(P, dtype=np.float64)
        for matrix in (A, P):
            matrix.sum_duplicates()
            matrix.eliminate_zeros()
        b = b[kept]
        if not all(np.isfinite(v).all() for v in (P.data, q, A.data, b, [offset])):
            raise NoBoundError("a number of the canonical problem is not finite")
        if (P != P.T).nnz:
            raise NoBoundError("the matrix of the quadratic objective is not symmetric to the last bit")
        left = nonnegatives - int(vacuous.sum())
        found = cls(P, q, A, b, float(offset), zeros, left, tuple(map(int, dims.soc)), kept)
        if found.zeros + found.nonnegatives + sum(found.second_order) != b.size:
            raise NoBoundError("the cones do not account for all rows")
        return found

    @property
    def n(self) -> int:
        """Number of variables."""
        return int(self.q.size)

    @property
    def nonnegative_rows(self) -> range:
        """The rows s >= 0."""
        return range(self.zeros, self.zeros + self.nonnegatives)

    @property
    def second_order_rows(self) -> list[range]:
        """The rows of each second-order cone."""
        starts = np.cumsum([self.zeros + self.nonnegatives, *self.second_order])
        return [range(int(a), int(a) + size) for a, size in zip(starts, self.second_order, strict=False)]

    @cached_property
    def transposed(self) -> Any:
        """A' by rows, csr_array (n, m)."""
        return sp.csr_array(self.A.T)

    def slack(self, x: Numbers) -> Numbers:
        """S = b - Ax, m balls."""
        return [flint.arb(float(b)) - v for b, v in zip(self.b, times(self.A, x), strict=True)]

    def objective(self, x: Numbers) -> Number:
        """1/2 x'Px + q'x + offset, a ball."""
        total = inner(x, times(self.P, x)) / 2 + self.offset
        return total + inner(exact(self.q), x)


def exact(values: Any) -> Numbers:
    """Floats as they are, as balls of radius 0."""
    return [flint.arb(float(v)) for v in values]


def inner(x: Numbers, y: Numbers) -> Number:
    """The inner product."""
    total = flint.arb(0)
    for a, b in zip(x, y, strict=True):
        total += a * b
    return total


def row(A: Any, i: int) -> list[tuple[int, float]]:
    """Columns and values of one row of a csr_array."""
    part = slice(int(A.indptr[i]), int(A.indptr[i + 1]))
    return list(zip(A.indices[part].tolist(), A.data[part].tolist(), strict=True))


def times(A: Any, x: Numbers) -> Numbers:
    """A x for a csr_array and balls."""
    found = []
    for i in range(A.shape[0]):
        total = flint.arb(0)
        for j, value in row(A, i):
            total += x[j] * value
        found.append(total)
    return found
