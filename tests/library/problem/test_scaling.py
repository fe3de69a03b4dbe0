import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from convexperc.problem.problem import Problem, same_data
from convexperc.problem.scaling import LARGEST_LAMBDA, Scaling, _shifted

EXPONENT = st.integers(-490, 490)


def posed(X, o, lambdas=(1.0, 1.0, 1.0)):
    one, two, three = lambdas
    return Problem(X, o, modalities=[1, 2], lambda1=one, lambda2=two, lambda3=three)


def base(seed=0):
    random = np.random.default_rng(seed)
    return random.normal(size=(2, 3)), random.normal(size=3)


@given(st.integers(0, 100), EXPONENT, EXPONENT)
def test_normalised_norms_and_exact_round_trips(seed, x, y):
    X, o = base(seed)
    problem = posed(np.ldexp(X, x), np.ldexp(o, y))
    scaling = Scaling.of(problem)
    X_, o_, error = scaling.data(problem)
    assert error == 0.0
    assert 0.5 <= np.linalg.norm(X_, axis=1).max() < 1.0 + 1e-15
    assert 0.5 <= np.linalg.norm(o_) < 1.0 + 1e-15
    assert np.ldexp(X_, scaling.x).tobytes() == problem.X.tobytes()
    assert np.ldexp(o_, scaling.o).tobytes() == problem.o.tobytes()
    w, u = np.array([0.1, -3.0]), np.array([1 / 3, 0.0, -7.0])
    for there, back, pair in (
        (scaling.point_back, scaling.point, (w, u)),
        (scaling.dual_back, scaling.dual, (u, w)),
    ):
        for k in (scaling.x, scaling.o):
            assert abs(k) < 500, scaling
        if max(abs(2 * scaling.x - scaling.o), abs(scaling.x) + abs(scaling.o)) < 1000:
            for found, given_ in zip(back(*there(*pair)), pair, strict=True):
                assert found.tobytes() == given_.tobytes(), (found, given_, scaling)


@pytest.mark.parametrize("exponent", [-490, -333, 0, 333, 490])
def test_normal_form_does_not_see_powers_of_two(exponent):
    X, o = base()
    s, t = math.ldexp(1.0, exponent // 2), math.ldexp(1.0, -exponent // 3)
    moved = posed(s * X, t * o, (s * s, s * t, s * s * t))
    plain = posed(X, o)
    first, second = Scaling.of(plain).normalise(plain), Scaling.of(moved).normalise(moved)
    assert same_data(first, second), (first, second)


@pytest.mark.parametrize(
    ("X", "o", "flagged"),
    [
        ([[1.0, 0.5, 5e-324]], [1.0, 1.0, 1.0], True),
        ([[1.0, 0.5, 2.0**-1073]], [1.0, 1.0, 1.0], False),
        ([[1.0, 1.0, 1.0]], [1e200, 1.0, 3e-324], True),
        ([[5e-324, 0.0, 5e-324]], [5e-324, 0.0, 0.0], False),
        ([[1e308, 1e308, 1e308]], [1.0, 0.0, 0.0], False),
        ([[1e300, 1e-300, 0.0]], [1.0, 0.0, 0.0], True),
        (np.zeros((2, 3)), np.zeros(3), False),
    ],
)
def test_entries_lost_to_underflow_are_flagged_and_bounded(X, o, flagged):
    problem = posed(X, o)
    scaling = Scaling.of(problem)
    X_, o_, error = scaling.data(problem)
    assert (error > 0.0) == flagged, error
    for exponent, moved, given_ in ((scaling.x, X_, problem.X), (scaling.o, o_, problem.o)):
        for a, b in zip(moved.ravel().tolist(), given_.ravel().tolist(), strict=True):
            distance = abs(Fraction(a) - Fraction(b) / Fraction(2) ** exponent)
            assert distance <= Fraction(error), (a, b, exponent)


LAMBDA = st.floats(0, allow_infinity=False) | st.sampled_from([0.0, 5e-324, 1e308])


@given(LAMBDA, LAMBDA, LAMBDA, EXPONENT, EXPONENT)
def test_lambda_bounds_contain_the_exact_rational(one, two, three, x, y):
    X, o = base()
    problem = posed(np.ldexp(X, x), np.ldexp(o, y), (one, two, three))
    scaling = Scaling.of(problem)
    exponents = 2 * scaling.x, scaling.x + scaling.o, 2 * scaling.x + scaling.o
    bounds = scaling.lambdas(problem)
    for value, exponent, (low, high) in zip((one, two, three), exponents, bounds, strict=True):
        exact = Fraction(value) / Fraction(2) ** exponent
        assert 0 <= Fraction(low) <= exact, (low, value, exponent)
        assert high == math.inf or exact <= Fraction(high), (value, exponent, high)
        if 2.0**-1022 <= exact < 2**1023:
            assert low == high, (low, high)
    assert max(scaling.normalise(problem).lambdas) <= LARGEST_LAMBDA


@given(LAMBDA, LAMBDA, st.integers(-1070, 1020), st.integers(-490, 490))
def test_values_go_back_outward(first, second, t, s):
    scaling = Scaling(s, t)
    inside = min(first, second), max(first, second)
    for bounds, exponent in ((scaling.value_back(inside), 2 * t), (scaling.gradient_back(inside), s + t)):
        factor = Fraction(2) ** exponent
        assert Fraction(bounds[0]) <= Fraction(inside[0]) * factor, (inside, exponent, bounds)
        assert bounds[1] == math.inf or Fraction(inside[1]) * factor <= Fraction(bounds[1]), (inside, bounds)
    assert scaling.value_back((0.0, math.inf)) == (0.0, math.inf)


def test_a_shift_out_of_range_is_an_open_interval():
    assert _shifted(1.0, 2000) == (LARGEST_LAMBDA, math.inf)
    assert _shifted(1.0, -2000) == (0.0, 5e-324)
    assert _shifted(3.0, -1074) == (1.5e-323, 1.5e-323)
