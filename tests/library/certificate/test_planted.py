"""Planted faults: wrong answers are never certified, and every mutant of the certificate is caught."""

import itertools
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from convexperc.certificate import certificate, duality, evaluation, rounding
from convexperc.certificate import screening as optimum
from convexperc.certificate.certificate import certify
from convexperc.problem.problem import Problem
from convexperc.solution.single import solve
from convexperc.solution.solution import Status
from convexperc.solvers.interface import SolverResult
from convexperc.solvers.paper import CORRECTED
from convexperc.solvers.paper.loop import run
from verification.exact.formulation import objective
from verification.exact.referee import Optimum, violations
from verification.exact.referee import optimum as exact_optimum
from verification.problems.families import seeded

FAMILIES = (
    "random",
    "recognition",
    "one_column_modalities",
    "lambda1_zero",
    "lambda3_zero",
    "lambda2_zero",
    "lambda2_lambda3_zero",
)
SMALL = (4, 10)
SEEN = 1e-7
"""A true relative gap beyond this must never be certified at 1e-8, whatever its direction."""


@dataclass(frozen=True, eq=False)
class Judged:
    """A problem, what is true of it, and points from good to bad."""

    name: str
    problem: Problem
    truth: Optimum
    points: tuple[tuple[np.ndarray, np.ndarray], ...]


def judged(family: str, index: int) -> Judged:
    problem = seeded(family, 21, index, largest=SMALL)
    rng = np.random.default_rng(index)
    good = run(problem, variant=CORRECTED, max_iterations=400, on_singular="minimum_norm")
    noise_w, noise_u = rng.standard_normal(problem.n), rng.standard_normal(problem.d)
    points = [
        (good.w * (1 + size * noise_w), good.u * (1 + size * noise_u)) for size in (0.0, 1e-9, 1e-4, 0.1)
    ]
    points += [(noise_w, noise_u), (np.zeros(problem.n), np.zeros(problem.d))]
    return Judged(f"{family} {index}", problem, exact_optimum(problem), tuple(points))


@pytest.fixture(scope="module")
def bench() -> list[Judged]:
    return [judged(family, index) for family in FAMILIES for index in range(3)]


def contradictions(bench: list[Judged]) -> list[str]:
    found = []
    for each in bench:
        for (w, u), thorough in itertools.product(each.points, (False, True)):
            proof = certify(each.problem, w, u, thorough=thorough)
            found += [f"{each.name}: {false}" for false in violations(each.problem, w, u, proof, each.truth)]
    return found


def test_the_certificate_as_it_is_contradicts_nothing(bench: list[Judged]) -> None:
    found = contradictions(bench)
    assert not found, found
    assert all(each.truth.tight for each in bench), [each.name for each in bench if not each.truth.tight]


def test_a_point_that_is_off_is_never_certified(bench: list[Judged]) -> None:
    off = 0
    for each in bench:
        floor = 1e-12 * float(each.problem.o @ each.problem.o)
        for w, u in each.points:
            gap = float(objective(each.problem, w, u).lower - each.truth.value.upper)
            if gap > SEEN * float(each.truth.value.upper) + floor:
                off += 1
                proof = certify(each.problem, w, u)
                assert not proof.certified, (each.name, gap, proof)
    assert off >= len(bench), f"only {off} points were off"


@dataclass(frozen=True)
class Liar:
    """Answers with what it is told to, and calls it optimal."""

    w: tuple[float, ...]
    u: tuple[float, ...]
    dual: tuple[np.ndarray, np.ndarray] | None = None

    @property
    def name(self) -> str:
        return "liar"

    def solve(self, problem: Problem) -> SolverResult:
        return SolverResult(np.array(self.w), np.array(self.u), "optimal", 1, self.dual)


@pytest.mark.parametrize("value", [5.0, -1.0, 1e-9, 1e200, np.inf, np.nan])
def test_a_lying_solver_is_not_believed(value: float) -> None:
    problem = Problem([[1.0, 0.0], [3.0, 1.0]], [1.0, 0.0], lambda1=1, lambda2=1, lambda3=0)
    solution = solve(problem, Liar((value,) * problem.n, (value,) * problem.d))
    assert solution.solver_status == "optimal", solution.solver_status
    assert solution.status is Status.NOT_CERTIFIED, (value, solution.certificate)
    assert not solution.is_optimal(solution.certificate.lower * 1e-6), (value, solution.certificate)


@pytest.mark.parametrize("factor", [10.0, -1.0, np.nan])
def test_a_lying_dual_point_is_not_believed(bench: list[Judged], factor: float) -> None:
    for each in bench:
        p = each.problem
        dual = np.full(p.d, -factor), np.full(p.n, factor)
        for w, u in each.points:
            proof = certify(p, w, u, dual=dual)
            false = violations(p, w, u, proof, each.truth)
            assert not false, (each.name, factor, false)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_a_point_that_is_not_finite_proves_nothing(bench: list[Judged], bad: float) -> None:
    for each in bench:
        w, u = (part.copy() for part in each.points[0])
        w[0] = bad
        proof = certify(each.problem, w, u)
        assert not proof.certified, (each.name, bad, proof)
        assert (proof.gap, proof.objective[1]) == (np.inf, np.inf), (each.name, bad, proof)
        assert proof.lower <= each.truth.value.upper, (each.name, bad, proof.lower)


Patch = Callable[[pytest.MonkeyPatch], None]


def wrapped(module: Any, name: str, change: Callable[[Any], Any]) -> Patch:
    """A mutant that changes what one function returns."""
    original = getattr(module, name)
    return lambda patch: patch.setattr(module, name, lambda *a, **k: change(original(*a, **k)))


def replaced(module: Any, name: str, value: Any) -> Patch:
    """A mutant that has another function in one place."""
    return lambda patch: patch.setattr(module, name, value)


def together(*patches: Patch) -> Patch:
    """Several changes that make one fault."""

    def apply(patch: pytest.MonkeyPatch) -> None:
        for each in patches:
            each(patch)

    return apply


def frame_with(**change: Callable[[tuple[float, float]], tuple[float, float]]) -> Patch:
    """A mutant whose normalised lambdas are wrong."""
    original = evaluation.NormalizedData.of

    def of(problem: Problem, scaling: Any) -> evaluation.NormalizedData:
        true = original(problem, scaling)
        return replace(true, **{name: rule(getattr(true, name)) for name, rule in change.items()})

    return lambda patch: patch.setattr(evaluation.NormalizedData, "of", of)


def times(factor: float) -> Callable[[tuple[float, float]], tuple[float, float]]:
    return lambda bounds: (factor * bounds[0], factor * bounds[1])


def swapped(bounds: tuple[float, float]) -> tuple[float, float]:
    return bounds[1], bounds[0]


NO_MODALITY_ERROR: Patch = replaced(duality, "_modality_term", lambda frame, point, dual: 0.0)

MUTANTS: dict[str, Patch] = {
    "feasible scaling not applied, excess not seen": together(
        replaced(duality, "_ratio", lambda limit, norm: np.inf),
        replaced(duality, "_excess", lambda s, x, limit: 0.0),
    ),
    "excess not charged": replaced(certificate, "_cost", lambda frame, candidate, upper: 0.0),
    "weights of the charge taken as 0": together(
        replaced(certificate, "view_weight_bound", lambda frame, upper: 0.0),
        replaced(certificate, "modality_weight_bound", lambda frame, upper: 0.0),
    ),
    "rounding dropped, directions swapped": together(
        replaced(rounding, "gamma", lambda k: 0.0),
        replaced(duality, "up", rounding.down),
        replaced(duality, "down", rounding.up),
        replaced(certificate, "up", rounding.down),
        replaced(certificate, "down", rounding.up),
    ),
    "objective's bounds swapped": wrapped(evaluation, "objective_bounds", swapped),
    "dual value's bounds swapped": wrapped(certificate, "dual_value", lambda b: (b[1] * (1 + 1e-15), b[0])),
    "lambda2 halved": frame_with(lambda2=times(0.5)),
    "lambda3 halved": frame_with(lambda3=times(0.5)),
    "lambda1 halved": frame_with(lambda1=times(0.5)),
    "lambda2 doubled": frame_with(lambda2=times(2.0)),
    "dual quadratic not halved twice": wrapped(
        duality, "_value_parts", lambda parts: (parts[0], (0.5 * parts[1][0], 0.5 * parts[1][1]))
    ),
    "coupling left out of the dual value": replaced(
        duality,
        "_value_parts",
        lambda frame, a, b: (
            tuple(-x for x in reversed(rounding.inner(rounding.Ball.exact(a), frame.target))),
            (0.25 * float(a @ a) * (1 - 1e-15), 0.25 * float(a @ a) * (1 + 1e-15)),
        ),
    ),
    "modality term left out of the gap": NO_MODALITY_ERROR,
    "norms of the modalities taken as 0": wrapped(
        evaluation, "norms_by_group", lambda bounds: (0.0 * bounds[0], 0.0 * bounds[1])
    ),
    "pull of the modalities doubled": wrapped(
        duality, "inner_by_group", lambda bounds: (2.0 * bounds[0], 2.0 * bounds[1])
    ),
    "coupling term left out of the gap": replaced(duality, "_coupling_term", lambda frame, point, dual: 0.0),
    "gap taken at half": wrapped(
        certificate, "gap_terms", lambda terms: replace(terms, loss=0.5 * terms.loss, view_norm=0.0)
    ),
    "radius of proved zeros dropped": wrapped(
        certificate, "proved_zeros", lambda zeros: (np.ones_like(zeros[0]), zeros[1])
    ),
    "modalities proved zero for nothing": wrapped(
        certificate, "proved_zeros", lambda zeros: (zeros[0], np.ones_like(zeros[1]))
    ),
    "zeros proved with no gap": replaced(
        certificate, "proved_zeros", lambda frame, point, gap: optimum.proved_zeros(frame, point, 0.0)
    ),
    "least squares off by a bit": wrapped(certificate, "exact_optimum", lambda x: x and x * (1 + 2**-40)),
}


def test_where_the_search_ends_decides_nothing(bench: list[Judged], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(certificate.Certifier, "_is_enough", lambda judge, gap, lower: True)
    found = contradictions(bench)
    assert not found, found


@pytest.mark.parametrize("name", MUTANTS)
def test_every_mutant_is_caught(name: str, bench: list[Judged], monkeypatch: pytest.MonkeyPatch) -> None:
    MUTANTS[name](monkeypatch)
    found = contradictions(bench)
    assert found, f"the mutant {name!r} was not caught on {len(bench)} problems"
