"""X, dense or sparse: the few products that bounds need of it.

Every result is that of float64 arithmetic in some order of summation; what that may lose is charged by the
caller, or here where the result is a `Ball` or called a bound.
"""

from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float
from numpy.typing import NDArray

from convexperc.certificate.rounding import UNDERFLOW, Ball, U, gamma, product
from convexperc.errors import ProblemError
from convexperc.problem.arrays import Matrix, Vector, real_array, row_blocks, times_power_of_two
from convexperc.problem.conversion import real_source

MUST = "must be an array or a sparse matrix of real numbers, a row for each sample, a column for each feature"


@runtime_checkable
class Design(Protocol):
    """X with n rows and p columns."""

    @property
    def shape(self) -> tuple[int, int]:
        """(n, p)."""

    def largest(self) -> float:
        """The largest absolute value of an entry."""

    def scaled(self, exponent: int) -> "Design":
        """X * 2^exponent; what underflows is off by at most 2^-1074."""

    def kept(self, rows: NDArray[np.bool_]) -> "Design":
        """Some of the rows."""

    def columns(self, which: NDArray[np.int64]) -> Matrix:
        """Some of the columns, as a dense matrix."""

    def squares(self, weights: Vector | None) -> Float[np.ndarray, " p"]:
        """The sum of weights_i x_ij^2 for each column, in at most n + 4 roundings."""

    def pulls(self, t: Vector) -> Float[np.ndarray, " p"]:
        """X't, in at most n roundings."""

    def fitted(self, used: NDArray[np.int64], b: Ball, entry_error: float) -> Ball:
        """X b for a b with these entries, all others 0; each entry of X is off by at most `entry_error`."""


@dataclass(frozen=True, eq=False)
class DenseDesign:
    """X as a NumPy array."""

    X: Matrix

    @property
    def shape(self) -> tuple[int, int]:
        """(n, p)."""
        return self.X.shape[0], self.X.shape[1]

    def largest(self) -> float:
        """See `Design`."""
        return max(float(self.X.max()), -float(self.X.min()))

    def scaled(self, exponent: int) -> Design:
        """See `Design`."""
        return DenseDesign(times_power_of_two(self.X, exponent)) if exponent else self

    def kept(self, rows: NDArray[np.bool_]) -> Design:
        """See `Design`."""
        return DenseDesign(self.X[rows])

    def columns(self, which: NDArray[np.int64]) -> Matrix:
        """See `Design`."""
        return self.X[:, which]

    def squares(self, weights: Vector | None) -> Float[np.ndarray, " p"]:
        """See `Design`."""
        if weights is None:
            return np.asarray(np.einsum("ij,ij->j", self.X, self.X))
        total = np.zeros(self.shape[1])
        for part in row_blocks(self.X):
            total += weights[part] @ (self.X[part] * self.X[part])
        return total

    def pulls(self, t: Vector) -> Float[np.ndarray, " p"]:
        """See `Design`."""
        return np.asarray(t @ self.X)

    def fitted(self, used: NDArray[np.int64], b: Ball, entry_error: float) -> Ball:
        """See `Design`."""
        return product(self.X if used.size == self.shape[1] else self.X[:, used], b, entry_error)


@dataclass(frozen=True, eq=False)
class SparseDesign:
    """X as SciPy's compressed columns, each entry once; it is never made dense."""

    X: Any

    @classmethod
    def of(cls, X: Any) -> "SparseDesign":
        """From any sparse matrix or array of SciPy.

        Raises
        ------
        ProblemError
            Entries that are stored in several parts, which only a rounded sum would join; or that are not
            finite real numbers.
        """
        columns = X.tocsc()
        if not columns.has_sorted_indices:
            columns = columns.sorted_indices()
        parts = getattr(X, "format", "") == "coo" and columns.nnz != X.nnz
        if parts or not columns.has_canonical_format:
            must, remedy = "must store each entry once", "Call its sum_duplicates first: that rounds."
            raise ProblemError("X", value=type(X).__name__, must=must, remedy=remedy)
        data = real_array(columns.data, "X.data", 1)
        return cls(type(columns)((data, columns.indices, columns.indptr), shape=columns.shape))

    @property
    def shape(self) -> tuple[int, int]:
        """(n, p)."""
        n, p = self.X.shape
        return int(n), int(p)

    def _with(self, data: Vector) -> Any:
        return type(self.X)((data, self.X.indices, self.X.indptr), shape=self.X.shape)

    def largest(self) -> float:
        """See `Design`."""
        return float(np.abs(self.X.data).max(initial=0.0))

    def scaled(self, exponent: int) -> Design:
        """See `Design`."""
        return SparseDesign(self._with(times_power_of_two(self.X.data, exponent))) if exponent else self

    def kept(self, rows: NDArray[np.bool_]) -> Design:
        """See `Design`."""
        return SparseDesign(self.X[np.flatnonzero(rows)])

    def columns(self, which: NDArray[np.int64]) -> Matrix:
        """See `Design`."""
        return np.asarray(self.X[:, which].toarray())

    def squares(self, weights: Vector | None) -> Float[np.ndarray, " p"]:
        """See `Design`."""
        squares = self.X.data * self.X.data
        if weights is not None:
            squares = squares * weights[self.X.indices]
        column = np.repeat(np.arange(self.shape[1]), np.diff(self.X.indptr))
        return np.bincount(column, weights=squares, minlength=self.shape[1])

    def pulls(self, t: Vector) -> Float[np.ndarray, " p"]:
        """See `Design`."""
        return np.asarray(self.X.T @ t)

    def fitted(self, used: NDArray[np.int64], b: Ball, entry_error: float) -> Ball:
        """See `Design`; the error is that of `product` (Lemma R7), as zeros add nothing to it."""
        part = self.X[:, used]
        k, size = used.size, np.abs(b.mid)
        sizes, radii = float(size.sum()), float(b.rad.sum())
        rad = gamma(k + 1) * (abs(part) @ size) + abs(part) @ b.rad
        outside = (UNDERFLOW + entry_error) * (k + sizes + radii)
        return Ball(np.asarray(part @ b.mid), (rad + outside) * (1.0 + 4 * (k + 8) * U))


def design_of(X: Any) -> Design:
    """X as it is given, checked; float64 data are not copied.

    Raises
    ------
    ProblemError
        No matrix of finite real numbers, or one without entries.
    """
    if hasattr(X, "tocsc"):
        if len(X.shape) != 2 or 0 in X.shape:
            raise ProblemError("X", value=X.shape, must=MUST)
        return SparseDesign.of(X)
    source = real_source(X, "X", ProblemError)
    if source.ndim != 2 or 0 in source.shape:
        raise ProblemError("X", value=source.shape, must=MUST)
    if source.dtype == np.float64 and np.isfinite(source).all():
        return DenseDesign(source)
    return DenseDesign(real_array(source, "X", 2))  # converts it, or says which entry is not finite
