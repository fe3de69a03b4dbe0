"""S1: what CVXPY and Clarabel at default settings, called as users call them, say of F*.

One call, its comparison with a proved interval, and three ways to count: the check S1, a tally for many
problems, and a series over scales for the plot.
"""

import math
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import cvxpy as cp
import numpy as np

from convexperc.problem.problem import Problem
from convexperc.solution import single as solving
from convexperc.solution.solution import Status
from verification.checks.interface import Check, Observation
from verification.checks.measures import LARGEST_MEASURE, add_fields
from verification.ledger.evidence import Outcome
from verification.problems.sources import Source

PART = "S1/optimal"
ALLOWED = 1e-6
"""Relative distance that S1 allows: a hundred times Clarabel's own tolerance of 1e-8."""
ABOVE = {"above_1e_8": 1e-8, "above_1e_6": 1e-6, "above_1e_3": 1e-3}
"""Relative distances that a `Tally` counts."""
SHARES = {"share_off_1e-6": 1e-6, "share_off_1e-3": 1e-3}
"""Relative distances that `by_scale` counts."""

SCALES = tuple(10.0**decade for decade in range(-8, 9, 2))
SHAPE, SIZES = (4, 12), (3, 4, 5)
LAMBDAS = (1.0, 0.5, 0.25)


@dataclass(frozen=True)
class Answer:
    """What came back.

    Attributes
    ----------
    status : str
        CVXPY's status, or the exception's name.
    value : float or None
        CVXPY's optimal value, if it is a finite number.
    """

    status: str
    value: float | None

    @property
    def optimal(self) -> bool:
        """Whether CVXPY claims an optimum without reservation."""
        return self.status == cp.OPTIMAL and self.value is not None

    @property
    def inaccurate(self) -> bool:
        """Whether CVXPY claims an optimum that may be inaccurate."""
        return self.status == cp.OPTIMAL_INACCURATE and self.value is not None

    def distance(self, lower: float, upper: float) -> float:
        """How far the value lies outside [lower, upper], relative to F*; 0 inside, infinite from F* = 0."""
        if self.value is None or lower <= self.value <= upper:
            return 0.0
        bound = upper if self.value > upper else lower
        away = abs(self.value - bound)
        return away / bound if bound > 0.0 else math.inf


def solve_directly(problem: Problem) -> Answer:
    """Pose Eq. (full) in CVXPY as it is printed and solve it; every failure is a status."""
    w, u = cp.Variable(problem.n), cp.Variable(problem.d)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            objective = (
                cp.sum_squares(problem.X.T @ w - problem.o)
                + problem.lambda1 * cp.sum_squares(problem.X @ u - w)
                + problem.lambda2 * cp.norm1(w)
                + problem.lambda3 * sum(cp.norm2(u[columns]) for columns in problem.modalities)
            )
            posed = cp.Problem(cp.Minimize(objective))
            posed.solve(solver=cp.CLARABEL)
    except Exception as failure:
        return Answer(type(failure).__name__, None)
    value = None if posed.value is None else float(posed.value)
    return Answer(str(posed.status), value if value is not None and math.isfinite(value) else None)


def observe(problem: Problem, source: Source) -> Iterator[Observation]:
    """Solve directly and compare the value with the proved interval."""
    answer = solve_directly(problem)
    if not answer.optimal:
        yield Observation(PART, Outcome.SKIPPED, detail=f'Clarabel says "{answer.status}", not "optimal"')
        return
    solution = solving.solve(problem)
    proof = solution.certificate
    if solution.status is Status.NOT_CERTIFIED:
        yield Observation(PART, Outcome.UNDECIDED, detail="no certified interval")
        return
    if proof.lower == 0.0:
        yield Observation(PART, Outcome.SKIPPED, detail="F* may be 0: no distance is relative to it")
        return
    away = answer.distance(proof.lower, proof.upper)
    detail = f'"optimal" {answer.value!r}, F* in [{proof.lower!r}, {proof.upper!r}]'
    yield Observation.of(PART, away <= ALLOWED, min(away, LARGEST_MEASURE), detail)


CHECKS = (Check("clarabel", (PART,), observe, share=0.1),)


@dataclass
class Tally:
    """Answers to some problems of one family.

    Attributes
    ----------
    total, optimal, inaccurate, failed : int
        Problems; those with status "optimal"; "optimal_inaccurate"; anything else.
    outside : int
        Status "optimal", but a value outside the proved interval [lower, upper] of F*.
    above_1e_8, above_1e_6, above_1e_3 : int
        Those of them outside by more than this share of F*.
    worst : float
        Largest such share; infinite where F* = 0.
    """

    total: int = 0
    optimal: int = 0
    inaccurate: int = 0
    failed: int = 0
    outside: int = 0
    above_1e_8: int = 0
    above_1e_6: int = 0
    above_1e_3: int = 0
    worst: float = 0.0

    def count(self, answer: Answer, lower: float, upper: float) -> None:
        """Count one answer against the proved interval."""
        distance = answer.distance(lower, upper) if answer.optimal else 0.0
        above = {name: int(distance > level) for name, level in ABOVE.items()}
        failed = not (answer.optimal or answer.inaccurate)
        claims = int(answer.optimal), int(answer.inaccurate), int(failed)
        self.add(Tally(1, *claims, int(distance > 0.0), **above, worst=distance))

    def add(self, other: "Tally") -> None:
        """Add the counts of other problems."""
        worst = max(self.worst, other.worst)
        add_fields(self, other)
        self.worst = worst


def by_scale(per_scale: int, *, seed: int = 0, scales: tuple[float, ...] = SCALES) -> dict[str, Any]:
    """Count the answers that are called optimal and are not, and those not called so, by the scale of F.

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
    for name in (*SHARES, "share_not_optimal"):
        found[name] = []
    for scale in scales:
        distances = [_distance(_scaled(seed, index, scale)) for index in range(per_scale)]
        proved = [distance for distance in distances if distance is not None]
        found["per_scale"].append(len(proved))
        for name, level in SHARES.items():
            found[name].append(_share([level < distance < np.inf for distance in proved]))
        found["share_not_optimal"].append(_share([distance == np.inf for distance in proved]))
    return found


def _share(hits: list[bool]) -> float:
    return sum(hits) / len(hits) if hits else 0.0


def _scaled(seed: int, index: int, scale: float) -> Problem:
    """Normal X and o; a decimal scale rounds them, so that F* scales to rounding."""
    rng = np.random.default_rng([seed, index])
    X, o = rng.standard_normal(SHAPE), rng.standard_normal(SHAPE[1])
    one, two, three = LAMBDAS
    return Problem(X, scale * o, modalities=SIZES, lambda1=one, lambda2=scale * two, lambda3=scale * three)


def _distance(problem: Problem) -> float | None:
    """How far an "optimal" value is from the proved interval; infinite without one, None without proof."""
    solution, answer = solving.solve(problem), solve_directly(problem)
    if solution.status is Status.NOT_CERTIFIED:
        return None
    proof = solution.certificate
    return answer.distance(proof.lower, proof.upper) if answer.optimal else math.inf
