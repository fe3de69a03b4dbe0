"""How strongly F is convex in the view weights: the matrix H of `convexperc.solution.weights`, and its inverse."""

from dataclasses import dataclass
from typing import Any

import flint
import numpy as np
from numpy.typing import NDArray

from convexperc.certificate.rationals import RANK_LIMIT
from convexperc.enclosure.balls import BallFrame, left_null_space
from convexperc.problem.problem import Problem

ACCURATE = 8
"""Bits of each diagonal entry of an inverse that must be right."""


class RankUnknownError(Exception):
    """The rank of X is not proved: the exact computation would take too long."""


@dataclass(frozen=True, eq=False)
class Curvature:
    """F(w, u) - F* >= e'He for e = w - w*, over the views P that may differ from 0 at an optimum.

    Attributes
    ----------
    H : arb_mat (n, n)
    inverse : arb_mat (k, k)
        Of H_PP, or of H_PP plus what does not change e'He for the views that are unique.
    unique : bool (k,)
        Whether every null vector of H_PP is 0 at the view.
    """

    H: Any
    inverse: Any
    unique: NDArray[np.bool_]

    @classmethod
    def of(cls, problem: Problem, frame: BallFrame, P: list[int]) -> "Curvature | None":
        """Try H = G first, then the exact null space; None where the precision in force is not enough."""
        every = np.ones(len(P), dtype=bool)
        inverse = _inverse(principal(frame.G, P))
        if inverse is not None:
            return cls(frame.G, inverse, every)
        if problem.n * problem.n * problem.d > RANK_LIMIT:
            raise RankUnknownError
        if problem.lambda1 > 0.0:
            basis, _ = left_null_space(problem.X)
            H = frame.G if basis is None else frame.G + projection(basis) * frame.lambdas[0]
            inverse = _inverse(principal(H, P))
            return None if inverse is None else cls(H, inverse, every)
        basis, _ = left_null_space(problem.X[P])
        if basis is None:
            return None
        weight = max(frame.G[j, j].upper() for j in P)
        inverse = _inverse(principal(frame.G, P) + basis * basis.transpose() * weight)
        unique = np.array([all(v == 0 for v in row) for row in basis.tolist()])
        return None if inverse is None else cls(frame.G, inverse, unique)


def projection(basis: Any) -> Any:
    """The orthogonal projection onto the span of the columns."""
    return basis * (basis.transpose() * basis).inv() * basis.transpose()


def principal(A: Any, rows: list[int]) -> Any:
    """The principal submatrix."""
    return flint.arb_mat([[A[a, b] for b in rows] for a in rows])


def _inverse(A: Any) -> Any:
    """The inverse, or None where it is not known to `ACCURATE` bits in the precision in force."""
    try:
        inverse = A.inv()
    except ZeroDivisionError:
        return None
    accurate = all(inverse[k, k].rel_accuracy_bits() >= ACCURATE for k in range(A.nrows()))
    return inverse if accurate else None
