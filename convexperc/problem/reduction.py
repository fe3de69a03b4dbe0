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

from convexperc.problem.arrays import FeatureVector, Matrix, Vector
from convexperc.problem.modalities import CHUNK, Modalities

Rows = slice | Int[np.ndarray, " k"]
"""Some of the views."""
EVERY = slice(None)


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
        """One pass over X: m Gram matrices, O(n^2 d) (Lemma R24).

        They are infinite where they overflow, of which NumPy warns unless it is told not to.
        """
        n, d = X.shape
        K = np.empty((len(modalities), n, n))
        for gram, (first, *others) in zip(K, modalities.chunks, strict=True):
            block = X[:, first]
            np.matmul(block, block.T, out=gram)
            for part in others:
                block = X[:, part]
                np.add(gram, block @ block.T, out=gram)
        G = np.add.reduce(K, axis=0)
        return cls(X, modalities, K, G, min(d, CHUNK) + -(-d // CHUNK) + 2 * len(modalities))

    def replaced(self, X: Matrix, rows: Int[np.ndarray, " k"]) -> "Reduction":
        """The reduction of views of which only these rows are new: O(n d) a row (Lemma R24); see `of`."""
        K = self.K.copy()
        for gram, chunks in zip(K, self.modalities.chunks, strict=True):
            parts = [X[:, part] for part in chunks]
            for row in rows:
                found = parts[0] @ parts[0][row]
                for block in parts[1:]:
                    found += block @ block[row]
                gram[row], gram[:, row] = found, found
        return Reduction(X, self.modalities, K, np.add.reduce(K, axis=0), self.depth)

    def alone(self, i: int) -> "Reduction":
        """The reduction of one of the views (Lemma R24); see `of`."""
        chosen = slice(i, i + 1)
        return Reduction(
            self.X[chosen], self.modalities, self.K[:, chosen, chosen], self.G[chosen, chosen], self.depth
        )

    def product(self, O: Float[np.ndarray, "d p"], rows: Rows = EVERY) -> Float[np.ndarray, "p k"]:  # noqa: E741
        """Row j is X o_j, of which only some entries may be asked for."""
        X, d = self.X[rows], self.X.shape[1]
        found = X[:, :CHUNK] @ O[:CHUNK]
        for start in range(CHUNK, d, CHUNK):
            found += X[:, start : start + CHUNK] @ O[start : start + CHUNK]
        return np.ascontiguousarray(found.T)

    def recover(self, t: Float[np.ndarray, " m"], q: Vector, unit: float = 1.0) -> FeatureVector:
        """u^i = t_i X_i' q, times a power of two; infinite or NaN where t overflowed."""
        with np.errstate(over="ignore", invalid="ignore"):
            u: FeatureVector = q @ self.X
            for weight, columns in zip(t.tolist(), self.modalities, strict=True):
                if weight > 0.0:
                    u[columns] *= weight * unit
                else:
                    u[columns] = 0.0
        return u
