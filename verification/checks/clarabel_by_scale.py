"""How CVXPY and Clarabel at default settings do when o, lambda2 and lambda3 are scaled together."""

from typing import Any

import numpy as np

from convexperc.problem.problem import Problem
from convexperc.solution.single import solve
from convexperc.solution.solution import Status
from verification.checks.raw import raw

SCALES = tuple(10.0**decade for decade in range(-8, 9, 2))
SHAPE, SIZES = (4, 12), (3, 4, 5)
LAMBDAS = (1.0, 0.5, 0.25)
LEVELS = {"share_off_1e-6": 1e-6, "share_off_1e-3": 1e-3}
"""Relative distances from the proved interval of F* that are counted."""


def series(per_scale: int, *, seed: int = 0, scales: tuple[float, ...] = SCALES) -> dict[str, Any]:
    """Count, by scale, the answers that are called optimal and are not, and those that are not called so.

    Parameters
    ----------
    per_scale : int
        Problems a scale; the same ones at every scale.
    seed : int
    scales : tuple of float
        Factors of o, lambda2 and lambda3; F* grows by their squares.

    Returns
    -------
    dict
        Lists as long as ``scales``: ``share_off_1e-6`` and ``share_off_1e-3`` of all problems whose status is
        "optimal" and whose value is outside the proved interval by more than that share of F*;
        ``share_not_optimal`` of all problems. ``per_scale`` counts the problems with a proved interval.
    """
    found: dict[str, list[Any]] = {"scales": list(scales), "per_scale": []}
    for name in (*LEVELS, "share_not_optimal"):
        found[name] = []
    for scale in scales:
        distances = [_distance(_problem(seed, index, scale)) for index in range(per_scale)]
        proved = [distance for distance in distances if distance is not None]
        found["per_scale"].append(len(proved))
        for name, level in LEVELS.items():
            found[name].append(_share([level < distance < np.inf for distance in proved]))
        found["share_not_optimal"].append(_share([distance == np.inf for distance in proved]))
    return found


def _share(hits: list[bool]) -> float:
    return sum(hits) / len(hits) if hits else 0.0


def _problem(seed: int, index: int, scale: float) -> Problem:
    """Normal X and o; a decimal scale rounds them, so that F* scales to rounding."""
    rng = np.random.default_rng([seed, index])
    X, o = rng.standard_normal(SHAPE), rng.standard_normal(SHAPE[1])
    one, two, three = LAMBDAS
    return Problem(X, scale * o, modalities=SIZES, lambda1=one, lambda2=scale * two, lambda3=scale * three)


def _distance(problem: Problem) -> float | None:
    """How far an "optimal" value is from the proved interval; infinite without one, None without proof."""
    solution, answer = solve(problem), raw(problem)
    if solution.status is Status.NOT_CERTIFIED:
        return None
    return (
        answer.distance(solution.certificate.lower, solution.certificate.upper) if answer.optimal else np.inf
    )
