"""F2 and F4 by cases: other forms of the problem have the same optimum; equal columns get equal weights."""

from collections.abc import Iterator
from fractions import Fraction

import numpy as np

from convexperc.errors import SolverError
from convexperc.problem import formulation as library
from convexperc.problem.problem import Problem
from convexperc.problem.scaling import Scaling
from convexperc.solution import single as solving
from convexperc.solution.solution import Solution, Status
from convexperc.solvers.conic import Conic
from convexperc.solvers.interface import Solver
from convexperc.solvers.newton.method import STATUSES, Newton
from convexperc.solvers.osqp import Quadratic, is_quadratic
from verification.checks.interface import REFEREED, Check, Observation
from verification.checks.measures import LARGE, ULP, drawn_point, is_finite, number, share
from verification.exact import formulation, referee
from verification.exact.numbers import inner, rationals, square_root, squares
from verification.exact.problem import ExactProblem
from verification.ledger.evidence import Outcome
from verification.problems.sources import Source

FINISHED = ("optimal", "solved", *STATUSES)
"""What Clarabel and OSQP say of an answer that they stand by; and Newton's method of any, since its limit of
iterations is far above what a problem of this size takes."""
AWAY = Fraction(1, 10**8)
"""An answer that its solver stands by and whose F is this share of ||o||^2 above F* belongs to another
problem, where float64 can be trusted with it: ten times the solvers' own tolerances, 1e-9 or less."""
MODEST = 1e6
"""Float64 can be trusted with normalised lambdas and entries of X that are 0 or within this factor of 1,
and lambda1, lambda2 > 0, so that w* is unique and depends continuously on the data."""
ROUNDING = 16
"""The library's sum of norms may be off by this many units, times d."""


def observe_conic(problem: Problem, source: Source) -> Iterator[Observation]:
    """Compare Clarabel's certified interval with the referee's."""
    yield _agreement("F2/conic", problem, Conic())


def observe_reduced(problem: Problem, source: Source) -> Iterator[Observation]:
    """Compare the certified interval of the reduced problem's answer with the referee's."""
    yield _agreement("F2/reduced", problem, Newton())


def observe_quadratic(problem: Problem, source: Source) -> Iterator[Observation]:
    """Compare OSQP's certified interval with the referee's, where the problem is a quadratic program."""
    if is_quadratic(problem):
        yield _agreement("F2/quadratic", problem, Quadratic())
    else:
        yield Observation("F2/quadratic", Outcome.SKIPPED, detail="no quadratic program")


def _agreement(part: str, problem: Problem, solver: Solver) -> Observation:
    try:
        solution = solving.solve(problem, solver, escalate=False)
    except (SolverError, ArithmeticError, np.linalg.LinAlgError) as failure:
        return Observation(part, Outcome.UNDECIDED, detail=f"no answer: {failure}")
    if not is_finite(solution.w, solution.u):
        return Observation(part, Outcome.UNDECIDED, detail="the weights are beyond float64")
    return _judged(part, solution, referee.optimum(problem))


def _judged(part: str, solution: Solution, truth: referee.Optimum) -> Observation:
    """Compare an answer's interval and its F with the referee's optimum."""
    low, high = truth.value.lower, truth.value.upper
    lower, upper = solution.certificate.lower, solution.certificate.upper
    misses = lower > high or upper < low
    value = formulation.objective(solution.problem, solution.w, solution.u)
    gap, target = value.lower - high, squares(rationals(solution.problem.o))
    measure = share(gap, high)
    where = f"[{lower!r}, {upper!r}], F* = {number(high)!r}, F(w, u) = {number(value.lower)!r}"
    other = solution.solver_status in FINISHED and gap > AWAY * target and _is_modest(solution.problem)
    if misses or other:
        return Observation(part, Outcome.FAILED, measure, f"{solution.solver_status}: {where}")
    if solution.status is Status.NOT_CERTIFIED or not truth.tight:
        return Observation(
            part, Outcome.UNDECIDED, measure, f"not certified ({solution.solver_status}): {where}"
        )
    return Observation(part, Outcome.HELD, measure)


def _is_modest(problem: Problem) -> bool:
    """See `MODEST`."""
    normal = Scaling.of(problem).normalise(problem)
    sizes = np.abs(np.concatenate([normal.X.ravel(), normal.lambdas]))
    sizes = sizes[sizes > 0.0]
    return min(problem.lambda1, problem.lambda2) > 0.0 and bool(
        (sizes > 1.0 / MODEST).all() and (sizes < MODEST).all()
    )


def observe_group_lasso(problem: Problem, source: Source) -> Iterator[Observation]:
    """Write ||A z - t||^2 and the group norms out at a drawn z, with lambda1 = s^2 for a drawn s."""
    s = Fraction(source.integer(1, 9), 2 ** source.integer(0, 3))
    posed = Problem(
        problem.X, problem.o, modalities=problem.modalities,
        lambda1=float(s * s), lambda2=problem.lambda2, lambda3=problem.lambda3,
    )  # fmt: skip
    w, u = drawn_point(problem, source)
    data, z = ExactProblem.of(posed), rationals(np.concatenate([w, u]))
    zero, n, d = Fraction(0), problem.n, problem.d
    top = [[row[k] for row in data.X] + [zero] * d for k in range(d)]
    bottom = [[-s if i == j else zero for j in range(n)] + [s * x for x in data.X[i]] for i in range(n)]
    target = [*data.o, *([zero] * n)]
    loss = squares(inner(row, z) - t for row, t in zip(top + bottom, target, strict=True))
    groups: list[tuple[tuple[int, ...], Fraction]] = [((j,), data.lambda2) for j in range(n)]
    groups += [(tuple(n + k for k in group), data.lambda3) for group in data.groups]
    norms = [(weight, square_root(squares(z[k] for k in group))) for group, weight in groups]
    low, high = (loss + sum(weight * getattr(x, end) for weight, x in norms) for end in ("lower", "upper"))
    value = formulation.objective(posed, w, u)
    apart = max(low - value.upper, value.lower - high)
    detail = f"s = {s}: {number(low)!r}, F = {number(value.lower)!r}"
    yield Observation.of("F2/group_lasso", apart <= 0, share(apart, value.upper), detail)


def observe_equal_columns(problem: Problem, source: Source) -> Iterator[Observation]:
    """Make two columns of a modality equal: their mean weight is strictly better, and the answer has it."""
    part, groups = "F4/parallel", [g for g in ExactProblem.of(problem).groups if len(g) > 1]
    if not groups or problem.lambda3 == 0.0:
        reason = "lambda3 = 0" if groups else "no modality with two columns"
        yield Observation(part, Outcome.SKIPPED, detail=reason)
        return
    group = groups[source.integer(0, len(groups) - 1)]
    first, second = group[0], group[source.integer(1, len(group) - 1)]
    X = problem.X.copy()
    X[:, second] = X[:, first]
    equal = Problem(
        X, problem.o, modalities=problem.modalities,
        lambda1=problem.lambda1, lambda2=problem.lambda2, lambda3=problem.lambda3,
    )  # fmt: skip
    wrong = _mean_is_no_better(equal, drawn_point(problem, source), (first, second))
    if wrong:
        yield Observation(part, Outcome.FAILED, 1.0, wrong)
        return
    yield _equal_weights(solving.solve(equal), group, (first, second))


def _mean_is_no_better(problem: Problem, point: tuple[np.ndarray, np.ndarray], pair: tuple[int, int]) -> str:
    """What contradicts F(w, mean) < F(w, u), exactly and in the library's modality norm; empty if nothing."""
    (w, u), (first, second) = point, pair
    if u[first] == u[second]:
        return ""
    before = rationals(u)
    after = before.copy()
    after[first] = after[second] = (before[first] + before[second]) / 2
    high, low = formulation.objective(problem, w, after), formulation.objective(problem, w, before)
    if high.upper >= low.lower:
        return f"F = {number(low.lower)!r} at unequal weights, {number(high.upper)!r} at their mean"
    mean = u.copy()
    mean[first] = mean[second] = 0.5 * (u[first] + u[second])
    room = ROUNDING * problem.d * ULP
    with np.errstate(all="ignore"):
        old, new = (library.terms(problem, w, x).modality_norm for x in (u, mean))
    if not (np.isfinite(old) and np.isfinite(new)) or Fraction(old) < 1 / LARGE:
        return ""
    fall = low.lower - high.upper
    if Fraction(new) > Fraction(old) * (1 + room) - fall:
        return f"the library's modality norm goes {old!r} -> {new!r} where weights become equal"
    return ""


def _equal_weights(solution: Solution, group: tuple[int, ...], pair: tuple[int, int]) -> Observation:
    """A point with a gap has (u_k - u_l)^2 lambda3 <= 4 gap ||u^i||: else the mean would lie below F*."""
    part, proof = "F4/parallel", solution.certificate
    if solution.status is Status.NOT_CERTIFIED or not is_finite(solution.u, np.array(proof.gap)):
        return Observation(part, Outcome.UNDECIDED, detail="no finite gap is proved")
    values = rationals(solution.u[list(group)])
    length = square_root(squares(values))
    apart = abs(Fraction(float(solution.u[pair[0]])) - Fraction(float(solution.u[pair[1]])))
    room = 4 * Fraction(proof.gap) * length.upper
    held = apart * apart * Fraction(solution.problem.lambda3) <= room
    detail = f"u = {[float(solution.u[k]) for k in pair]} with a gap of {proof.gap!r}"
    return Observation.of(part, held, share(apart, length.upper), detail)


CHECKS = (
    Check("conic", ("F2/conic",), observe_conic, REFEREED, share=0.03),
    Check("reduced", ("F2/reduced",), observe_reduced, REFEREED, share=0.03),
    Check("quadratic", ("F2/quadratic",), observe_quadratic, share=0.03),
    Check("group lasso", ("F2/group_lasso",), observe_group_lasso, share=0.5, product=False),
    Check("equal columns", ("F4/parallel",), observe_equal_columns, share=0.5),
)
