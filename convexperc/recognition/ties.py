"""Ties by construction: two templates whose problems are the same but for the names of rows and columns.

A permutation of the robots, of the columns within a modality, or of modalities among themselves leaves F*
unchanged, so that no effort could tell such templates apart.
"""

from collections.abc import Iterator, Sequence
from itertools import permutations

import numpy as np

from convexperc.problem.arrays import FeatureVector, Matrix, Vector
from convexperc.problem.modalities import Modalities

MOST_ROBOTS = 6
"""Robots are permuted only up to this many: 720 ways."""
PRODUCT_SLACK = 1e-9
"""An order of the robots is left out where it makes another X o: by more than this share of the sum of the
absolute products, far beyond rounding."""


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
    nothing = np.empty((0, first.size))
    if _signature(nothing, modalities, first) != _signature(nothing, modalities, second):
        return False
    wanted = _signature(X, modalities, second)
    return any(_signature(X[order], modalities, first) == wanted for order in _orders(X, first, second))


def all_interchangeable(
    X: Matrix, modalities: Modalities, first: FeatureVector, others: Sequence[FeatureVector]
) -> bool:
    """Whether each of the others is `interchangeable` with the first; equal ones are looked at once."""
    different = {other.tobytes(): other for other in others}
    return all(interchangeable(X, modalities, first, other) for other in different.values())


def _orders(X: Matrix, first: FeatureVector, second: FeatureVector) -> Iterator[list[int]]:
    """The orders of the rows that carry X first into X second, which permuted columns leave as they are."""
    n = X.shape[0]
    with np.errstate(all="ignore"):
        before, after = X @ first, X @ second
        slack = PRODUCT_SLACK * (np.abs(X) @ np.abs(second))
    for order in permutations(range(n)) if n <= MOST_ROBOTS else iter([tuple(range(n))]):
        if not _apart(before[list(order)], after, slack):
            yield list(order)


def _apart(before: Vector, after: Vector, slack: Vector) -> bool:
    """Whether two products differ by more than rounding; false where they are not finite."""
    with np.errstate(all="ignore"):
        return bool((np.abs(before - after) > slack).any())


def _signature(X: Matrix, modalities: Modalities, o: FeatureVector) -> list[tuple[int, bytes]]:
    """The columns of each modality, sorted, and the modalities, sorted."""
    parts = []
    for columns in modalities:
        block = np.vstack([X[:, columns], o[columns]]) + 0.0
        parts.append((block.shape[1], block[:, np.lexsort(block)].tobytes()))
    return sorted(parts)
