"""How strongly F is convex in the view weights: H of `convexperc.solution.weights`, and its inverse."""

from dataclasses import dataclass
from typing import Any

import flint
import numpy as np
from numpy.typing import NDArray

from convexperc.certificate.rationals import LONGER, RowSpace, column
from convexperc.enclosure.balls import matrix_cost
from convexperc.enclosure.budget import Budget
from convexperc.enclosure.exact_data import null_projection
from convexperc.enclosure.reduced import ReducedBalls
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
    def of(cls, problem: Problem, reduced: ReducedBalls, P: list[int]) -> "Curvature | None":
        """Try H = G first, then the exact null space; None where the precision in force is not enough."""
        every, budget = np.ones(len(P), dtype=bool), reduced.budget
        inverse = _inverse(principal(reduced.G, P), budget)
        if inverse is not None:
            return cls(reduced.G, inverse, every)
        coupled = problem.lambda1 > 0.0
        space = RowSpace.within_limit(problem.X if coupled else problem.X[P])
        if space is None:
            raise RankUnknownError
        N = null_projection(space, budget)
        if N is None:
            return None
        if coupled:
            H = reduced.G + N * reduced.lambdas[0]
            inverse = _inverse(principal(H, P), budget)
            return None if inverse is None else cls(H, inverse, every)
        weight = max(reduced.G[j, j].upper() for j in P)
        inverse = _inverse(principal(reduced.G, P) + N * weight, budget)
        unique = np.array([N[k, k].contains(0) and _is_settled(space, k, budget) for k in range(len(P))])
        return None if inverse is None else cls(reduced.G, inverse, unique)


def _is_settled(space: RowSpace, k: int, budget: Budget) -> bool:
    """Whether every null vector is 0 at row k, exactly: the projection of the unit vector is 0."""
    budget.require(LONGER * space.work)
    unit = np.full(space.A.nrows(), 0, dtype=object)
    unit[k] = 1
    return not any(space.outside(column(unit)).entries())


def principal(A: Any, rows: list[int]) -> Any:
    """The principal submatrix."""
    return flint.arb_mat([[A[a, b] for b in rows] for a in rows])


def _inverse(A: Any, budget: Budget) -> Any:
    """The inverse, or None where it is not known to `ACCURATE` bits in the precision in force."""
    budget.require(matrix_cost(A.nrows() ** 3))
    try:
        inverse = A.inv()
    except ZeroDivisionError:
        return None
    accurate = all(inverse[k, k].rel_accuracy_bits() >= ACCURATE for k in range(A.nrows()))
    return inverse if accurate else None
