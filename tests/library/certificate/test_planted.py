"""Wrong answers are never certified, and where the search for a proof ends decides nothing.

Faults of the certificate itself are planted by the mutation test, tests/verifier/faults/test_hunt.py.
"""

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pytest

from convexperc.certificate import certificate, duality
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


def contradictions(bench: list[Judged]) -> Iterator[str]:
    for each in bench:
        for (w, u), thorough in itertools.product(each.points, (False, True)):
            proof = certify(each.problem, w, u, thorough=thorough)
            yield from (
                f"{each.name}: {false}" for false in violations(each.problem, w, u, proof, each.truth)
            )


def test_the_certificate_as_it_is_contradicts_nothing(bench: list[Judged]) -> None:
    found = list(contradictions(bench))
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


def test_where_the_search_ends_decides_nothing(bench: list[Judged], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(certificate.Certifier, "_is_enough", lambda judge, gap, lower: True)
    found = list(contradictions(bench))
    assert not found, found


def test_the_pull_of_the_modalities_doubled_is_caught(
    bench: list[Judged], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The few problems of a quick search do not show this fault: it takes points that are nearly optimal."""
    true = duality.inner_by_group
    monkeypatch.setattr(duality, "inner_by_group", lambda x, y, g: tuple(2.0 * end for end in true(x, y, g)))
    assert any(contradictions(bench))
