"""S1 by cases: what CVXPY and Clarabel at default settings call optimal, against the proved interval."""

from collections.abc import Iterator

from convexperc.problem.problem import Problem
from convexperc.solution import single as solving
from convexperc.solution.solution import Status
from verification.checks import raw
from verification.checks.interface import Check, Observation
from verification.checks.measures import LARGEST_MEASURE
from verification.ledger.evidence import Outcome
from verification.problems.sources import Source

PART = "S1/optimal"
CLOSE = 1e-6
"""A hundred times Clarabel's own tolerance of 1e-8."""


def observe(problem: Problem, source: Source) -> Iterator[Observation]:
    """Pose Eq. (full) in CVXPY as it is, solve it, and compare the value."""
    answer = raw.raw(problem)
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
    yield Observation.of(PART, away <= CLOSE, min(away, LARGEST_MEASURE), detail)


CHECKS = (Check("clarabel", (PART,), observe, share=0.1),)
