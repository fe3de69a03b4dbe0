import itertools
import signal
from concurrent.futures import ThreadPoolExecutor
from fractions import Fraction
from types import SimpleNamespace

import numpy as np
import osqp
import pytest

from convexperc.errors import SolverError
from convexperc.problem.problem import Problem
from convexperc.problem.scaling import Scaling
from convexperc.solution.single import solve
from convexperc.solution.solution import Status
from convexperc.solvers.conic import Conic
from convexperc.solvers.osqp import Quadratic, is_quadratic


def instance(seed, shape=(3, 5), lambdas=(0.7, 0.3, 0.2), spec=(1, 1, 1, 1, 1)):
    random = np.random.default_rng(seed)
    one, two, three = lambdas
    X, o = random.normal(size=shape), random.normal(size=shape[1])
    return Problem(X, o, modalities=list(spec), lambda1=one, lambda2=two, lambda3=three)


CASES = [
    *((lambdas, (1,) * 5) for lambdas in itertools.product((0.0, 0.7), (0.0, 0.3), (0.0, 0.2))),
    ((0.7, 0.3, 0.0), (2, 3)),
    ((50.0, 0.01, 0.0), (5,)),
]


@pytest.mark.parametrize(("lambdas", "spec"), CASES)
@pytest.mark.parametrize("shape", [(3, 5), (6, 5), (1, 5)])
def test_two_independent_solvers_agree_within_their_certified_gaps(lambdas, spec, shape):
    problem = instance(1, shape, lambdas, spec)
    first, second = solve(problem, Conic()), solve(problem, Quadratic())
    a, b = first.certificate, second.certificate
    assert a.certified, (first.solver_status, a.relative_gap, a.share_of_target)
    assert a.lower <= b.upper, (a.lower, b.upper)
    assert b.lower <= a.upper, (b.lower, a.upper)
    for mine, other in ((a, b), (b, a)):
        excess = Fraction(mine.objective[0]) - Fraction(other.objective[1])
        assert excess <= Fraction(mine.gap), (float(excess), mine.gap)
    assert second.solver == "osqp"
    assert b.relative_gap < 1e-6 or b.share_of_target < 1e-9, (
        second.solver_status,
        b.relative_gap,
        b.share_of_target,
    )


@pytest.mark.parametrize("scale", [1e-100, 1e-8, 1e8, 1e100])
def test_scale_does_not_matter(scale):
    base = instance(2)
    moved = Problem(
        base.X,
        scale * base.o,
        modalities=base.modalities,
        lambda1=0.7,
        lambda2=scale * 0.3,
        lambda3=scale * 0.2,
    )
    first, second = solve(base, Quadratic()), solve(moved, Quadratic())
    assert second.value / scale**2 == pytest.approx(first.value, rel=1e-8)


@pytest.mark.parametrize("spec", [(2, 3), (5,), (1, 1, 1, 2)])
def test_what_is_no_quadratic_programme_is_refused(spec):
    problem = instance(0, spec=spec)
    assert not is_quadratic(problem), spec
    with pytest.raises(SolverError) as caught:
        Quadratic().solve(problem)
    assert (caught.value.what, caught.value.value) == ("lambda3", 0.2)
    assert is_quadratic(instance(0, spec=spec, lambdas=(1.0, 1.0, 0.0))), spec


@pytest.mark.parametrize("tolerance", [0.1, 1e-2])
def test_the_claim_solved_certifies_nothing(tolerance):
    class Unpolished(Quadratic):
        """OSQP's point as ADMM leaves it: moved by as much as its own tolerance allows."""

        def solve(self, problem):
            found = super().solve(problem)
            found.w[:] += tolerance
            return found

    found = solve(instance(3), Unpolished(tolerance=tolerance))
    assert found.solver_status == "solved"
    assert found.status is Status.NOT_CERTIFIED, found.certificate.relative_gap


def test_the_claim_of_failure_refutes_nothing():
    stopped = solve(instance(3), Quadratic(max_iterations=1))
    assert stopped.solver_status != "solved"
    assert stopped.iterations <= 1, stopped.iterations
    best = solve(instance(3), Conic()).certificate
    assert stopped.certificate.lower <= best.upper, (stopped.certificate.lower, best.upper)
    assert best.lower <= stopped.value, (best.lower, stopped.value)
    assert stopped.certificate.certified == (stopped.certificate.relative_gap <= 1e-8), stopped.certificate


def test_the_candidate_has_the_shapes_of_the_problem_and_no_state():
    problem = Scaling.of(instance(4)).normalise(instance(4))
    first, second = Quadratic().solve(problem), Quadratic().solve(problem)
    assert (first.w.shape, first.u.shape) == ((3,), (5,))
    assert first.w.tobytes() == second.w.tobytes()
    assert first.dual is None


@pytest.fixture
def interrupts():
    """The signals SIGINT that reach Python."""
    seen: list[int] = []
    before = signal.signal(signal.SIGINT, lambda number, frame: seen.append(number))
    yield seen
    signal.signal(signal.SIGINT, before)


def test_solvers_at_once_leave_the_handler_of_interrupts(interrupts):
    with ThreadPoolExecutor(8) as pool:
        list(pool.map(Quadratic().solve, [instance(seed, (20, 5)) for seed in range(64)]))
    signal.raise_signal(signal.SIGINT)
    assert interrupts == [signal.SIGINT]


def test_an_interrupt_that_osqp_takes_is_passed_on(interrupts, monkeypatch):
    info = SimpleNamespace(
        status_val=osqp.SolverStatus.OSQP_SIGINT, status="interrupted", iter=1, run_time=0.0
    )
    stopped = SimpleNamespace(x=None, info=info)
    monkeypatch.setattr(osqp.OSQP, "solve", lambda self, **settings: stopped)
    with pytest.raises(SolverError, match="interrupted"):
        Quadratic().solve(instance(0))
    assert interrupts == [signal.SIGINT]


def test_a_limit_of_time_ends_the_search_and_the_status_says_so():
    found = solve(instance(3), Quadratic(time_limit=1e-9))
    assert found.solver_status.endswith("; the time limit of 1e-09 s is reached"), found.solver_status
    assert found.iterations <= 1, found.iterations
    assert found.status is Status.NOT_CERTIFIED, found.certificate
    assert solve(instance(3), Quadratic()).solver_status == "solved"
