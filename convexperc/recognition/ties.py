"""Ties by construction: two templates whose problems are the same but for the names of rows and columns.

A permutation of the robots, of the columns within a modality, or of modalities among themselves leaves F*
unchanged, so that no effort could tell such templates apart.
"""

from itertools import permutations

import numpy as np

from convexperc.problem.arrays import FeatureVector, Matrix
from convexperc.problem.modalities import Modalities

MOST_ROBOTS = 6
"""Robots are permuted only up to this many: 720 ways."""


def interchangeable(X: Matrix, modalities: Modalities, first: FeatureVector, second: FeatureVector) -> bool:
    """Whether a permutation carries (X, first) into (X, second), so that both have the same F* exactly.

    Permutations of more than `MOST_ROBOTS` rows are not tried.

    Parameters
    ----------
    X : float64 (n, d)
    modalities : Modalities
    first, second : float64 (d,)

    Returns
    -------
    bool
    """
    if np.array_equal(first, second):
        return True
    if _signature(np.empty((0, first.size)), modalities, first) != _signature(
        np.empty((0, first.size)), modalities, second
    ):
        return False
    n = X.shape[0]
    wanted = _signature(X, modalities, second)
    orders = permutations(range(n)) if n <= MOST_ROBOTS else iter([tuple(range(n))])
    return any(_signature(X[list(order)], modalities, first) == wanted for order in orders)


def _signature(X: Matrix, modalities: Modalities, o: FeatureVector) -> list[tuple[int, bytes]]:
    """The columns of each modality, sorted, and the modalities, sorted."""
    parts = []
    for columns in modalities:
        block = np.vstack([X[:, columns], o[columns]]) + 0.0
        parts.append((block.shape[1], block[:, np.lexsort(block)].tobytes()))
    return sorted(parts)
