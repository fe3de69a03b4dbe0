import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from rational import fractions, inner, root_bounds

from convexperc.certificate.rounding import (
    Ball,
    Groups,
    U,
    down,
    gamma,
    inner_by_group,
    norm_bounds,
    norms_by_group,
    product,
    scaled_bounds,
    smallest_singular_value,
    squared_norm,
    sum_bounds,
    up,
)
from convexperc.certificate.rounding import inner as inner_bounds

ENTRY = (
    st.floats(-4, 4)
    | st.sampled_from([0.0, 1.0, -1.0, 1 + 2.0**-52, -1 - 2.0**-52, 5e-324, -5e-324, 2.0**-1022, 1e-200])
    | st.floats(-1e-300, 1e-300)
    | st.floats(-1e150, 1e150)
    | st.floats(allow_nan=False, allow_infinity=False)
)
RADIUS = st.sampled_from([0.0, 0.0, 5e-324, 1e-200, 2.0**-60, 0.25]) | st.floats(0, 1e-300) | st.floats(0, 2)
SIZE = st.shared(st.integers(1, 4), key="size")
VECTOR = SIZE.flatmap(lambda k: hnp.arrays(np.float64, k, elements=ENTRY))
BALL = st.builds(Ball, VECTOR, SIZE.flatmap(lambda k: hnp.arrays(np.float64, k, elements=RADIUS)))
CHOICE = SIZE.flatmap(lambda k: st.lists(st.sampled_from([-1, 0, 1]), min_size=k, max_size=k))
TINY = Ball(np.zeros(1), np.array([1e-200]))


@pytest.fixture(autouse=True, scope="module")
def _overflow_is_expected():
    with np.errstate(all="ignore"):
        yield


def member(ball, choice):
    """One exact member of a ball: its centre, or an end of each interval."""
    return [
        Fraction(m) + c * Fraction(r)
        for m, r, c in zip(ball.mid.tolist(), ball.rad.tolist(), choice, strict=True)
    ]


def within(exact, ball):
    for x, mid, rad in zip(exact, ball.mid.tolist(), ball.rad.tolist(), strict=True):
        known = math.isfinite(mid) and math.isfinite(rad)
        assert known or not math.isfinite(rad), (mid, rad)
        assert not known or abs(x - Fraction(mid)) <= Fraction(rad), (float(x - Fraction(mid)), mid, rad)


def between(exact, bounds):
    low, high = bounds
    assert low == -math.inf or (math.isfinite(low) and Fraction(low) <= exact), (bounds, exact)
    assert not math.isnan(high), (bounds, exact)
    assert high == math.inf or exact <= Fraction(high), (bounds, exact)


@given(st.integers(1, 2**40))
def test_gamma_is_an_upper_bound(k):
    exact = Fraction(k) * Fraction(U) / (1 - k * Fraction(U))
    assert exact <= Fraction(gamma(k)) <= exact * (1 + Fraction(1, 2**45))


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_up_and_down_are_neighbours(x):
    assert down(x) < x < up(x)
    assert down(up(x)) == x or math.isinf(up(x))


@given(BALL, BALL, CHOICE, CHOICE, st.sampled_from([1.0, -1.0]), ENTRY)
def test_sums_multiples_and_magnitudes_of_balls(x, y, first, second, sign, factor):
    a, b = member(x, first), member(y, second)
    within([s + int(sign) * t for s, t in zip(a, b, strict=True)], x.plus(y, sign))
    within([s * Fraction(factor) for s in a], x.times(factor))
    for exact, high in zip(a, x.magnitude().tolist(), strict=True):
        between(abs(exact), (0.0, high))


@given(
    SIZE.flatmap(lambda k: hnp.arrays(np.float64, (3, k), elements=ENTRY)),
    BALL,
    CHOICE,
    CHOICE,
    st.sampled_from([0.0, 2.0**-1074]),
)
@example(np.array([[1e-200]] * 3), TINY, [1], [0], 0.0)
def test_products_enclose_the_exact_one(A, x, choice, shifts, entry_error):
    true = [[v + s * Fraction(entry_error) for v, s in zip(row, shifts, strict=True)] for row in fractions(A)]
    vector = member(x, choice)
    within([inner(row, vector) for row in true], product(A, x, entry_error))


SPLIT = SIZE.flatmap(lambda k: st.tuples(st.permutations(range(k)), st.integers(1, k)))
TWO = Ball(np.array([1e-200, 0.0]), np.zeros(2))


@given(BALL, BALL, CHOICE, CHOICE, SPLIT)
@example(TWO, Ball.exact(np.array([1e-200, 1.0])), [1, 0], [0, 0], ([1, 0], 1))
def test_inner_products_and_norms_by_group_enclose_the_exact_ones(x, y, first, second, split):
    order, cut = split
    columns = tuple(np.array(part) for part in (order[:cut], order[cut:]) if part)
    groups = Groups.of(columns, tuple(part.size for part in columns))
    a, b = member(x, first), member(y, second)
    products, norms = (
        zip(*pair, strict=True) for pair in (inner_by_group(x, y, groups), norms_by_group(x, groups))
    )
    for part, bounds, lengths in zip(columns, products, norms, strict=True):
        between(inner([a[i] for i in part], [b[i] for i in part]), tuple(map(float, bounds)))
        low, high = map(float, lengths)
        square = inner([a[i] for i in part], [a[i] for i in part])
        assert Fraction(low) ** 2 <= square, (low, square)
        assert high == math.inf or square <= Fraction(high) ** 2, (high, square)


def test_consecutive_slices_are_groups_as_they_stand():
    groups = Groups.of((slice(0, 2), slice(2, 5)), (2, 3))
    assert groups.order is None
    assert groups.sums(np.arange(5.0)).tolist() == [1.0, 9.0]
    mixed = Groups.of((slice(2, 5), slice(0, 2)), (3, 2))
    assert mixed.sums(np.arange(5.0)).tolist() == [9.0, 1.0]
    assert mixed.any(np.array([True, False, False, False, False])).tolist() == [False, True]


@given(BALL, BALL, CHOICE, CHOICE)
@example(TINY, Ball.exact(np.array([1e-200])), [1], [0])
@example(TINY, TINY, [1], [1])
def test_inner_products_norms_and_squares_enclose_the_exact_ones(x, y, first, second):
    a, b = member(x, first), member(y, second)
    between(inner(a, b), inner_bounds(x, y))
    square = inner(a, a)
    between(square, squared_norm(x))
    assert squared_norm(x)[0] >= 0.0
    low, high = norm_bounds(x)
    root = root_bounds(square)
    assert low >= 0.0
    assert math.isinf(high) or Fraction(low) <= root[1], (low, float(root[1]))
    assert math.isinf(high) or root[0] <= Fraction(high), (float(root[0]), high)


def test_cancellation_is_enclosed_and_the_bound_is_tight():
    x, y = Ball.exact(np.array([1e16, 1.0, -1e16])), Ball.exact(np.ones(3))
    low, high = inner_bounds(x, y)
    assert low <= 1.0 <= high, (low, high)
    assert high - low < 100, (low, high)
    low, high = squared_norm(Ball.exact(np.array([3.0, 4.0])))
    assert 25 * (1 - 4e-15) < low <= 25.0 <= high < 25 * (1 + 4e-15), (low, high)
    assert norm_bounds(Ball.exact(np.zeros(3))) == (0.0, 0.0)


NONNEGATIVE = st.floats(0, 1e300) | st.floats(0, 1e-300) | st.just(0.0)
INTERVAL = st.tuples(NONNEGATIVE, NONNEGATIVE).map(lambda pair: (min(pair), max(pair)))


@given(INTERVAL, INTERVAL)
def test_products_and_sums_of_intervals(x, y):
    for end in (0, 1):
        between(Fraction(x[end]) * Fraction(y[end]), scaled_bounds(x, y))
        between(Fraction(x[end]) + Fraction(y[end]) - 1, sum_bounds(x, y, (-1.0, -1.0)))


def test_zero_times_infinity_is_zero_and_nan_is_everything():
    assert scaled_bounds((0.0, 0.0), (0.0, math.inf)) == (0.0, 0.0)
    assert inner_bounds(Ball.exact(np.array([math.nan])), TINY) == (-math.inf, math.inf)
    huge = Ball.exact(np.array([1e200, -1e200]))
    low, high = squared_norm(huge)
    assert (low, high) == (low, math.inf)


def positive_definite(G):
    """Exact elimination over the rationals: every pivot > 0."""
    G = [row[:] for row in G]
    for k, row in enumerate(G):
        if row[k] <= 0:
            return False
        for other in G[k + 1 :]:
            factor = other[k] / row[k]
            other[:] = [a - factor * b for a, b in zip(other, row, strict=True)]
    return True


@given(
    hnp.arrays(np.float64, st.tuples(st.integers(1, 3), st.integers(1, 4)), elements=ENTRY),
    st.sampled_from([1.0, 2.0**-20, 2.0**-500]),
)
@example(np.array([[1.0, 1.0], [1.0, 1.0 + 2.0**-52]]), 1.0)
@example(np.array([[0.1, 0.2], [0.1, 0.2]]), 1.0)
def test_singular_value_bound_is_a_lower_bound(X, shrink):
    X[-1] *= shrink
    bound = smallest_singular_value(X)
    assert bound >= 0.0
    if bound > 0.0:
        c = Fraction(bound) ** 2 * (1 - Fraction(1, 10**9))
        rows = fractions(X)
        gram = [[inner(a, b) - (c if i == j else 0) for j, b in enumerate(rows)] for i, a in enumerate(rows)]
        assert positive_definite(gram), (bound, np.linalg.svd(X, compute_uv=False))


@pytest.mark.parametrize("seed", range(4))
def test_singular_value_bound_is_useful_on_ordinary_data(seed):
    X = np.random.default_rng(seed).normal(size=(4, 9))
    exact = np.linalg.svd(X, compute_uv=False)[-1]
    assert 0.5 * exact < smallest_singular_value(X) <= exact
    assert smallest_singular_value(X.T) == 0.0
    assert smallest_singular_value(np.zeros((2, 3))) == 0.0
