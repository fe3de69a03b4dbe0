"""The solvers on many problems: how many are certified, which are not and why, and is any proof false.

The cases are taken in chunks, each a sample of the whole, and counted where they are solved. What the first
chunks found can be saved and continued: the outcome does not depend on where a run was broken.
"""

import multiprocessing
import time
import traceback
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Any

from convexperc.errors import SolverError
from convexperc.problem.problem import Problem
from convexperc.solution.single import solve
from convexperc.solution.solution import Solution, Status
from convexperc.solvers.interface import Solver
from convexperc.solvers.newton.method import Newton
from verification.checks.raw import raw
from verification.exact.formulation import objective
from verification.exact.referee import Optimum, optimum, violations
from verification.problems.families import EXTREME
from verification.search.campaign.cases import Case
from verification.search.campaign.tallies import Contradiction, Failure, Reason, Report

CHUNK = 100
"""Cases that a worker takes at a time."""
RARER = 5
"""See `Rules.referee_every`."""
AHEAD = 8
"""Chunks a worker that may wait to be counted, for the slow ones among them."""


@dataclass(frozen=True)
class Rules:
    """How each case is treated.

    Attributes
    ----------
    solver : Solver
    escalate : bool
        Answer by ball arithmetic where the solver's answer is not certified; an enclosed optimum then is
        no failure.
    referee_every : int
        Of each family, every how many cases the exact referee also judges a certified answer; 0 for
        never. Of an `EXTREME` family it takes `RARER` times fewer: entries that span 1e300 need 900 digits.
        It judges every answer that is not certified.
    raw_every : int
        Of each family, every how many cases are also given to raw CVXPY + Clarabel; 0 for never.
    """

    solver: Solver = field(default_factory=Newton)
    escalate: bool = False
    referee_every: int = 0
    raw_every: int = 0

    def referees(self, case: Case) -> bool:
        """Whether the referee judges this case in any event."""
        every = self.referee_every * (RARER if case.family in EXTREME else 1)
        return every > 0 and case.index % every == 0

    def asks_raw(self, case: Case) -> bool:
        """Whether this case is given to raw CVXPY + Clarabel."""
        return self.raw_every > 0 and case.index % self.raw_every == 0


@dataclass
class State:
    """What the first `done` of all `chunks` found."""

    chunks: int
    done: int = 0
    report: Report = field(default_factory=Report)

    def as_json(self) -> dict[str, Any]:
        """Plain data, for a JSON file: the report's and the two counts."""
        return {"chunks": self.chunks, "done": self.done, **self.report.as_json()}

    @classmethod
    def from_json(cls, data: dict[str, Any]) -> "State":
        """Read back what `as_json` wrote."""
        return cls(data["chunks"], data["done"], Report.from_json(data))


def run(
    chosen: Sequence[Case],
    rules: Rules,
    *,
    jobs: int = 1,
    chunk: int = CHUNK,
    state: State | None = None,
    progress: Callable[[State], None] = lambda state: None,
) -> Report:
    """Solve every case, certify it, and let the referee judge some.

    Parameters
    ----------
    chosen : sequence of Case
    rules : Rules
    jobs : int
        Worker processes; 1 works in this one.
    chunk : int
        Cases that a worker takes at a time.
    state : State, optional
        Where an earlier run of the same cases in the same chunks was broken.
    progress : callable
        Called with the state after every chunk.

    Returns
    -------
    Report
    """
    state = State(-(-len(chosen) // chunk)) if state is None else state
    rest = (chosen[k :: state.chunks] for k in range(state.done, state.chunks))
    for found in _found(rest, rules, jobs):
        state.report.add(found)
        state.done += 1
        progress(state)
    return state.report


def _found(chunks: Iterator[Sequence[Case]], rules: Rules, jobs: int) -> Iterator[Report]:
    """The report of each chunk, in order; only a few chunks wait at a time."""
    if jobs == 1:
        yield from (_counted(chunk, rules) for chunk in chunks)
        return
    waiting: deque[Future[Report]] = deque()
    with ProcessPoolExecutor(jobs, mp_context=multiprocessing.get_context("spawn")) as pool:
        for chunk in chunks:
            waiting.append(pool.submit(_counted, chunk, rules))
            if len(waiting) > AHEAD * jobs:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()


def _counted(chunk: Sequence[Case], rules: Rules) -> Report:
    """Treat every case of a chunk; an exception is a failure of its case."""
    report = Report()
    for case in chunk:
        tally, start = report.tally(case.family), time.perf_counter()
        tally.total += 1
        try:
            _treat(case, rules, report)
        except Exception as error:
            _fail(report, Failure(case, Reason.CRASH, _described(error)))
            tally.crashed += 1
        tally.seconds += time.perf_counter() - start
    return report


def _described(error: Exception) -> str:
    """The exception's type and message, and where it was raised."""
    place = traceback.extract_tb(error.__traceback__)[-1]
    return f"{type(error).__name__}: {error} ({Path(place.filename).name}:{place.lineno})"


def _fail(report: Report, failure: Failure) -> None:
    report.failures.append(failure)
    report.tally(failure.case.family).failed += 1


def _treat(case: Case, rules: Rules, report: Report) -> None:
    """Solve and judge one case."""
    problem, tally = case.problem(), report.tally(case.family)
    try:
        solution = solve(problem, rules.solver, escalate=rules.escalate)
    except SolverError as error:
        _fail(report, _failure(case, problem, None, Reason.NO_ANSWER, str(error.value)))
        return
    certified = solution.status is Status.CERTIFIED
    enclosed = rules.escalate and solution.status is Status.ENCLOSED
    tally.certified += certified
    tally.enclosed += enclosed
    tally.escalated += solution.solver != rules.solver.name
    if rules.asks_raw(case):
        report.raw_tally(case.family).count(
            raw(problem), solution.certificate.lower, solution.certificate.upper
        )
    if rules.referees(case) or not (certified or enclosed):
        _referee(case, solution, not (certified or enclosed), report)


def _referee(case: Case, solution: Solution, failed: bool, report: Report) -> None:
    """Let the exact referee judge every statement of the certificate, and explain a failure."""
    tally = report.tally(case.family)
    try:
        truth = optimum(solution.problem)
        false = violations(solution.problem, solution.w, solution.u, solution.certificate, truth)
        reason, true_gap = _reason(solution, truth) if failed else (None, 0.0)
    except Exception as error:
        _fail(report, _failure(case, solution.problem, solution, Reason.REFEREE, _described(error)))
        return
    tally.refereed += 1
    tally.loose += not truth.tight
    if false:
        tally.contradicted += 1
        report.contradictions.append(Contradiction(case, tuple(false)))
    if reason is not None:
        _fail(report, _failure(case, solution.problem, solution, reason, solution.solver_status, true_gap))


def _reason(solution: Solution, truth: Optimum) -> tuple[Reason, float]:
    """Compare the true gap of the point with the tolerances."""
    value, certificate = objective(solution.problem, solution.w, solution.u), solution.certificate
    high, low = value.upper - truth.value.lower, value.lower - truth.value.upper
    relative = Fraction(certificate.relative_tolerance) * truth.value.lower
    square = sum((Fraction(x) ** 2 for x in solution.problem.o), Fraction(0))
    allowed = max(relative, Fraction(certificate.absolute_tolerance) * square)
    true_gap = float(high / truth.value.lower) if truth.value.lower else float("inf")
    if high <= allowed:
        return Reason.PROOF, true_gap
    return (Reason.POINT if low > allowed else Reason.OPEN), true_gap


def _failure(
    case: Case,
    problem: Problem,
    solution: Solution | None,
    reason: Reason,
    claim: str,
    true_gap: float = float("inf"),
) -> Failure:
    proof = solution.certificate if solution else None
    return Failure(
        case=case,
        reason=reason,
        claim=claim,
        n=problem.n,
        d=problem.d,
        m=problem.m,
        lambdas=problem.lambdas,
        relative_gap=proof.relative_gap if proof else float("inf"),
        share_of_target=proof.share_of_target if proof else float("inf"),
        true_gap=true_gap,
        method=proof.method if proof else "",
    )
