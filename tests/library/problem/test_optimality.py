import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from convexperc.problem.formulation import objective
from convexperc.problem.optimality import optimality_residual
from convexperc.problem.problem import Problem

OPTIMA = [
    ([[1]], [8], (1, 4, 2), [5], [4]),
    ([[1]], [-8], (1, 4, 2), [-5], [-4]),
    ([[1]], [1], (1, 1, 0), [0.5], [0.5]),
    ([[1]], [-1], (1, 4, 0), [0], [0]),
    ([[1]], [3], (0, 2, 1), [2], [0]),
    ([[1, 0], [3, 1]], [1, 0], (1, 1, 0), [0, 0.25], [0, 0.25]),
    ([[1, 0], [0, 1]], [0, 0], (1, 0, 0), [0, 0], [0, 0]),
    ([[0, 0]], [1, 2], (1, 1, 1), [0], [0, 0]),
    ([[1], [1], [1]], [6], (0, 0, 0), [3, 2, 1], [9]),
]


@pytest.mark.parametrize(("X", "o", "lambdas", "w", "u"), OPTIMA)
def test_zero_at_known_optima_and_not_beside_them(X, o, lambdas, w, u):
    one, two, three = lambdas
    problem = Problem(X, o, lambda1=one, lambda2=two, lambda3=three)
    found = optimality_residual(problem, w, u)
    assert found.worst == 0.0, found
    assert found.views.shape == (problem.n,)
    assert found.modalities.shape == (problem.m,)
    if problem.X.any() and any(lambdas):
        beside = optimality_residual(problem, np.add(w, 0.125), u)
        assert beside.worst > 0.01, beside


def slope(F, point, direction, step=2.0**-20):
    """Central difference; for a one-sided derivative along a kink see the caller."""
    return (F(point + step * direction) - F(point - step * direction)) / (2 * step)


@given(st.integers(0, 2**32 - 1))
def test_gradient_by_finite_differences_away_from_zero(seed):
    random = np.random.default_rng(seed)
    n, d = 3, 5
    one, two, three = random.uniform(0.0, 2.0, 3)
    problem = Problem(
        random.normal(size=(n, d)),
        random.normal(size=d),
        modalities={"a": [0, 3], "b": [1, 2, 4]},
        lambda1=one,
        lambda2=two,
        lambda3=three,
    )
    point = random.choice([-1.0, 1.0], n + d) * random.uniform(0.1, 2.0, n + d)
    gradient = np.array([slope(lambda x: objective(problem, x[:n], x[n:]), point, e) for e in np.eye(n + d)])
    found = optimality_residual(problem, point[:n], point[n:])
    assert found.views == pytest.approx(np.abs(gradient[:n]), abs=1e-6)
    assert found.modalities == pytest.approx(problem.modalities.norms(gradient[n:]), abs=1e-6)
    assert found.worst == max(found.views.max(), found.modalities.max())


@given(st.integers(0, 2**32 - 1))
def test_at_zero_the_residual_is_the_steepest_descent(seed):
    random = np.random.default_rng(seed)
    one, two, three = random.uniform(0.0, 3.0, 3)
    problem = Problem(
        random.normal(size=(2, 3)),
        random.normal(size=3),
        modalities=[1, 1, 1],
        lambda1=one,
        lambda2=two,
        lambda3=three,
    )
    point, step = np.concatenate([[0.0], random.uniform(0.1, 1.0, 1), np.zeros(3)]), 2.0**-26
    here = objective(problem, point[:2], point[2:])
    found = optimality_residual(problem, point[:2], point[2:])
    for index, residual in ((0, found.views[0]), *zip(range(2, 5), found.modalities, strict=True)):
        falls = []
        for sign in (-1.0, 1.0):
            beside = point.copy()
            beside[index] = sign * step
            falls.append((here - objective(problem, beside[:2], beside[2:])) / step)
        assert residual == pytest.approx(max(0.0, *falls), abs=1e-5), (index, residual, falls)


@given(st.integers(-900, 900), st.integers(1, 1023))
def test_scaled_by_any_power_of_two_the_known_optimum_stays_exact(exponent, k):
    o = np.ldexp(8.0 * k, exponent)
    problem = Problem([[1.0]], [o], lambda1=1, lambda2=o / 2, lambda3=o / 4)
    assert optimality_residual(problem, [5 * o / 8], [o / 2]).worst == 0.0, o
