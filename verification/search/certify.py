"""A campaign run: every problem is solved and certified, and some are compared with the exact referee."""

import time
import traceback
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import Any

from convexperc.errors import SolverError
from convexperc.problem.problem import Problem
from convexperc.solution.single import solve
from convexperc.solution.solution import Solution, Status
from convexperc.solvers.interface import Solver
from verification.checks.clarabel import solve_directly
from verification.exact.formulation import objective
from verification.exact.referee import Optimum, optimum, violations
from verification.journal import Journal
from verification.search.campaign import SOLVERS, Campaign, Stretch
from verification.search.tallies import Case, Contradiction, Failure, Reason, Report
from verification.search.tasks import run_tasks


def run(
    campaign: Campaign,
    *,
    jobs: int = 1,
    journal: Journal | None = None,
    progress: Callable[[Report], None] = lambda report: None,
) -> Report:
    """Solve every problem, certify it, and referee some.

    Parameters
    ----------
    campaign : Campaign
    jobs : int
        Worker processes; 1 works in this one.
    journal : Journal, optional
        Keeps finished shards; those it has already are not done again.
    progress : callable
        Called with the report so far: of what the journal keeps, and after each shard.

    Returns
    -------
    Report
    """
    report, solver = Report(), SOLVERS[campaign.solver]()
    tasks = {each.key: partial(count_shard, each, campaign, solver) for each in campaign.plan()}
    for key, data in ({} if journal is None else journal.entries).items():
        if key in tasks:
            report.add(Report.from_json(data))
    progress(report)

    def take(key: str, data: dict[str, Any]) -> None:
        report.add(Report.from_json(data))
        progress(report)

    report.lost |= run_tasks(tasks, take, jobs=jobs, journal=journal)
    return report.ordered()


def count_shard(stretch: Stretch, campaign: Campaign, solver: Solver) -> dict[str, Any]:
    """Treat every problem of a shard and return its report as plain data.

    An exception is a failure of its problem, not of the shard.
    """
    report = Report()
    tally = report.tally(stretch.family)
    for case in campaign.cases(stretch):
        start = time.perf_counter()
        tally.total += 1
        try:
            _treat(case, campaign, solver, report)
        except Exception as error:
            _fail(report, Failure(case, Reason.CRASH, _described(error)))
            tally.crashed += 1
        tally.seconds += time.perf_counter() - start
    return report.as_json()


def _described(error: Exception) -> str:
    """The exception's type and message, and where it was raised."""
    place = traceback.extract_tb(error.__traceback__)[-1]
    return f"{type(error).__name__}: {error} ({Path(place.filename).name}:{place.lineno})"


def _fail(report: Report, failure: Failure) -> None:
    report.failures.append(failure)
    report.tally(failure.case.family).failed += 1


def _treat(case: Case, campaign: Campaign, solver: Solver, report: Report) -> None:
    """Solve and certify one problem."""
    problem, tally = case.problem(), report.tally(case.family)
    try:
        solution = solve(problem, solver, escalate=campaign.escalate)
    except SolverError as error:
        _fail(report, _failure(case, problem, None, Reason.NO_ANSWER, str(error.value)))
        return
    certified = solution.status is Status.CERTIFIED
    enclosed = campaign.escalate and solution.status is Status.ENCLOSED
    tally.certified += certified
    tally.enclosed += enclosed
    tally.escalated += solution.solver != solver.name
    if campaign.asks_clarabel(case):
        proof = solution.certificate
        report.clarabel_tally(case.family).count(solve_directly(problem), proof.lower, proof.upper)
    if campaign.referees(case) or not (certified or enclosed):
        _referee(case, solution, not (certified or enclosed), report)


def _referee(case: Case, solution: Solution, failed: bool, report: Report) -> None:
    """Compare every statement of the certificate with the exact referee, and explain a failure."""
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
    status: str,
    true_gap: float = float("inf"),
) -> Failure:
    failure = Failure(case, reason, status, problem.n, problem.d, problem.m, problem.lambdas)
    if solution is None:
        return failure
    proof = solution.certificate
    return replace(
        failure,
        relative_gap=proof.relative_gap,
        share_of_target=proof.share_of_target,
        true_gap=true_gap,
        method=proof.method,
    )
