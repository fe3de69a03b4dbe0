"""lambda_max: the smallest lambda2 at which w = 0, and the smallest lambda3 at which u = 0, is optimal."""

import math
from collections.abc import Callable
from typing import Protocol

import numpy as np

from convexperc.certificate.arithmetic import broken_assumption
from convexperc.certificate.evaluation import NormalizedData
from convexperc.certificate.rounding import down, up
from convexperc.problem.arrays import Vector
from convexperc.problem.problem import Problem
from convexperc.problem.scaling import Bounds, Scaling


class Point(Protocol):
    """An answer to a problem."""

    @property
    def w(self) -> Vector:
        """View weights, shape (n,)."""


def lambda2_max(problem: Problem) -> Bounds:
    """Enclose the smallest lambda2 for which w = 0, u = 0 is optimal: 2 ||X o||_inf (Lemma R39).

    Parameters
    ----------
    problem : Problem
        Its own lambdas do not matter.

    Returns
    -------
    (float, float)
        Lower and upper bound, rounding included; 0 and infinity where the arithmetic is not as assumed.

    Notes
    -----
    At (0, 0) the dual point is a = -2o, b = 0, which is feasible exactly for lambda2 >= 2 ||X o||_inf.
    """
    if broken_assumption():
        return 0.0, math.inf
    scaling = Scaling.of(problem)
    data = NormalizedData.of(problem, scaling)
    found = data.times_rows(data.target)
    upper = float(np.max(found.magnitude()))
    lower = float(np.max(np.abs(found.mid) - found.rad))
    return scaling.gradient_back((max(0.0, down(2.0 * lower)), up(2.0 * upper) if upper else 0.0))


def zero_is_optimal(problem: Problem) -> bool:
    """Whether w = 0, u = 0 is proved to be an optimum, that is, F* = ||o||^2."""
    return problem.lambda2 >= lambda2_max(problem)[1]


def lambda3_max(problem: Problem, solve: Callable[[Problem], Point]) -> float:
    """Find the smallest lambda3 for which u = 0 is optimal, at the given lambda1 and lambda2.

    Formula: 2 lambda1 max_i ||X_i' w||, where w minimises ||X'w - o||^2 + lambda1 ||w||^2 + lambda2 ||w||_1,
    found by solving the problem with a lambda3 so large that u = 0 for sure:
    ||b*|| <= 2 sqrt(lambda1) ||o|| at every optimum, so ||X_i'b*|| <= 2 sqrt(lambda1) ||o|| ||X_i||_F, on
    normalised data.

    Parameters
    ----------
    problem : Problem
        Its own lambda3 does not matter.
    solve : callable
        Takes a Problem, returns its answer, such as a `Solution`.

    Returns
    -------
    float
        As accurate as the solution's w.
    """
    if problem.lambda1 == 0.0:
        return 0.0
    scaling = Scaling.of(problem)
    normal = scaling.normalise(problem)
    one, two = normal.lambda1, normal.lambda2
    large = 8.0 * math.sqrt(one) * problem.d * problem.n
    without_u = Problem(
        normal.X, normal.o, modalities=normal.modalities, lambda1=one, lambda2=two, lambda3=large
    )
    w = solve(without_u).w
    found = 2.0 * one * max(float(np.linalg.norm(block.T @ w)) for block in normal.blocks())
    return math.ldexp(found, 2 * scaling.x + scaling.o)


critical_lambda2, critical_lambda3 = lambda2_max, lambda3_max
"""The names until version 0.2."""
