import math
from fractions import Fraction

import numpy as np
import pytest
from rational import objective_bounds

from convexperc.certificate.certificate import certify
from convexperc.errors import PointError
from convexperc.problem.problem import Problem


def posed(X, o, lambdas, modalities=None):
    one, two, three = lambdas
    return Problem(X, o, modalities=modalities, lambda1=one, lambda2=two, lambda3=three)


def judged(problem, w, u, dual=None):
    """Certify a point of the problem whose exact optimum is F(5, 4) = 38."""
    proof = certify(problem, w, u, dual=dual)
    assert proof.lower <= 38 <= proof.upper, (proof.lower, proof.upper)
    groups = [np.r_[c].tolist() for c in problem.modalities]
    low = objective_bounds(problem.X, problem.o, groups, problem.lambdas, (np.array(w), np.array(u)))[0]
    assert low - 38 <= Fraction(proof.gap), (float(low - 38), proof.gap)
    return proof


WRONG = [(bad, entry) for bad in (math.nan, math.inf, -math.inf) for entry in ("w", "u")]


@pytest.mark.parametrize(("bad", "entry"), WRONG)
def test_points_that_are_not_finite_prove_nothing_and_do_not_raise(bad, entry):
    problem = posed(np.eye(2, 3), [1, 2, 3], (1, 0.1, 0.1))
    point = {"w": [0.5, 0.5], "u": [0.1, 0.1, 0.1]}
    point[entry][1] = bad
    proof = certify(problem, point["w"], point["u"])
    assert not proof.certified, proof
    assert (proof.gap, proof.relative_gap, proof.share_of_target) == (math.inf,) * 3
    assert 0.0 <= proof.lower <= proof.upper <= 14.0 * (1 + 1e-15), (proof.lower, proof.upper)
    huge = certify(problem, [1e300, -1e300], [1e308, 1e308, 1e308])
    assert not huge.certified, huge
    hinted = certify(problem, [0.5, 0.5], [0.1, 0.1, 0.1], dual=([bad, 0, 0], [0, bad]))
    plain = certify(problem, [0.5, 0.5], [0.1, 0.1, 0.1])
    assert (hinted.lower, hinted.gap) == (plain.lower, plain.gap)


@pytest.mark.parametrize(
    "value", [[1.0], [[1.0, 2.0]], [1j, 2j], ["a", "b"], None, "ab", 3.0, [1, None], [1, 10**400]]
)
@pytest.mark.parametrize("place", range(4))
def test_what_is_no_point_is_refused(value, place):
    problem = posed(np.eye(2), [1, 2], (1, 1, 1))
    parts = [[0.0, 0.0]] * 4
    parts[place] = value
    with pytest.raises(PointError) as caught:
        certify(problem, parts[0], parts[1], dual=(parts[2], parts[3]))
    assert caught.value.what.startswith(("w", "u", "a", "b")[place]), caught.value.what


@pytest.mark.parametrize(
    "dual",
    [
        ([1e300], [1e300]),
        ([-1e9], [0.0]),
        ([0.0], [-1e9]),
        ([0.0], [0.0]),
        ([-1e-300], [5e-324]),
        ([7.0], [-3.0]),
    ],
)
def test_a_dual_hint_is_tried_and_never_believed(dual):
    problem = posed([[1]], [8], (1, 4, 2))
    plain = judged(problem, [4.0], [3.0])
    hinted = judged(problem, [4.0], [3.0], dual=dual)
    assert hinted.lower >= plain.lower, (hinted.lower, plain.lower)
    assert hinted.gap <= plain.gap, (hinted.gap, plain.gap)


def test_the_optimal_dual_hint_helps_a_poor_point():
    problem = posed([[1]], [8], (1, 4, 2))
    plain = judged(problem, [1.0], [3.0])
    hinted = judged(problem, [1.0], [3.0], dual=([-6.0], [-2.0]))
    assert plain.lower < 37.9, plain.lower
    assert hinted.lower == pytest.approx(38, rel=1e-14)
    assert not hinted.certified, hinted.relative_gap


@pytest.mark.parametrize("value", [2.0**31 - 1, 2.0 * (2**31 - 1)])
@pytest.mark.parametrize("lambdas", [(0, 0, 0), (1, 0, 0), (0, 0, 1), (1, 2.0**-20, 0)])
def test_a_row_of_multiples_of_the_prime_is_not_taken_for_zero(value, lambdas):
    problem = posed([[value]], [1.0], lambdas)
    point = [1.0 / value], [1.0 / value**2]
    high = objective_bounds(problem.X, problem.o, [[0]], problem.lambdas, tuple(map(np.array, point)))[1]
    for w, u in (([0.0], [0.0]), point):
        proof = certify(problem, w, u)
        assert Fraction(proof.lower) <= high, (proof.lower, float(high), proof.method)


def test_entries_1074_binary_orders_apart_do_not_raise():
    problem = posed([[5e-324], [0.75]], [0.75], (1, 0.1, 0))
    proof = certify(problem, [0.0, 1.0], [0.0])
    assert 0.0 <= proof.lower <= proof.upper, (proof.lower, proof.upper)
