import math
import pickle
from dataclasses import dataclass

import numpy as np
import pytest

from convexperc.certificate.lambda_max import lambda2_max
from convexperc.errors import InputError, SolverError
from convexperc.problem.problem import Problem, same_data
from convexperc.solution.single import solve
from convexperc.solution.solution import Status
from convexperc.solvers.conic import Conic
from convexperc.solvers.interface import SolverResult
from convexperc.solvers.osqp import Quadratic


@dataclass(frozen=True)
class Fixed:
    """Answers with the same numbers. Normalised, X = 1/2: the optimum of `smallest` is (5/8, 1)."""

    w: tuple[float, ...]
    u: tuple[float, ...]
    claim: str = "optimal"
    dual: tuple[tuple[float, ...], tuple[float, ...]] | None = None
    name: str = "fixed"

    def solve(self, problem):
        dual = None if self.dual is None else tuple(map(np.array, self.dual))
        return SolverResult(np.array(self.w), np.array(self.u), self.claim, 7, dual)


@dataclass(frozen=True)
class Failing:
    error: Exception
    name: str = "failing"

    def solve(self, problem):
        raise self.error


def smallest(o=1.0):
    """F* = 19 o^2 / 32 at w = 5 o / 8, u = o / 2."""
    return Problem([[1.0]], [o], lambda1=1, lambda2=o / 2, lambda3=o / 4)


def test_a_true_answer_is_certified_whatever_its_claim():
    found = solve(smallest(), Fixed((0.625,), (1.0,), claim="infeasible"))
    assert found.status is Status.CERTIFIED, found.certificate
    assert (found.w.tolist(), found.u.tolist()) == ([0.625], [0.5])
    assert (found.solver, found.solver_status, found.iterations) == ("fixed", "infeasible", 7)


@pytest.mark.parametrize(
    ("w", "u"),
    [((0.6,), (0.2,)), ((1e300,), (-1e300,)), ((math.nan,), (0.0,)), ((0.0,), (math.inf,)), ((0.0,), (0.0,))],
)
@pytest.mark.parametrize("dual", [None, ((-1e6,), (1e6,)), ((math.nan,), (0.0,))])
def test_a_lying_solver_convinces_nobody(w, u, dual):
    found = solve(smallest(), Fixed(w, u, dual=dual))
    assert found.solver_status == "optimal"
    assert found.status is Status.NOT_CERTIFIED, found.certificate
    assert found.certificate.lower <= 19 / 32 <= found.certificate.upper, found.certificate
    assert np.isfinite(found.w).all(), found.w
    assert found.duality_gap() == found.certificate.gap > 0.0
    assert found.value >= 19 / 32, found.value


@pytest.mark.parametrize(("w", "u"), [((0.5, 0.5), (0.5,)), ((0.5,), ()), ((0.5,), (0.5, 0.5))])
def test_an_answer_of_the_wrong_shape_is_refused(w, u):
    with pytest.raises(InputError, match="must have shape"):
        solve(smallest(), Fixed(w, u))


@pytest.mark.parametrize("what", ["X", "o", "lambda1", "lambda2", "lambda3"])
def test_an_error_about_the_data_shows_them_as_they_were_given(what):
    class Particular:
        name = "particular"

        def solve(self, problem):
            value = getattr(problem, what)
            raise SolverError(what, value=value, must="must be another", remedy="Change it.") from cause

    cause = ArithmeticError("why")
    problem = Problem([[1e6, 2.0]], [1.0, 2.0], lambda1=0.3, lambda2=0.2, lambda3=0.1)
    with pytest.raises(SolverError, match=r"must be another; got .*\. Change it\.") as caught:
        solve(problem, Particular())
    assert caught.value.value is getattr(problem, what)
    assert caught.value.__cause__ is cause
    escalated = solve(problem, Particular(), escalate=True)
    assert escalated.solver_status == f"failed: {getattr(problem, what)}"
    with pytest.raises(SolverError, match=r"lambda3 must be 0, or .*; got 0\.1\."):
        solve(problem, Quadratic())


@pytest.mark.parametrize("error", [SolverError("mine", value=1, must="must not fail"), KeyError("foreign")])
def test_a_solver_that_raises_is_heard(error):
    with pytest.raises(type(error)) as caught:
        solve(smallest(), Failing(error))
    assert caught.value is error


@pytest.mark.parametrize(
    "error",
    [
        SolverError("mine", value=1, must="must not fail"),
        ZeroDivisionError("by 0"),
        np.linalg.LinAlgError("no"),
    ],
)
def test_ball_arithmetic_answers_where_a_solver_breaks_down(error):
    found = solve(smallest(), Failing(error), escalate=True)
    assert found.status is Status.CERTIFIED, found.certificate
    assert found.solver_status.startswith("failed: "), found.solver_status
    assert found.solver == "failing, then ball arithmetic", found.solver
    assert found.value == pytest.approx(19 / 32, rel=1e-8)
    with pytest.raises(TypeError):
        solve(smallest(), Failing(TypeError("a mistake in a program")), escalate=True)


@pytest.mark.parametrize("o", [1e-100, 1.0, 1e100])
def test_the_solver_sees_the_normalised_problem(o):
    seen = []

    class Watching(Conic):
        def solve(self, problem):
            seen.append(problem)
            return super().solve(problem)

    found = solve(smallest(o), Watching())
    assert 0.5 <= seen[0].X[0, 0] < 1, seen[0].X
    assert 0.5 <= seen[0].o[0] < 1, seen[0].o
    assert found.w[0] == pytest.approx(0.625 * o, rel=1e-7)
    assert found.status is Status.CERTIFIED, found.certificate


@pytest.mark.parametrize("factor", [1.0, 1.5, 1e6, 1e300])
def test_zero_is_the_answer_from_lambda2_max_on(factor):
    X, o = np.random.default_rng(5).normal(size=(3, 6)), np.arange(1.0, 7.0)
    critical = lambda2_max(Problem(X, o, lambda1=1, lambda2=0, lambda3=1))[1]
    problem = Problem(X, o, lambda1=1, lambda2=critical * factor, lambda3=1)
    found = solve(problem, Fixed((0.1, 0.1, 0.1), (0.0,) * 6))
    assert found.status is Status.CERTIFIED, found.certificate
    assert not found.w.any(), found.w
    assert not found.u.any(), found.u
    assert found.value == pytest.approx(91.0, rel=1e-14)
    assert found.modality_norms.tolist() == [0.0]


def test_a_zero_target_is_certified_at_zero():
    found = solve(
        Problem(np.eye(2), [0, 0], lambda1=1, lambda2=0.1, lambda3=0.1), Fixed((0.1, 0.0), (0.0, 0.0))
    )
    assert found.status is Status.CERTIFIED, found.certificate
    assert (found.value, found.certificate.lower, found.certificate.gap) == (0.0, 0.0, 0.0)


def test_tolerances_reach_the_certificate():
    answer = Fixed((0.62,), (1.0,))
    strict, loose = solve(smallest(), answer), solve(smallest(), answer, relative_tolerance=0.1)
    share = solve(smallest(), answer, relative_tolerance=0.0, absolute_tolerance=0.1)
    assert [s.status for s in (strict, loose, share)] == [
        Status.NOT_CERTIFIED,
        Status.CERTIFIED,
        Status.CERTIFIED,
    ]
    assert strict.is_optimal(strict.duality_gap()), strict.certificate
    assert not strict.is_optimal(0.0), strict.certificate


def test_timings_add_up():
    timings = solve(smallest(), Conic()).timings
    parts = timings.normalise, timings.solve, timings.certify
    assert min(parts) > 0.0, timings
    assert timings.total == pytest.approx(sum(parts))


def test_an_answer_is_read_only_and_pickles_as_such():
    problem = Problem(np.eye(2, 4), np.ones(4), modalities=[2, 2], lambda1=1, lambda2=0.1, lambda3=0.1)
    found = solve(problem, Conic())
    again = pickle.loads(pickle.dumps(found))
    assert same_data(again.problem, found.problem), again.problem
    assert (again.w.tolist(), again.u.tolist()) == (found.w.tolist(), found.u.tolist())
    assert again.certificate.gap == found.certificate.gap
    assert (again.status, again.timings) == (found.status, found.timings)
    for solution in (found, again):
        assert (solution.w.flags.writeable, solution.u.flags.writeable) == (False, False)


def test_without_a_solver_every_answer_is_certified_or_enclosed():
    for seed in range(6):
        rng = np.random.default_rng(seed)
        X = rng.normal(size=(4, 9)) * 10.0 ** rng.uniform(-6, 6, (4, 1))
        problem = Problem(X, rng.normal(size=9), lambda1=0.1, lambda2=0.1 * (seed % 2), lambda3=0.01)
        found = solve(problem)
        assert found.certificate.enclosed, (seed, found.solver, found.certificate)
        assert found.solver.startswith("newton"), found.solver


def test_what_is_no_solver_is_refused(interpreter):
    """In an interpreter of its own: the tests' type checks would refuse it before `solve` does."""
    code = """
from convexperc import Conic, Problem, solve
for solver in ("conic", Conic, 3):
    try:
        solve(Problem([[1.0]], [1.0], lambda1=1, lambda2=0, lambda3=1), solver)
    except ValueError as error:
        print(type(error).__name__, error)
"""
    done = interpreter.run(code)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert len(lines) == 3, done.stdout
    assert all(line.startswith("InputError solver must be a solver: an object with") for line in lines), lines
