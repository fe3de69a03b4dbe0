"""The proximal Newton method against the conic model, closed forms and its own warm start."""

import pickle

import numpy as np
import pytest

from convexperc.problem.problem import Problem
from convexperc.problem.reduction import Reduction
from convexperc.problem.scaling import Scaling
from convexperc.solution.batch import solve_many
from convexperc.solution.single import solve
from convexperc.solution.solution import Status
from convexperc.solvers.conic import Conic
from convexperc.solvers.newton.method import Newton

LAMBDAS = [1e-3, 0.1, 1.0, 10.0]


def random_problem(seed: int, lambdas=None) -> Problem:
    rng = np.random.default_rng(seed)
    n, d = int(rng.integers(1, 9)), int(rng.integers(2, 40))
    cut = int(rng.integers(1, d))
    X = rng.normal(size=(n, d)) if seed % 2 else rng.random((n, d))
    o = X.T @ rng.normal(size=n) + 0.1 * rng.normal(size=d)
    one, two, three = lambdas or (float(rng.choice(LAMBDAS)) for _ in range(3))
    return Problem(X, o, modalities=[cut, d - cut], lambda1=one, lambda2=two, lambda3=three)


@pytest.mark.parametrize("seed", range(30))
def test_it_finds_the_optimum_of_the_conic_model(seed):
    problem = random_problem(seed)
    found, reference = solve(problem, Newton()), solve(problem, Conic())
    assert found.status is Status.CERTIFIED, (found.certificate, found.iterations)
    assert found.certificate.relative_gap <= 1e-9 or found.certificate.share_of_target <= 1e-14, found
    assert found.certificate.lower <= reference.certificate.upper, (found.certificate, reference.certificate)
    assert reference.certificate.lower <= found.certificate.upper, (found.certificate, reference.certificate)


@pytest.mark.parametrize("zeros", range(1, 8))
@pytest.mark.parametrize("seed", range(4))
def test_every_lambda_may_be_zero(zeros, seed):
    lambdas = tuple(0.0 if zeros >> k & 1 else 0.1 for k in range(3))
    problem = random_problem(2 * seed + 1, lambdas)
    found, reference = solve(problem, Newton()), solve(problem, Conic(), escalate=True)
    assert found.status is Status.CERTIFIED, (lambdas, found.certificate)
    assert found.certificate.lower <= reference.certificate.upper, (found.certificate, reference.certificate)
    assert reference.certificate.lower <= found.certificate.upper, (found.certificate, reference.certificate)


@pytest.mark.parametrize("o", [1e-150, 1e-8, 1.0, 1e8, 1e150])
def test_the_smallest_case(o):
    problem = Problem([[1.0]], [o], lambda1=1, lambda2=o / 2, lambda3=o / 4)
    found = solve(problem, Newton())
    assert found.value == pytest.approx(19 / 32 * o * o, rel=1e-12), found.value
    assert found.w[0] == pytest.approx(5 / 8 * o, rel=1e-12), found.w


@pytest.mark.parametrize("seed", range(10))
def test_the_reduced_point_is_the_stationary_one(seed):
    problem = Scaling.of(random_problem(seed)).normalise(random_problem(seed))
    reduction = Reduction.of(problem.X, problem.modalities)
    batch = Newton().batch(
        reduction.G,
        reduction.K,
        (problem.X @ problem.o)[None, :],
        np.array([problem.o @ problem.o]),
        np.array([problem.lambdas]),
    )
    w, t, q = batch.W[0], batch.T[0], batch.Q[0]
    S = np.eye(problem.n) / problem.lambda1 + np.einsum("i,iab->ab", t, reduction.K)
    assert np.allclose(S @ q, w, rtol=1e-9, atol=1e-12), (S @ q, w)
    u = reduction.recover(t, q)
    assert np.allclose(problem.X @ u - w, -q / problem.lambda1, rtol=1e-7, atol=1e-9), (problem.X @ u - w, q)
    lengths = np.array([2 * np.sqrt(q @ K @ q) for K in reduction.K])
    assert (lengths <= problem.lambda3 * (1 + 1e-6)).all(), (lengths, problem.lambda3)
    used = (t > 0) & w.any()
    assert np.allclose(lengths[used], problem.lambda3, rtol=1e-5), (lengths, t, problem.lambda3)


def frame(seed: int = 0, p: int = 12):
    rng = np.random.default_rng(seed)
    X = rng.random((6, 60))
    X /= np.linalg.norm(X, axis=1, keepdims=True)
    objects = rng.random((p, 6)) @ X + 0.05 * rng.random((p, 60))
    objects /= np.linalg.norm(objects, axis=1, keepdims=True)
    lambdas = {"lambda1": 1, "lambda2": 0.1, "lambda3": 0.1}
    problems = [Problem(X, o, modalities=[20, 30, 10], **lambdas) for o in objects]
    reduction = Reduction.of(problems[0].X, problems[0].modalities)
    targets = np.einsum("pd,pd->p", objects, objects)
    return problems, reduction, objects @ X.T, targets, np.tile([1.0, 0.1, 0.1], (p, 1))


def test_a_batch_gives_what_one_by_one_gives():
    problems, reduction, C, targets, lambdas = frame()
    batch = Newton().batch(reduction.G, reduction.K, C, targets, lambdas)
    for problem, w in zip(problems, batch.W, strict=True):
        alone = solve(problem, Newton())
        assert np.allclose(w, alone.w, atol=1e-7), (w, alone.w)


def test_a_warm_start_at_the_answer_needs_no_steps():
    problems, *_ = frame()
    X, O, named = problems[0].X, np.array([problem.o for problem in problems]).T, {"modalities": [20, 30, 10]}
    cold = solve_many(X, O, lambda1=1, lambda2=0.1, lambda3=0.1, **named)
    warm = solve_many(X, O, lambda1=1, lambda2=0.1, lambda3=0.1, start=cold, **named)
    assert warm.iterations.max() <= 1, warm.iterations
    assert cold.iterations.min() >= 2, cold.iterations
    assert np.allclose(warm.w, cold.w, atol=1e-8), (warm.w, cold.w)


def test_the_order_of_the_templates_does_not_matter():
    _, reduction, C, targets, lambdas = frame()
    forward = Newton().batch(reduction.G, reduction.K, C, targets, lambdas)
    backward = Newton().batch(reduction.G, reduction.K, C[::-1], targets[::-1].copy(), lambdas)
    assert np.allclose(forward.W, backward.W[::-1], atol=1e-7), (forward.W, backward.W)


def test_the_solver_pickles():
    again = pickle.loads(pickle.dumps(Newton(tolerance=1e-10)))
    assert again == Newton(tolerance=1e-10)
    assert again.name == "newton"
