"""Claims T1a and T1b by counting: reading x order x {monotone on F, on its own objective, reaches F*}.

Every run starts from the paper's start. F* is the reference's, certified; where it is not, the run is counted
for monotony alone.
"""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

from convexperc.certificate import Certificate
from convexperc.errors import SolverError
from convexperc.problem import Problem
from convexperc.solution import Status
from convexperc.solvers.conic import Conic
from convexperc.solvers.paper import READINGS, Order, PaperTrace, Reading, Stop, run
from convexperc.solving import solve
from verification.campaign.cases import Case
from verification.families import seeded

LARGEST = (6, 24)
"""Largest n and d of the table: one direct solve of u costs d^3, with thousands of them a problem."""

REACHED = 1e-6
"""F of the last iterate within this share of F* counts as the optimum: what the loop's own test of 1e-10 on
the steps leaves where it converges slowly, and far below the gaps of wrong limits (13/16 against 3/4)."""

REACHED_FLOOR = 1e-12
"""The same as a share of ||o||^2, for problems with F* = 0: the rounding of F."""

ITERATIONS = 500
"""Most iterations of a run; runs that need more are counted by their own stop reason."""


@dataclass
class Row:
    """Counts of one reading in one order.

    Attributes
    ----------
    reading, order : str
    runs : int
    monotone : int
        Runs whose F never rose beyond rounding.
    own_monotone, own_runs : int
        The same for the objective that the reading descends; 0 of 0 if it has none.
    reached, judged : int
        Runs whose last F is F*, of those whose F* is certified.
    stops : dict of str to (int, int)
        Stop reason: runs, and how many of these reached F*.
    first_rise, first_own_rise, first_wrong_limit : Case or None
        The first run whose F rose; whose own objective rose; that stopped by itself elsewhere than at F*.
    """

    reading: str
    order: str
    runs: int = 0
    monotone: int = 0
    own_monotone: int = 0
    own_runs: int = 0
    reached: int = 0
    judged: int = 0
    stops: dict[str, tuple[int, int]] = field(default_factory=dict)
    first_rise: Case | None = None
    first_own_rise: Case | None = None
    first_wrong_limit: Case | None = None

    def add(self, case: Case, trace: PaperTrace, reached: bool | None) -> None:
        """Count one run; `reached` is None where F* is not known."""
        rises, own_rises = trace.rises().size > 0, trace.own_rises().size > 0
        self.runs += 1
        self.monotone += not rises
        if trace.own.size:
            self.own_runs += 1
            self.own_monotone += not own_rises
        self.judged += reached is not None
        self.reached += bool(reached)
        count, good = self.stops.get(trace.stop.value, (0, 0))
        self.stops[trace.stop.value] = count + 1, good + bool(reached)
        self.first_rise = self.first_rise or (case if rises else None)
        self.first_own_rise = self.first_own_rise or (case if own_rises else None)
        wrong = reached is False and trace.stop is Stop.CONVERGED
        self.first_wrong_limit = self.first_wrong_limit or (case if wrong else None)


@dataclass
class Table:
    """All rows, and the problems whose optimum is not certified."""

    rows: list[Row]
    problems: dict[str, int] = field(default_factory=dict)
    without_optimum: list[Case] = field(default_factory=list)

    def row(self, reading: str, order: str) -> Row:
        """The row of one reading in one order."""
        return next(row for row in self.rows if (row.reading, row.order) == (reading, order))

    def as_json(self) -> dict[str, Any]:
        """Plain data, for a JSON file."""
        return asdict(self)


def has_reached(value: float, certificate: Certificate, problem: Problem) -> bool:
    """Whether F = `value` is F* to within `REACHED`, or `REACHED_FLOOR` of ||o||^2."""
    allowed = REACHED * certificate.lower + REACHED_FLOOR * float(problem.o @ problem.o)
    return value - certificate.lower <= allowed


def table(
    cases: Sequence[Case],
    *,
    readings: Sequence[Reading] = READINGS,
    max_iterations: int = ITERATIONS,
    largest: tuple[int, int] = LARGEST,
    progress: Callable[[int], None] = lambda done: None,
) -> Table:
    """Run every reading in both orders on every case.

    Parameters
    ----------
    cases : sequence of Case
    readings : sequence of Reading
    max_iterations : int
    largest : (int, int)
        Largest n and d of the problems.
    progress : callable
        Called with the number of problems that are newly done.

    Returns
    -------
    Table
    """
    counts = Table([Row(reading.name, order.value) for reading in readings for order in Order])
    reference = Conic()
    for case in cases:
        problem = seeded(case.family, case.seed, case.index, largest=largest)
        counts.problems[case.family] = counts.problems.get(case.family, 0) + 1
        certificate = _certified(problem, reference)
        if certificate is None:
            counts.without_optimum.append(case)
        for reading in readings:
            for order in Order:
                trace = run(problem, reading=reading, order=order, max_iterations=max_iterations)
                value = float(trace.F[-1])
                reached = None if certificate is None else has_reached(value, certificate, problem)
                counts.row(reading.name, order.value).add(case, trace, reached)
        progress(1)
    return counts


def _certified(problem: Problem, reference: Conic) -> Certificate | None:
    try:
        solution = solve(problem, reference, escalate=True)
    except SolverError:
        return None
    return None if solution.status is Status.NOT_CERTIFIED else solution.certificate
