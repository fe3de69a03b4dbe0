"""One template from problem to proof: normalise, solve, undo, certify; ball arithmetic where that misses."""

import time
from dataclasses import dataclass, fields

import numpy as np

from convexperc import enclosure
from convexperc.certificate.arithmetic import broken_assumption
from convexperc.certificate.certificate import Certificate, Certifier
from convexperc.certificate.tolerances import ABSOLUTE, RELATIVE, Tolerances
from convexperc.enclosure.budget import SECONDS, Budget
from convexperc.errors import InputError, SolverError, check_type
from convexperc.problem.arrays import FeatureVector, Vector
from convexperc.problem.formulation import residuals
from convexperc.problem.problem import Problem
from convexperc.problem.scaling import Scaling
from convexperc.solution.solution import Solution, Timings
from convexperc.solvers.interface import Solver, SolverResult
from convexperc.solvers.newton.method import Newton

CLEARLY_BELOW = 1.0 - 1e-6
"""A certified F(w, u) below this share of ||o||^2 = F(0, 0) needs no look at the zero point."""


@dataclass(frozen=True, eq=False)
class _Answer:
    """A point with its certificate."""

    w: Vector
    u: FeatureVector
    certificate: Certificate

    def better_than(self, other: "_Answer") -> bool:
        """Whether more is proved of this point."""
        mine, theirs = self.certificate, other.certificate
        return mine.gap <= theirs.gap or (mine.certified and not theirs.certified)


def solve(
    problem: Problem,
    solver: Solver | None = None,
    *,
    escalate: bool | None = None,
    relative_tolerance: float = RELATIVE,
    absolute_tolerance: float = ABSOLUTE,
    seconds: float = SECONDS,
) -> Solution:
    """Minimise F and prove how well.

    The solver sees the exactly normalised problem; its answer is scaled back exactly and certified on the
    data as given. Entries that are proved to be 0 are set to 0. Where w = u = 0 is at least as good, by
    proof, that is the answer.

    Parameters
    ----------
    problem : Problem
    solver : Solver, optional
        `Newton` without: compiled on its first use, which takes some seconds once for an installation.
    escalate : bool, optional
        Where the solver's answer is not certified, answer by `convexperc.enclosure` instead; the solution's
        `solver` then says so. Without: yes if no solver is named, no if the answer of a named one is wanted.
    relative_tolerance, absolute_tolerance : float
        See `convexperc.certificate.Tolerances`.
    seconds : float
        For ball arithmetic, where it is needed; see `convexperc.enclosure.budget.Budget`.

    Returns
    -------
    Solution
        Its `status` says whether it is certified; nothing else does. Its `reason` says whether the budget
        ended the search.

    Raises
    ------
    InputError
        `solver` is no solver.
    ToleranceError
        A tolerance is no finite number >= 0.
    BudgetError
        `seconds` is no number > 0.
    SolverError, ArithmeticError, numpy.linalg.LinAlgError
        The solver gave no point at all, and `escalate` is false.
    """
    check_type(escalate, (bool, type(None)), "escalate")
    tolerances = Tolerances(relative_tolerance, absolute_tolerance)
    return solved(problem, solver, tolerances, Budget(seconds), escalate=escalate)


def solved(
    problem: Problem,
    solver: Solver | None,
    tolerances: Tolerances,
    budget: Budget,
    *,
    escalate: bool | None = None,
) -> Solution:
    """`solve` within what is left of a budget."""
    if escalate is None:
        escalate = solver is None
    solver = Newton() if solver is None else solver
    if isinstance(solver, type) or not callable(getattr(solver, "solve", None)):
        must = "must be a solver: an object with a name and a method solve(problem)"
        raise InputError("solver", value=solver, must=must, remedy="Pass an instance such as Conic().")
    start = time.perf_counter()
    scaling = Scaling.of(problem)
    normal = scaling.normalise(problem)
    normalised = time.perf_counter()
    try:
        with np.errstate(all="ignore"):
            result = solver.solve(normal)
    except (SolverError, ArithmeticError, np.linalg.LinAlgError) as failure:
        shown = _as_given(failure, problem) if isinstance(failure, SolverError) else failure
        if not escalate:
            raise shown from failure.__cause__
        reason = shown.value if isinstance(shown, SolverError) else shown
        nothing = np.zeros(problem.n), np.zeros(problem.d)
        result = SolverResult(*nothing, f"failed: {reason}", 0)
    timings = Timings(normalised - start, time.perf_counter() - normalised, 0.0)
    return certified(
        problem, scaling, solver.name, result, tolerances, budget if escalate else None, timings=timings
    )


def _as_given(failure: SolverError, problem: Problem) -> SolverError:
    """The same error with the number that the caller gave: a solver sees the normalised one."""
    if failure.what not in {field.name for field in fields(Problem)}:
        return failure
    value = getattr(problem, failure.what)
    return type(failure)(failure.what, value=value, must=failure.must, remedy=failure.remedy)


def certified(
    problem: Problem,
    scaling: Scaling,
    solver: str,
    result: SolverResult,
    tolerances: Tolerances,
    budget: Budget | None,
    *,
    timings: Timings,
) -> Solution:
    """Certify a solver's result on the problem as given; with a budget, ball arithmetic where that misses.

    Parameters
    ----------
    problem : Problem
    scaling : Scaling
        How the problem was normalised for the solver.
    solver : str
        The solver's name.
    result : SolverResult
        In normalised units.
    tolerances : Tolerances
    budget : Budget, optional
    timings : Timings
        Of what was done before.

    Returns
    -------
    Solution
    """
    began = time.perf_counter()
    answer = _best(Certifier.of(problem, scaling, tolerances=tolerances), result)
    reason = ""
    if budget is not None and not answer.certificate.certified and not broken_assumption():
        better, reason = _escalate(problem, answer, budget)
        if better is not answer:
            solver, answer = f"{solver}, then ball arithmetic", better
    w, u = answer.w, answer.u
    w.flags.writeable = u.flags.writeable = False
    took = Timings(timings.normalise, timings.solve, time.perf_counter() - began)
    return Solution(
        problem, w, u, answer.certificate, solver, result.solver_status, result.iterations, took, reason
    )


def _best(certifier: Certifier, result: SolverResult) -> _Answer:
    """Certify the result, the result with its proved zeros at 0, and the zero point; keep the best."""
    problem, scaling = certifier.problem, certifier.scaling
    w, u = scaling.point_back(result.w, result.u)
    dual = None if result.dual is None else scaling.dual_back(*result.dual)
    best = _Answer(w, u, certifier.certificate(w, u, dual=dual))
    if broken_assumption():  # nothing can be said for another point
        return best
    hint = _residual_dual(problem, w, u) if dual is None else dual

    def answer(w: Vector, u: FeatureVector) -> _Answer:
        return _Answer(w, u, certifier.certificate(w, u, dual=hint))

    point = _with_zeros(problem, best)
    if point is not None:
        sparse = answer(*point)
        best = sparse if sparse.certificate.certified or sparse.better_than(best) else best
    if best.certificate.certified and best.certificate.objective[1] < CLEARLY_BELOW * best.certificate.target:
        return best
    zero = answer(np.zeros(problem.n), np.zeros(problem.d))
    return zero if zero.better_than(best) else best


def _residual_dual(problem: Problem, w: Vector, u: FeatureVector) -> tuple[FeatureVector, Vector]:
    """The dual point 2(X'w - o) and 2 lambda1 (Xu - w)."""
    with np.errstate(over="ignore", invalid="ignore"):
        p, q = residuals(problem, w, u)
        return 2.0 * p, 2.0 * problem.lambda1 * q


def _with_zeros(problem: Problem, answer: _Answer) -> tuple[Vector, FeatureVector] | None:
    """The point with every entry at 0 that is proved to be 0 at the optimum; None without a change."""
    w, u = answer.w.copy(), answer.u.copy()
    w[answer.certificate.zero_views] = 0.0
    for columns, zero in zip(problem.modalities, answer.certificate.zero_modalities, strict=True):
        if zero:
            u[columns] = 0.0
    changed = not (np.array_equal(w, answer.w) and np.array_equal(u, answer.u))
    return (w, u) if changed else None


def _escalate(problem: Problem, answer: _Answer, budget: Budget) -> tuple[_Answer, str]:
    """The better of two points, certified in ball arithmetic: the enclosure's own, and the answer's.

    The answer as it is where there was no budget for that; and why no more is proved.
    """
    if budget.spent:
        return answer, budget.reason
    point, before = enclosure.finite_start(answer.w, answer.u), answer.certificate
    found = enclosure.enclosed(problem, enclosure.NARROW, budget, start=point)
    if budget.spent and not found.steps:
        return answer, budget.reason
    own = _Answer(found.w, found.u, enclosure.certify_in_balls(problem, found, before))
    best = own
    if point is not None:
        kept = _Answer(*point, enclosure.certify_in_balls(problem, found, before, point))
        best = own if own.better_than(kept) else kept
    return best, "" if best.certificate.certified else found.reason
