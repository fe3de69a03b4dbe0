"""F3 by cases: the critical lambdas, exactly at and just below them."""

import math
from collections.abc import Iterator
from fractions import Fraction

import numpy as np

from convexperc.certificate import lambda_max as critical
from convexperc.certificate.data_bounds import DataBounds
from convexperc.problem.penalties import Penalties
from convexperc.problem.problem import Problem
from convexperc.problem.reduced import ReducedData
from convexperc.problem.scaling import Scaling
from convexperc.solution import single as solving
from convexperc.solution.solution import Solution, Status
from verification.checks.interface import Check, Observation
from verification.checks.measures import LARGE, number, share
from verification.exact.formulation import dual_objective, is_dual_feasible, objective
from verification.exact.numbers import inner, rationals, squares
from verification.exact.problem import ExactProblem
from verification.ledger.evidence import Outcome
from verification.problems.sources import Source

BELOW = 0.9
"""A lambda this share of the critical one must leave weights that are not 0."""
HALF = 0.5
"""At half of the critical lambda2 = 2 ||X o||_inf the formula without its factor 2 would begin to hold."""
CLEARLY = 1.0 + 2.0**-20
"""This many times the critical lambda2, rounding is no excuse for not seeing that w = u = 0 is optimal."""
BEYOND = 1.0 + 2.0**-16
"""The critical lambda3 is tried a little beyond, for its rounding."""
LENGTHS = (1.0, 1e6, 1e-6)
"""A second template is this many times the first."""
FAR = 2.0**10
"""A lambda3 this many times the critical one leaves u = 0 without doubt."""


def with_lambdas(problem: Problem, *, lambda2: float | None = None, lambda3: float | None = None) -> Problem:
    """The same data with another lambda2 or lambda3."""
    return Problem(
        problem.X,
        problem.o,
        modalities=problem.modalities,
        lambda1=problem.lambda1,
        lambda2=problem.lambda2 if lambda2 is None else lambda2,
        lambda3=problem.lambda3 if lambda3 is None else lambda3,
    )


def observe_lambda2(problem: Problem, source: Source) -> Iterator[Observation]:
    """F* = ||o||^2 at the critical lambda2, by the dual point (-2o, 0); F* < ||o||^2 at 0.9 of it."""
    part, data = "F3/critical_lambda2", ExactProblem.of(problem)
    low, high = critical.lambda2_max(problem)
    correlations = [2 * inner(row, data.o) for row in data.X]
    true = max(abs(x) for x in correlations)
    if not math.isfinite(high):
        yield Observation(part, Outcome.SKIPPED, detail="the critical lambda2 is beyond float64")
        return
    wrong = "" if Fraction(low) <= true <= Fraction(high) else f"[{low!r}, {high!r}] misses {number(true)!r}"
    wrong = wrong or _zero_is_not_optimal(with_lambdas(problem, lambda2=high))
    measure = share(max(Fraction(low) - true, true - Fraction(high)), true)
    j = max(range(problem.n), key=lambda j: abs(correlations[j]))
    for lambda2 in (BELOW * low, HALF * low):
        if not wrong and lambda2 > 0.0:
            wrong = _zero_is_optimal_below(with_lambdas(problem, lambda2=lambda2), j, correlations[j])
    wrong = wrong or _false_at(problem, source)
    yield Observation.of(part, not wrong, measure, wrong)


def _false_at(problem: Problem, source: Source) -> str:
    """What contradicts `zero_is_optimal`, of a problem and of a library, about the exact critical lambda2.

    The library holds another template as well, the same in another size.
    """
    other = problem.for_template(problem.o * source.choice(LENGTHS))
    library = DataBounds.of(ReducedData.of(problem.X, np.stack([problem.o, other.o]).T, problem.modalities))
    limits = [_critical(problem), _critical(problem), _critical(other)]
    safe = bool(library.data.sound.all()) and all(1 / LARGE < limit < LARGE for limit in limits)
    for lambda2 in [at for limit in limits[1:] if number(limit) for at in _about(number(limit))]:
        posed = with_lambdas(problem, lambda2=lambda2)
        said = [critical.zero_is_optimal(posed), *library.zero_is_optimal(Penalties(*posed.lambdas)).tolist()]
        for one, limit in zip(said, limits, strict=True):
            if one and Fraction(lambda2) < limit:
                return f"zero is called optimal at lambda2 = {lambda2!r}, below {number(limit)!r}"
            if safe and not one and Fraction(lambda2) >= limit * Fraction(CLEARLY):
                return f"zero is not called optimal at lambda2 = {lambda2!r}, beyond {number(limit)!r}"
    return ""


def _critical(problem: Problem) -> Fraction:
    """2 ||X o||_inf, exactly."""
    data = ExactProblem.of(problem)
    return 2 * max(abs(inner(row, data.o)) for row in data.X)


def _about(limit: float) -> list[float]:
    """The float nearest to a critical value, its neighbours, half of it and more than it."""
    near = [float(np.nextafter(limit, end)) for end in (0.0, np.inf)]
    return [x for x in (HALF * limit, *near, limit, CLEARLY * limit) if math.isfinite(x)]


def _zero_is_not_optimal(problem: Problem) -> str:
    """What contradicts F* = ||o||^2; empty if nothing."""
    target = squares(rationals(problem.o))
    a, b = -2 * rationals(problem.o), rationals([0.0] * problem.n)
    if not is_dual_feasible(problem, a, b) or dual_objective(problem, a, b) != target:
        return f"(-2o, 0) proves nothing at lambda2 = {problem.lambda2!r}"
    if not critical.zero_is_optimal(problem):
        return f"`zero_is_optimal` denies it at lambda2 = {problem.lambda2!r}"
    proof = solving.solve(problem).certificate
    if Fraction(proof.lower) > target or proof.upper < target:
        return f"[{proof.lower!r}, {proof.upper!r}] misses ||o||^2 = {number(target)!r}"
    return ""


def _zero_is_optimal_below(problem: Problem, j: int, correlation: Fraction) -> str:
    """What contradicts F* < ||o||^2, shown by w = s e_j, u = 0; empty if nothing."""
    data = ExactProblem.of(problem)
    step = (abs(correlation) - data.lambda2) / (2 * (squares(data.X[j]) + data.lambda1))
    w, u = rationals([0.0] * problem.n), rationals([0.0] * problem.d)
    w[j] = step if correlation > 0 else -step
    value, target = objective(problem, w, u).upper, squares(data.o)
    if not value < target:
        return f"lambda2 = {problem.lambda2!r}: F = {number(value)!r} is not below {number(target)!r}"
    if critical.zero_is_optimal(problem):
        return f"`zero_is_optimal` says so at lambda2 = {problem.lambda2!r}, but F = {number(value)!r} exists"
    lower = solving.solve(problem).certificate.lower
    if Fraction(lower) > value:
        return f"lower = {lower!r} at lambda2 = {problem.lambda2!r}, but F = {number(value)!r} exists"
    return ""


def observe_lambda3(problem: Problem, source: Source) -> Iterator[Observation]:
    """Compare F* at the critical lambda3 with F* far beyond it, and look for u = 0 at 0.9 of it."""
    part = "F3/critical_lambda3"
    value, radius = _lambda3_max(problem)
    lambdas = [max(0.0, BELOW * value - radius), BEYOND * value + radius, FAR * (value + radius)]
    if not all(math.isfinite(x) for x in lambdas):
        yield Observation(part, Outcome.SKIPPED, detail="the critical lambda3 is beyond float64")
        return
    below, at, far = (solving.solve(with_lambdas(problem, lambda3=x)) for x in lambdas)
    proofs = at.certificate, far.certificate
    if Status.NOT_CERTIFIED in (at.status, far.status) or not _finite(at, far):
        yield Observation(part, Outcome.UNDECIDED, detail="an answer is not certified, or no float")
        return
    short = Fraction(proofs[1].lower) - Fraction(proofs[0].upper)
    detail = f"F* in [{proofs[0].lower!r}, {proofs[0].upper!r}] at lambda3 = {lambdas[1]!r}, "
    detail += f"in [{proofs[1].lower!r}, {proofs[1].upper!r}] far beyond"
    needless = lambdas[0] > 0.0 and bool(below.certificate.zero_modalities.all())
    if needless:
        detail = f"u = 0 is proved optimal at lambda3 = {lambdas[0]!r} already, below {value!r}"
    yield Observation.of(part, short <= 0 and not needless, share(short, Fraction(proofs[1].upper)), detail)


def _lambda3_max(problem: Problem) -> tuple[float, float]:
    """The critical lambda3, and how far its solution's gap may have put it off.

    Formula: 2 lambda1 max_i ||X_i'w||; a point with u = 0 and a gap has ||X'(w - w*)||^2 <= gap.
    """
    behind: list[Solution] = []

    def solve(posed: Problem) -> Solution:
        behind.append(solving.solve(posed))
        return behind[-1]

    try:
        value = critical.lambda3_max(problem, solve)
    except OverflowError:
        return math.inf, 0.0
    if not behind:
        return value, 0.0
    scaling, solution = Scaling.of(problem), behind[-1]
    radius = 2.0 * solution.problem.lambda1 * math.sqrt(solution.duality_gap())
    with np.errstate(all="ignore"):
        return value, float(np.ldexp(radius, 2 * scaling.x + scaling.o))


def _finite(*solutions: Solution) -> bool:
    ends = [x for each in solutions for x in (each.certificate.lower, each.certificate.upper)]
    return bool(np.isfinite(ends).all())


CHECKS = (
    Check("critical lambda2", ("F3/critical_lambda2",), observe_lambda2, share=0.5),
    Check("critical lambda3", ("F3/critical_lambda3",), observe_lambda3, share=0.5),
)
