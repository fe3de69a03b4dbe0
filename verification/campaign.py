"""The reference on many problems: how many are certified, which are not and why, and is any proof false.

A case is (family, seed, index) and can be repeated from these three alone.
"""

import multiprocessing
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, field
from enum import StrEnum
from fractions import Fraction
from typing import Any

from convexperc.errors import SolverError
from convexperc.problem import Problem
from convexperc.solution import Solution, Status
from convexperc.solvers.conic import Conic
from convexperc.solvers.interface import Solver
from convexperc.solving import solve
from verification.families import EXTREME, ORDINARY_DEGENERATE, RANDOM, seeded
from verification.oracles import objective
from verification.referee import Optimum, optimum, violations

CHUNK = 25
"""Cases that a worker takes at a time."""


class Reason(StrEnum):
    """Why an answer is not certified, found by the exact referee."""

    NO_ANSWER = "the solver gave no point"
    POINT = "the point is not within the tolerance"
    PROOF = "the point is within the tolerance, the proof is not"
    OPEN = "the referee cannot tell"


@dataclass(frozen=True)
class Case:
    """One problem by name."""

    family: str
    seed: int
    index: int

    def problem(self) -> Problem:
        """Draw it."""
        return seeded(self.family, self.seed, self.index)


@dataclass(frozen=True)
class Failure:
    """One problem that was not certified, with all that is needed to repeat it.

    Attributes
    ----------
    case : Case
    n, d, m : int
    lambdas : (float, float, float)
    relative_gap, share_of_target : float
        What the certificate proves; infinite without an answer.
    true_gap : float
        The referee's upper bound of (F(w, u) - F*) / F*, infinite if F* may be 0.
    claim : str
        The solver's own word.
    reason : Reason
    method : str
        How the gap was proved.
    """

    case: Case
    n: int
    d: int
    m: int
    lambdas: tuple[float, float, float]
    relative_gap: float
    share_of_target: float
    true_gap: float
    claim: str
    reason: Reason
    method: str


@dataclass(frozen=True)
class Outcome:
    """What one case came to; `contradictions` are statements of its certificate that are disproved."""

    case: Case
    certified: bool
    enclosed: bool = False
    failure: Failure | None = None
    refereed: bool = False
    loose: bool = False
    contradictions: tuple[str, ...] = ()


@dataclass(frozen=True)
class Tally:
    """Counts of one family."""

    family: str
    total: int
    certified: int
    enclosed: int
    refereed: int
    contradicted: int


@dataclass
class Report:
    """A campaign's counts by family, every failure, every contradiction."""

    outcomes: list[Outcome] = field(default_factory=list)

    @property
    def failures(self) -> list[Failure]:
        """Every problem with neither a certified answer nor (with escalation) an enclosed optimum."""
        return [outcome.failure for outcome in self.outcomes if outcome.failure]

    @property
    def contradictions(self) -> list[Outcome]:
        """Every certificate that says something false."""
        return [outcome for outcome in self.outcomes if outcome.contradictions]

    @property
    def clean(self) -> bool:
        """All certified, none contradicted, and at least one case looked at."""
        return bool(self.outcomes) and not self.failures and not self.contradictions

    def tallies(self) -> list[Tally]:
        """Counts by family, in the order of their first case."""
        total, certified, enclosed, refereed, contradicted = (Counter[str]() for _ in range(5))
        for outcome in self.outcomes:
            name = outcome.case.family
            total[name] += 1
            certified[name] += outcome.certified
            enclosed[name] += outcome.enclosed
            refereed[name] += outcome.refereed
            contradicted[name] += bool(outcome.contradictions)
        return [
            Tally(name, total[name], certified[name], enclosed[name], refereed[name], contradicted[name])
            for name in total
        ]

    def reasons(self) -> dict[str, int]:
        """How many failures have which reason."""
        return dict(Counter(failure.reason.value for failure in self.failures))

    def as_json(self) -> dict[str, Any]:
        """Plain data, for a JSON file; infinities become the string "inf"."""
        data = {
            "families": [asdict(tally) for tally in self.tallies()],
            "reasons": self.reasons(),
            "failures": [asdict(failure) for failure in self.failures],
            "contradictions": [asdict(outcome) for outcome in self.contradictions],
        }
        plain: dict[str, Any] = _without_infinities(data)
        return plain


def cases(random: int, degenerate: int, seed: int, *, extreme: int = 0) -> list[Case]:
    """`random`, `degenerate` and `extreme` problems, dealt out evenly over the families of each group."""
    dealt = []
    for count, group in ((random, RANDOM), (degenerate, ORDINARY_DEGENERATE), (extreme, EXTREME)):
        names = list(group)
        dealt += [Case(names[k % len(names)], seed, k // len(names)) for k in range(count)]
    return dealt


def run(
    chosen: Sequence[Case],
    *,
    solver: Solver | None = None,
    escalate: bool = False,
    referee_every: int = 0,
    jobs: int = 1,
    progress: Callable[[int], None] = lambda done: None,
) -> Report:
    """Solve every case, certify it, and let the referee judge some.

    Parameters
    ----------
    chosen : sequence of Case
    solver : Solver or None
        None is the reference, CVXPY + Clarabel.
    escalate : bool
        Answer by ball arithmetic where the solver's answer is not certified; an enclosed optimum then is
        no failure.
    referee_every : int
        Of each family, every how many cases the exact referee also judges a certified answer; 0 for
        never. It judges every answer that is not certified.
    jobs : int
        Worker processes; 1 works in this one.
    progress : callable
        Called with the number of cases that are newly done.

    Returns
    -------
    Report
    """
    solver = solver or Conic()
    work = [
        (case, solver, escalate, bool(referee_every) and case.index % referee_every == 0) for case in chosen
    ]
    report = Report()
    for outcome in _outcomes(work, jobs):
        report.outcomes.append(outcome)
        progress(1)
    return report


def _outcomes(work: list[tuple[Case, Solver, bool, bool]], jobs: int) -> Iterator[Outcome]:
    if jobs == 1:
        yield from map(_judge, work)
        return
    with ProcessPoolExecutor(jobs, mp_context=multiprocessing.get_context("spawn")) as pool:
        yield from pool.map(_judge, work, chunksize=CHUNK)


def _judge(item: tuple[Case, Solver, bool, bool]) -> Outcome:
    case, solver, escalate, referee = item
    problem = case.problem()
    try:
        solution = solve(problem, solver, escalate=escalate)
    except SolverError as error:
        without = _failure(case, problem, None, str(error.value), Reason.NO_ANSWER)
        return Outcome(case, certified=False, failure=without)
    certified = solution.status is Status.CERTIFIED
    enclosed = escalate and solution.status is Status.ENCLOSED
    if (certified or enclosed) and not referee:
        return Outcome(case, certified, enclosed)
    truth = optimum(problem)
    false = tuple(violations(problem, solution.w, solution.u, solution.certificate, truth))
    failure = None
    if not (certified or enclosed):
        reason, true_gap = _reason(solution, truth)
        failure = _failure(case, problem, solution, solution.claim, reason, true_gap)
    return Outcome(case, certified, enclosed, failure, True, not truth.tight, false)


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
    claim: str,
    reason: Reason,
    true_gap: float = float("inf"),
) -> Failure:
    proof = solution.certificate if solution else None
    return Failure(
        case=case,
        n=problem.n,
        d=problem.d,
        m=problem.m,
        lambdas=problem.lambdas,
        relative_gap=proof.relative_gap if proof else float("inf"),
        share_of_target=proof.share_of_target if proof else float("inf"),
        true_gap=true_gap,
        claim=claim,
        reason=reason,
        method=proof.method if proof else "",
    )


def _without_infinities(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _without_infinities(part) for key, part in value.items()}
    if isinstance(value, (list, tuple)):
        return [_without_infinities(part) for part in value]
    if isinstance(value, float) and value in (float("inf"), float("-inf")):
        return "inf" if value > 0 else "-inf"
    return value
