"""B2 and F3 by cases: every problem is answered, and no statement of a certificate is false."""

from collections.abc import Iterator
from fractions import Fraction

import numpy as np

from convexperc.problem.problem import Problem
from convexperc.solution import batch as many
from convexperc.solution import single as solving
from convexperc.solution.answers import Answers
from convexperc.solution.solution import Solution, Status
from verification.checks.interface import REFEREED, Check, Observation
from verification.checks.measures import LARGEST_MEASURE, is_finite, number, share
from verification.exact import formulation, referee
from verification.exact.numbers import Enclosure
from verification.ledger.evidence import Outcome
from verification.problems.sources import Source

RARE = 9
"""One answer of this many and one goes to the exact referee."""
ZEROS = ("w*", "u*")
"""How the referee's words on proved zeros begin."""


def observe_answer(problem: Problem, source: Source) -> Iterator[Observation]:
    """Solve, and let the referee judge every statement of some certificates."""
    solution = solving.solve(problem)
    proof, done = solution.certificate, solution.status is not Status.NOT_CERTIFIED
    detail = f"{solution.solver}: gap {proof.gap!r}, [{proof.lower!r}, {proof.upper!r}]"
    yield Observation.of("B2/answered", done, _width(solution), detail)
    if source.integer(0, RARE):
        return
    truth = referee.optimum(problem)
    false = referee.violations(problem, solution.w, solution.u, proof, truth)
    false += _false_intervals(solution)
    yield Observation.of("B2/true", not false, float(len(false)), "; ".join(false))
    zeros = [each for each in false if each.startswith(ZEROS)]
    if not (proof.zero_views.any() or proof.zero_modalities.any()):
        yield Observation("F3/exact_zeros", Outcome.SKIPPED, detail="nothing is proved to be 0")
        return
    zeros += _entries_left(solution)
    yield Observation.of("F3/exact_zeros", not zeros, float(len(zeros)), "; ".join(zeros))


def _width(solution: Solution) -> float:
    """What is proved: the gap, or the width of an enclosed optimum, as a share of F* or of ||o||^2."""
    proof = solution.certificate
    if not proof.certified and proof.enclosed:
        return share(Fraction(proof.upper) - Fraction(proof.lower), Fraction(proof.lower))
    return min(proof.relative_gap, proof.share_of_target, LARGEST_MEASURE)


def _false_intervals(solution: Solution) -> list[str]:
    """F(w, u) against the interval, exactly: it may not lie below F*."""
    if not is_finite(solution.w, solution.u):
        return []
    value = formulation.objective(solution.problem, solution.w, solution.u)
    lower = solution.certificate.lower
    return [f"lower {lower!r} > F(w, u) = {number(value.upper)!r}"] if lower > value.upper else []


def _entries_left(solution: Solution) -> list[str]:
    """Entries that are proved to be 0 must be 0 in a certified answer, not merely small."""
    if solution.status is not Status.CERTIFIED:
        return []
    proof, modalities = solution.certificate, solution.problem.modalities
    left = [f"w_{j} is not 0" for j in np.flatnonzero(proof.zero_views & (solution.w != 0.0))]
    for i, columns in enumerate(modalities):
        if proof.zero_modalities[i] and solution.u[columns].any():
            left.append(f"u^{i} is not 0")
    return left


def observe_batch(problem: Problem, source: Source) -> Iterator[Observation]:
    """Solve a small library in one batch; its intervals and its u against the referee or single answers."""
    templates = [problem.o]
    for _ in range(source.integer(1, 3)):
        at = source.integer(0, len(templates))
        templates.append(templates[at] if at < len(templates) else source.matrix(1, problem.d)[0])
    lambda1, lambda2, lambda3 = problem.lambdas
    answers = many.solve_many(
        problem.X, np.stack(templates).T, modalities=problem.modalities,
        lambda1=lambda1, lambda2=lambda2, lambda3=lambda3,
    )  # fmt: skip
    exactly = source.integer(0, RARE) == 0
    wrong = []
    for j, o in enumerate(templates):
        posed = problem.for_template(o)
        truth = referee.optimum(posed).value if exactly else _single(posed)
        wrong += [f"template {j}: {each}" for each in _false_answers(answers, j, posed, truth)]
    yield Observation.of("B2/batch", not wrong, float(len(wrong)), "; ".join(wrong))


def _single(problem: Problem) -> Enclosure:
    """F* as `solve` encloses it, its upper end exactly F at its point, or by the referee."""
    solution = solving.solve(problem)
    if not is_finite(solution.w, solution.u):
        return referee.optimum(problem).value
    upper = formulation.objective(problem, solution.w, solution.u).upper
    return Enclosure(Fraction(solution.certificate.lower), upper)


def _false_answers(answers: Answers, j: int, problem: Problem, truth: Enclosure) -> list[str]:
    lower, upper, gap = (float(part[j]) for part in (answers.lower, answers.upper, answers.gap))
    found = []
    if lower > truth.upper or upper < truth.lower:
        found.append(f"[{lower!r}, {upper!r}] misses F* = {number(truth.upper)!r}")
    w, u = np.asarray(answers.w[j]), answers.u(j)
    if not is_finite(w, u):
        if np.isfinite(gap):
            found.append(f"gap {gap!r} of a point that is not finite")
        return found
    above = formulation.objective(problem, w, u).lower - truth.upper
    if np.isfinite(gap) and above > Fraction(gap):
        found.append(f"F(w, u) - F* is {number(above)!r}, more than the gap {gap!r}")
    if answers.status(j) is Status.NOT_CERTIFIED:
        found.append(f"not answered: gap {gap!r}")
    return found


CHECKS = (
    Check("answer", ("B2/answered", "B2/true", "F3/exact_zeros"), observe_answer, share=0.1),
    Check("batch", ("B2/batch",), observe_batch, REFEREED, share=0.1),
)
