"""Exact reduction from n + d unknowns to n + m, shared by all templates of a set of views.

u^i matters only through X_i u^i and ||u^i||, so the best u^i lies in the row space of X_i. Eliminating u,
with K_i = X_i X_i', G = sum_i K_i, c = X o and t_i = 2 ||u^i|| / lambda3, leaves

    min over w, t >= 0:  w'Gw - 2 c'w + lambda2 ||w||_1 + w' S(t)^-1 w + (lambda3^2 / 4) sum_i t_i + ||o||^2,
    S(t) = I / lambda1 + sum_i t_i K_i,

which is jointly convex. With q = S(t)^-1 w:  u^i = t_i X_i' q,  Xu - w = -q / lambda1,  b = -2 q.

Source: lambda3 ||u^i|| = min over tau > 0 of (lambda3 / 2)(||u^i||^2 / tau + tau), with t = 2 tau / lambda3
(Bach, Jenatton, Mairal and Obozinski, Optimization with Sparsity-Inducing Penalties, 2012, section 1.4.2).
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from convexperc.problem.arrays import Matrix, Vector
from convexperc.problem.modalities import Columns, Modalities

Rows = slice | Int[np.ndarray, " k"]
"""Some of the views."""
EVERY = slice(None)
CHUNK = 4096
"""Columns that are multiplied at a time: a product's rounding grows with the length of its sums."""


@dataclass(frozen=True, eq=False)
class Reduction:
    """What all templates of one set of views share.

    Attributes
    ----------
    X : float64 (n, d)
    modalities : Modalities
    K : float64 (m, n, n)
        K_i = X_i X_i'.
    G : float64 (n, n)
        X X' = sum_i K_i.
    depth : int
        Roundings in a row behind an entry of K, of G, of a `product`, or of `squares`: its error is at most
        gamma_depth times the lengths of the two vectors.
    """

    X: Matrix
    modalities: Modalities
    K: Float[np.ndarray, "m n n"]
    G: Float[np.ndarray, "n n"]
    depth: int

    @classmethod
    def of(cls, X: Matrix, modalities: Modalities) -> "Reduction":
        """One pass over X: m Gram matrices, O(n^2 d) (Lemma R24); infinite where they overflow."""
        n, d = X.shape
        K = np.empty((len(modalities), n, n))
        with np.errstate(over="ignore", invalid="ignore"):
            for gram, columns in zip(K, modalities, strict=True):
                first, *others = _chunks(columns, d)
                block = X[:, first]
                np.matmul(block, block.T, out=gram)
                for part in others:
                    block = X[:, part]
                    np.add(gram, block @ block.T, out=gram)
            G = K.sum(axis=0)
        return cls(X, modalities, K, G, min(d, CHUNK) + -(-d // CHUNK) + 2 * len(modalities))

    def replaced(self, X: Matrix, rows: Int[np.ndarray, " k"]) -> "Reduction":
        """The reduction of views of which only these rows are new: O(n d) a row (Lemma R24)."""
        K = self.K.copy()
        with np.errstate(over="ignore", invalid="ignore"):
            for gram, columns in zip(K, self.modalities, strict=True):
                parts = [X[:, part] for part in _chunks(columns, X.shape[1])]
                for row in rows:
                    found = parts[0] @ parts[0][row]
                    for block in parts[1:]:
                        found += block @ block[row]
                    gram[row], gram[:, row] = found, found
            G = K.sum(axis=0)
        return Reduction(X, self.modalities, K, G, self.depth)

    def product(self, O: Float[np.ndarray, "d p"], rows: Rows = EVERY) -> Float[np.ndarray, "p k"]:  # noqa: E741
        """Row j is X o_j, of which only some entries may be asked for."""
        X, d = self.X[rows], self.X.shape[1]
        found = X[:, :CHUNK] @ O[:CHUNK]
        for start in range(CHUNK, d, CHUNK):
            found += X[:, start : start + CHUNK] @ O[start : start + CHUNK]
        return np.ascontiguousarray(found.T)

    def recover(self, t: Float[np.ndarray, " m"], q: Vector) -> Float[np.ndarray, " d"]:
        """u^i = t_i X_i' q; infinite or NaN where t overflowed."""
        u = np.zeros(self.X.shape[1])
        with np.errstate(over="ignore", invalid="ignore"):
            for weight, columns in zip(t, self.modalities, strict=True):
                if weight > 0.0:
                    u[columns] = weight * (self.X[:, columns].T @ q)
        return u


def _chunks(columns: Columns, d: int) -> list[Columns]:
    """The columns of one modality, at most `CHUNK` at a time."""
    if isinstance(columns, slice):
        start, stop, _ = columns.indices(d)
        if stop - start <= CHUNK:
            return [columns]
        return [slice(first, min(first + CHUNK, stop)) for first in range(start, stop, CHUNK)]
    return [columns[first : first + CHUNK] for first in range(0, columns.size, CHUNK)]
