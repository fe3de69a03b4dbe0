"""A diagonal below P: D with P - diag(D) positive semidefinite, proved for the floats of P as they are.

With an orthogonal V from a float64 eigenvalue decomposition of a block B of P, any s, and
L = V sqrt(max(eigenvalues - s, 0)),

    B = s I + L L' + E,    so that the least eigenvalue of B is at least s - max_i sum_j |E_ij|,

whatever V and the eigenvalues are worth; E is computed in ball arithmetic. Where that ends just below 0,
an exact decomposition of small blocks decides whether B is positive semidefinite.
"""

from typing import Any

import flint
import numpy as np
from scipy.sparse.csgraph import connected_components

from convexperc.conic.program import Floats, NoBoundError
from convexperc.enclosure.balls import exact_matrix, float_below

LARGEST_BLOCK = 300
"""Variables that P may couple: a product of two matrices of balls of this size takes a second."""
LARGEST_EXACT = 24
"""Variables of a block that is decomposed in rationals, whose length doubles with each step or so."""
KEPT = 1.0 - 2.0**-20
"""Share of the least eigenvalue that is aimed at, so that E costs little of it."""
NEGLIGIBLE = 2.0**-36
"""Least eigenvalues below this share of the largest are taken for 0."""


def curvature(P: Any) -> Floats:
    """Return D (n,) such that x'Px >= sum D_j x_j^2 for every x; an entry may be negative.

    Parameters
    ----------
    P : csr_array (n, n)
        Symmetric.

    Raises
    ------
    NoBoundError
        P couples more than 300 variables with each other.
    """
    below = np.array(P.diagonal(), dtype=np.float64)
    _, labels = connected_components(P, directed=False)
    for label in np.flatnonzero(np.bincount(labels) > 1):
        block = np.flatnonzero(labels == label)
        if block.size > LARGEST_BLOCK:
            raise NoBoundError(
                f"the quadratic objective couples {block.size} variables, more than {LARGEST_BLOCK}"
            )
        below[block] = _least_eigenvalue(P[block][:, block].toarray())
    return below


def _least_eigenvalue(B: np.ndarray) -> float:
    """A lower bound of it."""
    values, V = np.linalg.eigh(B)
    s = float(values[0]) * KEPT if values[0] > NEGLIGIBLE * values[-1] else 0.0
    L = exact_matrix(V * np.sqrt(np.maximum(values - s, 0.0)))
    E = exact_matrix(B) - L * L.transpose() - flint.arb_mat(len(B), len(B), s)
    error = max(
        sum((abs(E[i, j]).upper() for j in range(len(B))), flint.arb(0)).upper() for i in range(len(B))
    )
    found = float_below(flint.arb(s) - error)
    if found < 0.0 and len(B) <= LARGEST_EXACT and is_positive_semidefinite(B):
        return 0.0
    return found


def is_positive_semidefinite(B: np.ndarray) -> bool:
    """Whether the symmetric matrix of these floats is, decided exactly by elimination."""
    n = len(B)
    M = [[_rational(B[i, j]) for j in range(n)] for i in range(n)]
    left = list(range(n))
    while left:
        pivot = next((i for i in left if M[i][i] != 0), None)
        if pivot is None:
            return all(M[i][j] == 0 for i in left for j in left)
        if M[pivot][pivot] < 0:
            return False
        left.remove(pivot)
        for i in left:
            factor = M[i][pivot] / M[pivot][pivot]
            for j in left:
                M[i][j] -= factor * M[pivot][j]
    return True


def _rational(value: float) -> Any:
    numerator, denominator = float(value).as_integer_ratio()
    return flint.fmpq(numerator, denominator)
