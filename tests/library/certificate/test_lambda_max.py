import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from rational import fractions, inner

from convexperc.certificate.certificate import certify
from convexperc.certificate.lambda_max import lambda2_max, lambda3_max, zero_is_optimal
from convexperc.problem.problem import Problem
from convexperc.solution.single import solve
from convexperc.solvers.conic import Conic


def random_problem(seed, *, scale_x=1.0, scale_o=1.0, lambda2=0.1, lambda3=1.0):
    random = np.random.default_rng(seed)
    return Problem(
        scale_x * random.normal(size=(3, 6)),
        scale_o * random.normal(size=6),
        modalities=[2, 4],
        lambda1=scale_x**2,
        lambda2=scale_x * scale_o * lambda2,
        lambda3=scale_x**2 * scale_o * lambda3,
    )


ENTRY = st.floats(-1e100, 1e100) | st.floats(-1e-300, 1e-300) | st.floats(-4, 4)


@given(hnp.arrays(np.float64, (2, 3), elements=ENTRY), hnp.arrays(np.float64, 3, elements=ENTRY))
def test_lambda2_max_encloses_twice_the_largest_correlation(X, o):
    low, high = lambda2_max(Problem(X, o, lambda1=1, lambda2=1, lambda3=1))
    exact = max(abs(2 * inner(row, fractions(o))) for row in fractions(X))
    assert fractions(low) <= exact, (low, float(exact))
    assert high == np.inf or exact <= fractions(high), (float(exact), high)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("scale", [1e-60, 1.0, 1e60])
def test_zero_is_optimal_from_lambda2_max_on(seed, scale):
    base = random_problem(seed, scale_o=scale)
    low, high = lambda2_max(base)
    assert high / low - 1 < 1e-13, (low, high)
    at = Problem(base.X, base.o, modalities=base.modalities, lambda1=1, lambda2=high, lambda3=base.lambda3)
    below = Problem(
        base.X, base.o, modalities=base.modalities, lambda1=1, lambda2=low * (1 - 1e-5), lambda3=base.lambda3
    )
    zero = np.zeros(3), np.zeros(6)
    assert zero_is_optimal(at), (at.lambda2, high)
    assert not zero_is_optimal(below), (below.lambda2, high)
    proof = certify(at, *zero)
    assert proof.certified, (proof.gap, proof.relative_gap)
    assert solve(at, Conic()).w.tolist() == [0.0] * 3
    w = np.zeros(3)
    best = int(np.argmax(np.abs(base.X @ base.o)))
    w[best] = 2e-6 * (base.X @ base.o)[best] / (base.X[best] @ base.X[best] + 1)
    beside, there = certify(below, w, zero[1]), certify(below, *zero)
    assert beside.objective[1] < there.objective[0], (beside.objective, there.objective)


def test_lambda2_max_is_zero_where_nothing_correlates():
    assert lambda2_max(Problem([[0.0, 1.0]], [1.0, 0.0], lambda1=1, lambda2=1, lambda3=1))[0] == 0.0
    assert lambda2_max(Problem([[0.0]], [0.0], lambda1=1, lambda2=1, lambda3=1)) == (0.0, 0.0)


@pytest.mark.parametrize(
    ("o", "one", "two"), [(1.0, 1.0, 0.5), (-3.0, 0.25, 1.0), (2.0, 3.0, 0.0), (1.0, 1.0, 4.0)]
)
def test_lambda3_max_of_one_entry(o, one, two):
    problem = Problem([[1.0]], [o], lambda1=one, lambda2=two, lambda3=1)
    exact = 2 * one * max(0.0, abs(o) - two / 2) / (1 + one)
    assert lambda3_max(problem, lambda p: solve(p, Conic())) == pytest.approx(exact, rel=1e-7, abs=1e-7)


def test_lambda3_max_without_coupling_is_zero():
    def never(problem):
        raise AssertionError(problem)

    assert lambda3_max(Problem([[1.0]], [1.0], lambda1=0, lambda2=0, lambda3=1), never) == 0.0


@pytest.mark.parametrize("seed", range(3))
def test_u_is_zero_from_lambda3_max_on(seed):
    conic = Conic()
    base = random_problem(seed)
    critical = lambda3_max(base, lambda p: solve(p, conic))
    above = solve(random_problem(seed, lambda3=critical * 1.001), conic)
    below = solve(random_problem(seed, lambda3=critical * 0.98), conic)
    assert above.certificate.zero_modalities.all(), (above.u, above.certificate.relative_gap)
    assert below.certificate.certified, below.certificate
    without_u = certify(below.problem, below.w, np.zeros(6))
    assert without_u.objective[0] > below.certificate.upper, (without_u.objective, below.certificate.upper)


@pytest.mark.parametrize(
    ("scale_x", "scale_o"), [(1, 1e-100), (1, 1e-12), (1, 1e100), (1e-8, 1), (1e-60, 1), (1e60, 1)]
)
def test_lambda3_max_follows_the_scale(scale_x, scale_o):
    conic = Conic()
    base = lambda3_max(random_problem(7), lambda p: solve(p, conic))
    found = lambda3_max(random_problem(7, scale_x=scale_x, scale_o=scale_o), lambda p: solve(p, conic))
    assert found / scale_x**2 / scale_o == pytest.approx(base, rel=1e-6)
