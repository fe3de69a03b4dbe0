"""The pieces of the proximal Newton method against NumPy, and what templates share in a batch."""

import numpy as np
import pytest

from convexperc.problem.problem import Problem
from convexperc.problem.reduction import Reduction
from convexperc.solvers.newton.lapack import (
    ARGUMENTS,
    SHORT,
    Arguments,
    address,
    arguments_in,
    cholesky_extend,
    cholesky_inverse,
    cholesky_solve,
    inner,
    symmetric_times,
)
from convexperc.solvers.newton.method import Newton
from convexperc.solvers.newton.subproblem import minimise
from convexperc.solvers.newton.workspace import END, GRADIENT, START, H, new_memory, workspace
from verification.bench.instances import LAMBDAS, SHAPES, Instance


def new_arguments() -> Arguments:
    memory = np.zeros(ARGUMENTS)
    return arguments_in(memory, address(memory))


def positive(n: int, seed: int = 0) -> np.ndarray:
    rows = np.random.default_rng(seed).normal(size=(n, 2 * n))
    return np.asarray(rows @ rows.T)


@pytest.mark.parametrize("n", [1, 2, 16, 17, 33, 64, 101])
@pytest.mark.parametrize("spare", [0, 3])
def test_the_factor_the_solution_and_the_inverse(n, spare):
    A, y, arguments = positive(n), np.arange(1.0, n + 1), new_arguments()
    room = np.zeros((n, n + spare))
    room[:, :n] = np.triu(A)
    at, x = address(room), y.copy()
    for start, stop in ((0, n // 3), (n // 3, n)):
        assert start == stop or cholesky_extend(room, at, start, stop, arguments) == 0, (start, stop)
    assert np.allclose(np.triu(room[:, :n]).T, np.linalg.cholesky(A), rtol=1e-10, atol=1e-10), n
    cholesky_solve(room, at, n, y, address(y), arguments)
    assert np.allclose(A @ y, x, rtol=1e-9), (A @ y, x)
    cholesky_inverse(room, at, n, arguments)
    assert np.allclose(np.triu(room[:, :n]), np.triu(np.linalg.inv(A)), rtol=1e-8, atol=1e-12), n


@pytest.mark.parametrize("n", [1, 5, SHORT, SHORT + 1, 100])
def test_products(n):
    rng, arguments = np.random.default_rng(n), new_arguments()
    A, x, y = positive(n), rng.normal(size=n), np.full(n, np.nan)
    symmetric_times(A, address(A), n, x, address(x), y, address(y), arguments)
    assert np.allclose(y, A @ x, rtol=1e-12), (y, A @ x)
    found = inner(x, y, address(x), address(y), n, arguments)
    assert found == pytest.approx(x @ y, rel=1e-12, abs=1e-12)


def test_what_is_not_positive_definite_is_refused():
    for size in (4, 2 * SHORT):
        A, arguments = np.diag([1.0, 2.0, -1.0, *[4.0] * (size - 3)]), new_arguments()
        assert cholesky_extend(A, address(A), 0, 2, arguments) == 0
        assert cholesky_extend(A, address(A), 2, size, arguments) != 0


@pytest.mark.parametrize("seed", range(20))
def test_the_minimiser_of_the_model_is_stationary_and_a_factor_can_be_used_again(seed):
    rng, n, N, weight = np.random.default_rng(seed), 6, 9, 2.0
    room = workspace(new_memory(n, N - n), n, N - n)
    room.matrices[H] = positive(N, seed)
    for _ in range(3):
        room.vectors[GRADIENT] = 10 * rng.normal(size=N)
        room.vectors[START] = room.vectors[END]
        minimise(room, weight, 0.0, n, N)
        z = room.vectors[END]
        slope = room.matrices[H] @ z + room.vectors[GRADIENT]
        assert (z[n:] >= 0).all(), z
        assert (slope[n:] >= -1e-9).all(), slope
        assert np.allclose(slope[n:][z[n:] > 0], 0, atol=1e-9), slope
        assert np.allclose(slope[:n][z[:n] != 0], -weight * np.sign(z[:n][z[:n] != 0]), atol=1e-9), (z, slope)
        assert (abs(slope[:n]) <= weight * (1 + 1e-9)).all(), slope


@pytest.mark.parametrize("lambdas", LAMBDAS)
@pytest.mark.parametrize("name", ["S", "M"])
def test_every_template_reaches_the_gap(name, lambdas):
    instance = Instance.of(SHAPES[name])
    reduction = Reduction.of(instance.X, instance.modalities)
    every = np.tile(lambdas, (len(instance.C), 1))
    found = Newton(9e-10).batch(reduction.G, reduction.K, instance.C, instance.targets, every)
    assert (found.gaps[:, 1] <= 9e-10 * found.gaps[:, 0]).all(), found.gaps
    assert found.iterations.mean() <= 4, found.iterations


def test_templates_of_several_lambdas_do_not_disturb_each_other():
    rng = np.random.default_rng(3)
    X = rng.random((5, 30))
    lambdas = np.array([(one, 0.1, 0.2) for one in (1.0, 1.0, 0.1, 0.1, 0.1, 10.0, 1.0, 1.0)])
    objects = rng.random((len(lambdas), 5)) @ X + 0.1 * rng.random((len(lambdas), 30))
    problem = Problem(X, objects[0], modalities=[10, 20], lambda1=1, lambda2=1, lambda3=1)
    reduction = Reduction.of(problem.X, problem.modalities)
    C, targets = objects @ X.T, np.einsum("pd,pd->p", objects, objects)
    together = Newton().batch(reduction.G, reduction.K, C, targets, lambdas)
    for j in range(len(lambdas)):
        alone = Newton().batch(reduction.G, reduction.K, C[j : j + 1], targets[j : j + 1], lambdas[j : j + 1])
        assert np.allclose(alone.W[0], together.W[j], atol=1e-7), (j, alone.W, together.W[j])
        assert np.allclose(alone.T[0], together.T[j], atol=1e-4), (j, alone.T, together.T[j])
