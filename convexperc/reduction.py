"""Exact reduction from n + d unknowns to n + m, shared by all templates of a frame.

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
from jaxtyping import Float

from convexperc.arrays import Matrix, Vector
from convexperc.modalities import Modalities


@dataclass(frozen=True, eq=False)
class Reduction:
    """What all templates of one frame share.

    Attributes
    ----------
    X : float64 (n, d)
    modalities : Modalities
    K : float64 (m, n, n)
        K_i = X_i X_i'.
    G : float64 (n, n)
        X X' = sum_i K_i.
    """

    X: Matrix
    modalities: Modalities
    K: Float[np.ndarray, "m n n"]
    G: Float[np.ndarray, "n n"]

    @classmethod
    def of(cls, X: Matrix, modalities: Modalities) -> "Reduction":
        """One pass over X: m Gram matrices, O(n^2 d)."""
        n = X.shape[0]
        K = np.empty((len(modalities), n, n))
        for gram, columns in zip(K, modalities, strict=True):
            block = X[:, columns]
            np.matmul(block, block.T, out=gram)
        return cls(X, modalities, K, K.sum(axis=0))

    def recover(self, t: Float[np.ndarray, " m"], q: Vector) -> Float[np.ndarray, " d"]:
        """u^i = t_i X_i' q."""
        u = np.zeros(self.X.shape[1])
        for weight, columns in zip(t, self.modalities, strict=True):
            if weight > 0.0:
                u[columns] = weight * (self.X[:, columns].T @ q)
        return u
