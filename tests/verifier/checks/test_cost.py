"""What an iteration costs: counted solutions are solutions, and the exponents."""

import numpy as np
import pytest

from verification.checks import cost
from verification.checks.cost import Growth, Iterate
from verification.checks.operations import Counter
from verification.ledger.evidence import Outcome


def values(row):
    return np.array([each.value for each in row])


def test_the_counted_steps_solve_their_systems():
    it = Iterate.of(4, 24)
    w = np.linalg.solve(it.views_system(), it.X @ (cost.LAMBDA1 * it.u))
    u = np.linalg.solve(it.features_system(), cost.LAMBDA1 * it.X.T @ it.w)
    np.testing.assert_allclose(values(cost.step6(it, Counter())), w, rtol=1e-10)
    np.testing.assert_allclose(values(cost.step7(it, Counter())), u, rtol=1e-10)
    np.testing.assert_allclose(values(cost.woodbury(it, Counter())), u, rtol=1e-8, atol=1e-12)


def test_the_reduced_iterate_has_the_same_gram_matrices():
    it = Iterate.of(4, 24)
    reduced = it.reduced()
    assert reduced.X.shape == (4, 12), reduced.X.shape
    np.testing.assert_allclose(reduced.X @ reduced.X.T, it.X @ it.X.T, rtol=1e-12)
    np.testing.assert_allclose(reduced.views_system(), it.views_system(), rtol=1e-12)


@pytest.mark.parametrize("n", [1, 2, 5])
def test_elimination_takes_as_many_multiplications_as_the_textbook_says(n):
    counted = cost.multiplications(cost.step6, Iterate.of(n, 2 * n))
    factors = n * (n - 1) // 2 + sum(k * k for k in range(n)) + n * (n - 1) // 2
    assert counted == factors + n * (n - 1) // 2 + n, counted


def test_an_exponent_is_recovered():
    assert Growth((2, 4, 8), (12.0, 96.0, 768.0)).slope == pytest.approx(3.0), "3 x^3 / 2"


def test_the_parts_of_c1():
    first, again = cost.counts(), cost.counts()
    assert first == again, (first, again)
    outcome = {each.part: each.outcome for each in cost.observations(first)}
    assert outcome == {
        "C1/step6": Outcome.FAILED,
        "C1/step7": Outcome.FAILED,
        "C1/woodbury": Outcome.HELD,
        "C1/reduction": Outcome.HELD,
    }, outcome
    assert list(first) == ["step6", "step7", "woodbury", "reduction"], first


def test_times_have_the_shape_of_the_counts():
    times = cost.times()
    assert list(times) == list(cost.counts()), list(times)
    for name, growth in times.items():
        assert len(growth["x"]) == len(growth["y"]), (name, growth)
        assert min(growth["y"]) > 0.0, (name, growth)
