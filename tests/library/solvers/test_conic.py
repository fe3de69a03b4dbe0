import pickle
from collections import Counter

import cvxpy as cp
import numpy as np
import pytest
from cvxpy.reductions.solution import Solution
from cvxpy.reductions.solvers.solving_chain import SolvingChain

from convexperc.errors import SolverError
from convexperc.problem.formulation import objective
from convexperc.problem.problem import Problem
from convexperc.problem.scaling import Scaling
from convexperc.solution.single import solve
from convexperc.solvers.conic import Conic, Model, ModelCache

INSTANCES = 20


def instance(seed, scale=1.0, o_seed=None):
    random = np.random.default_rng(seed)
    X, o = random.normal(size=(4, 12)), random.normal(size=12)
    one, two, three = random.uniform(0.1, 2.0, 3)
    if o_seed is not None:
        o = np.random.default_rng(o_seed).normal(size=12)
    return Problem(
        X, scale * o, modalities=[3, 4, 5], lambda1=one, lambda2=scale * two, lambda3=scale * three
    )


def smallest(o):
    """(w - o)^2 + (u - w)^2 + o|w|/2 + o|u|/4, whose optimum is 19 o^2 / 32."""
    return Problem([[1.0]], [o], lambda1=1, lambda2=o / 2, lambda3=o / 4)


def raw(problem):
    """The status that CVXPY and Clarabel report at default settings, and F at their point."""
    w, u = cp.Variable(problem.n), cp.Variable(problem.d)
    posed = cp.Problem(
        cp.Minimize(
            cp.sum_squares(problem.X.T @ w - problem.o)
            + problem.lambda1 * cp.sum_squares(problem.X @ u - w)
            + problem.lambda2 * cp.norm1(w)
            + problem.lambda3 * sum(cp.norm2(u[c]) for c in problem.modalities)
        )
    )
    posed.solve(solver=cp.CLARABEL)
    return posed.status, np.nan if w.value is None else objective(problem, w.value, u.value)


@pytest.fixture(scope="module")
def unscaled():
    return [solve(instance(seed), Conic()).certificate for seed in range(INSTANCES)]


def test_the_model_is_disciplined_convex_and_parametrised():
    model = Model.of(instance(0))
    assert model.problem.is_dcp(dpp=True), str(model.problem)
    assert len(model.problem.parameters()) == 4, model.problem.parameters()
    assert {p.name() for p in model.problem.variables()} == {model.w.name(), model.u.name()}


def test_raw_answers_are_wrong_at_small_scale_though_claimed_optimal(unscaled):
    answers = [raw(instance(seed, 1e-8)) for seed in range(INSTANCES)]
    excess = [F / (1e-16 * proof.upper) - 1 for (_, F), proof in zip(answers, unscaled, strict=True)]
    wrong = sum(
        claim == "optimal" and value > 1e-3 for (claim, _), value in zip(answers, excess, strict=True)
    )
    assert wrong >= INSTANCES // 2, (Counter(claim for claim, _ in answers), excess)


def test_raw_answers_at_large_scale_are_claimed_infeasible():
    claims = Counter(raw(instance(seed, 1e8))[0] for seed in range(INSTANCES))
    assert claims["infeasible"] >= INSTANCES // 2, claims


def test_raw_answers_of_the_smallest_case():
    claim, F = raw(smallest(1e-8))
    assert claim == "optimal"
    assert pytest.approx(1.263, abs=0.01) == F / (19 / 32 * 1e-16)
    assert raw(smallest(1.0))[1] == pytest.approx(19 / 32, rel=1e-6)
    assert raw(smallest(1e8))[0] == "infeasible"


@pytest.mark.parametrize("o", [1e-150, 1e-8, 1.0, 1e8, 1e150])
def test_the_smallest_case_is_certified_at_every_scale(o):
    found = solve(smallest(o), Conic())
    assert found.certificate.certified, (found.solver_status, found.certificate.relative_gap)
    assert found.w[0] / o == pytest.approx(5 / 8, rel=1e-6)
    exact = 19 / 32 * o * o
    assert found.certificate.lower <= exact * (1 + 1e-15), (found.certificate.lower, exact)
    assert exact * (1 - 1e-15) <= found.certificate.upper <= exact * (1 + 1e-9), found.certificate.upper


@pytest.mark.parametrize("scale", [1e-8, 1e-4, 1e8])
def test_every_scaled_instance_is_certified_with_the_scaled_optimum(scale, unscaled):
    for seed, base in enumerate(unscaled):
        found = solve(instance(seed, scale), Conic())
        proof = found.certificate
        assert proof.certified, (seed, found.solver_status, proof.relative_gap)
        low, high = proof.lower / scale**2, proof.upper / scale**2
        assert low <= base.upper * (1 + 1e-14), (seed, low, base.upper)
        assert base.lower <= high * (1 + 1e-14), (seed, base.lower, high)
        assert high / base.lower - 1 <= 1e-9, (seed, high / base.lower - 1, found.solver_status)


def test_one_model_serves_every_template_and_every_lambda(monkeypatch):
    compiled = []
    original = Model.of.__func__
    monkeypatch.setattr(
        Model, "of", classmethod(lambda cls, problem: compiled.append(problem) or original(cls, problem))
    )
    conic, normal = Conic(), [instance(0, o_seed=seed) for seed in range(5)]
    reused = [conic.solve(problem) for problem in normal]
    assert len(compiled) == 1, len(compiled)
    for problem, warm in zip(normal, reused, strict=True):
        cold = Conic().solve(problem)
        assert objective(problem, warm.w, warm.u) == pytest.approx(
            objective(problem, cold.w, cold.u), rel=1e-10
        )
        assert warm.w == pytest.approx(cold.w, abs=1e-5)
    again = conic.solve(normal[0])
    assert objective(normal[0], again.w, again.u) == pytest.approx(
        objective(normal[0], reused[0].w, reused[0].u), rel=1e-10
    )
    assert len(compiled) == 6, len(compiled)


def test_the_cache_tells_data_and_partitions_apart_and_stays_small():
    cache, first = ModelCache(2), instance(0)
    model = cache.model(first)
    regrouped = Problem(first.X, first.o, modalities=[5, 7], lambda1=1, lambda2=1, lambda3=1)
    other = cache.model(regrouped)
    assert other is not model
    assert cache.model(instance(0, 8.0, o_seed=3)) is model
    third = cache.model(instance(1))
    assert cache.model(first) is model
    assert cache.model(instance(1)) is third
    assert cache.model(regrouped) is not other


@pytest.mark.parametrize("used", [False, True])
def test_a_solver_pickles_without_its_models(used):
    conic = Conic(tolerance=1e-11, max_iterations=77)
    problem = Scaling.of(instance(0)).normalise(instance(0))
    if used:
        conic.solve(problem)
    again = pickle.loads(pickle.dumps(conic))
    assert again == conic
    assert again.max_iterations == 77
    assert again.solve(problem).w == pytest.approx(conic.solve(problem).w, abs=1e-6)


@pytest.mark.parametrize("kind", [cp.error.SolverError, ValueError, ZeroDivisionError, OverflowError])
def test_foreign_failures_become_ours(monkeypatch, kind):
    def fail(self, *args, **settings):
        raise kind("it broke")

    monkeypatch.setattr(cp.Problem, "get_problem_data", fail)
    with pytest.raises(SolverError, match="it broke") as caught:
        Conic().solve(instance(0))
    assert isinstance(caught.value.__cause__, kind), caught.value.__cause__
    assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)


@pytest.mark.parametrize(
    ("status", "must"), [(cp.INFEASIBLE, "must return a point"), (cp.SOLVER_ERROR, "must not fail")]
)
def test_no_point_is_an_error_even_after_a_success(monkeypatch, status, must):
    conic = Conic()
    conic.solve(instance(0))
    nothing = Solution(status, np.nan, {}, {}, {})
    monkeypatch.setattr(SolvingChain, "invert", lambda self, raw, inverse: nothing)
    with pytest.raises(SolverError, match=must) as caught:
        conic.solve(instance(0, o_seed=5))
    assert caught.value.value == status, caught.value


def test_an_answer_does_not_depend_on_what_was_solved_before():
    conic = Conic()
    first, other, again = (conic.solve(instance(0, o_seed=seed)) for seed in (1, 2, 1))
    assert (first.w.tobytes(), first.u.tobytes()) == (again.w.tobytes(), again.u.tobytes())
    assert first.w.tobytes() != other.w.tobytes()


def test_few_iterations_are_an_uncertified_answer_and_no_error():
    found = solve(instance(0), Conic(max_iterations=3))
    assert not found.certificate.certified, (found.solver_status, found.certificate.relative_gap)
    assert found.solver_status != "optimal"
    assert found.iterations <= 3, found.iterations


def test_a_limit_of_time_ends_the_search_and_the_status_says_so():
    found = solve(instance(0), Conic(time_limit=1e-9))
    assert found.solver_status == "user_limit; the time limit of 1e-09 s is reached"
    assert not found.certificate.certified, found.certificate.relative_gap
    assert solve(instance(0), Conic()).solver_status == "optimal"
