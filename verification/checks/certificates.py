"""B2 by cases: every problem is answered, and no statement of a certificate or of a batch is false."""

from collections.abc import Iterator
from fractions import Fraction

import numpy as np

from convexperc.problem.problem import Problem
from convexperc.solution import single as solving
from convexperc.solution.answers import Answers
from convexperc.solution.solution import Solution, Status
from verification.checks.acceptance import false_zeros, wrongly_certified, wrongly_enclosed
from verification.checks.interface import REFEREED, Check, Observation
from verification.checks.libraries import Drawn, drawn_templates, solved
from verification.checks.measures import LARGEST_MEASURE, is_finite, number, share
from verification.exact import formulation, referee
from verification.ledger.evidence import Outcome
from verification.problems.sources import Source

ZEROS = ("w*", "u*")
"""How the words on proved zeros begin."""


def observe_answer(problem: Problem, source: Source) -> Iterator[Observation]:
    """Solve, and let the referee judge every statement of the certificate."""
    solution = solving.solve(problem)
    proof, done = solution.certificate, solution.status is not Status.NOT_CERTIFIED
    detail = f"{solution.solver}: gap {proof.gap!r}, [{proof.lower!r}, {proof.upper!r}]"
    yield Observation.of("B2/answered", done, _width(solution), detail)
    truth = referee.optimum(problem)
    false = referee.violations(problem, solution.w, solution.u, proof, truth)
    false += _false_status(solution, truth)
    zeros = false_zeros(problem, proof.zero_views, proof.zero_modalities, truth)
    yield Observation.of("B2/true", not (false or zeros), float(len(false + zeros)), "; ".join(false + zeros))
    if not (proof.zero_views.any() or proof.zero_modalities.any()):
        yield Observation("B2/zeros", Outcome.SKIPPED, detail="nothing is proved to be 0")
        return
    zeros += [each for each in false if each.startswith(ZEROS)] + _entries_left(solution)
    yield Observation.of("B2/zeros", not zeros, float(len(zeros)), "; ".join(zeros))


def _width(solution: Solution) -> float:
    """What is proved: the gap, or the width of an enclosed optimum, as a share of F* or of ||o||^2."""
    proof = solution.certificate
    if not proof.certified and proof.enclosed:
        return share(Fraction(proof.upper) - Fraction(proof.lower), Fraction(proof.lower))
    return min(proof.relative_gap, proof.share_of_target, LARGEST_MEASURE)


def _false_status(solution: Solution, truth: referee.Optimum) -> list[str]:
    """F(w, u) against the interval and the status, exactly: it may not lie below F*, nor far above."""
    proof = solution.certificate
    if solution.status is Status.ENCLOSED:
        return wrongly_enclosed(proof.lower, proof.upper, solution.problem, truth)
    if not is_finite(solution.w, solution.u):
        return []
    value = formulation.objective(solution.problem, solution.w, solution.u)
    if proof.lower > value.upper:
        return [f"lower {proof.lower!r} > F(w, u) = {number(value.upper)!r}"]
    certified = solution.status is Status.CERTIFIED
    return wrongly_certified(proof.gap, solution.problem, truth) if certified else []


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
    """Solve a small library in one batch, after another one or not; every statement against the referee."""
    library = drawn_templates(problem, source)
    answers, how = solved(library, source)
    wrong = _false_answers(answers, library)
    yield Observation.of("B2/batch", not wrong, float(len(wrong)), f"{how}: {'; '.join(wrong)}")


def _false_answers(answers: Answers, library: Drawn) -> list[str]:
    wrong = []
    for j, posed in enumerate(library.problems):
        found = _false_answer(answers, j, posed, referee.optimum(posed))
        wrong += [f"template {j}: {each}" for each in found]
    return wrong


def _false_answer(answers: Answers, j: int, problem: Problem, truth: referee.Optimum) -> list[str]:
    lower, upper, gap = (float(part[j]) for part in (answers.lower, answers.upper, answers.gap))
    status, found = answers.status(j), []
    if lower > truth.value.upper or upper < truth.value.lower:
        found.append(f"[{lower!r}, {upper!r}] misses F* = {number(truth.value.upper)!r}")
    found += false_zeros(problem, answers.zero_views[j], answers.zero_modalities[j], truth)
    if status is Status.NOT_CERTIFIED:
        found.append(f"not answered: gap {gap!r}")
    if status is Status.ENCLOSED:
        found += wrongly_enclosed(lower, upper, problem, truth)
    if status is Status.CERTIFIED:
        found += wrongly_certified(gap, problem, truth)
    w, u = np.asarray(answers.w[j]), answers.u(j)
    if not is_finite(w, u):
        return [*found, f"gap {gap!r} of a point that is not finite"] if np.isfinite(gap) else found
    value = formulation.objective(problem, w, u)
    if np.isfinite(gap) and value.lower - truth.value.upper > Fraction(gap):
        above = number(value.lower - truth.value.upper)
        found.append(f"F(w, u) - F* is {above!r}, more than the gap {gap!r}")
    return found


CHECKS = (
    Check("answer", ("B2/answered", "B2/true", "B2/zeros"), observe_answer, share=1.5, refereed=True),
    Check("batch", ("B2/batch",), observe_batch, REFEREED, share=0.1),
)
