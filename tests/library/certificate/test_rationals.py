from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from rational import fractions, inner, transposed

from convexperc.certificate import rationals
from convexperc.certificate.rationals import (
    PRIME,
    RowSpace,
    integers,
    into_left_null_space,
    numerators,
    squared_distance,
)

ENTRY = (
    st.floats(allow_nan=False, allow_infinity=False)
    | st.sampled_from([0.0, -0.0, 5e-324, 1e308])
    | st.floats(-2, 2)
)
SMALL = st.integers(-3, 3).map(float)
MATRIX = st.tuples(st.integers(1, 4), st.integers(1, 4)).flatmap(
    lambda s: hnp.arrays(np.float64, s, elements=SMALL)
)
MULTIPLES = [float(PRIME), 3.0 * PRIME, PRIME * 2.0**-40]


def eliminated(rows):
    """Row echelon form over the rationals, without zero rows: the referee of every rank below."""
    rows, found = [row[:] for row in rows], []
    for column in range(len(rows[0])):
        pivot = next((row for row in rows if row[column]), None)
        if pivot is None:
            continue
        rows.remove(pivot)
        found.append(pivot)
        rows = [
            [a - row[column] / pivot[column] * b for a, b in zip(row, pivot, strict=True)] for row in rows
        ]
    return found


def split(x, vectors):
    """The part of x in the span of the vectors, and the part orthogonal to it (Gram-Schmidt)."""
    inside, basis = [Fraction(0)] * len(x), []
    for vector in vectors:
        rest = vector
        for b in basis:
            rest = [v - inner(vector, b) / inner(b, b) * y for v, y in zip(rest, b, strict=True)]
        if any(rest):
            basis.append(rest)
            share = inner(x, rest) / inner(rest, rest)
            inside = [v + share * y for v, y in zip(inside, rest, strict=True)]
    return inside, [v - y for v, y in zip(x, inside, strict=True)]


def distance(X, o):
    """The squared length of what is left of o."""
    rest = split(fractions(o), fractions(X))[1]
    return inner(rest, rest)


@given(hnp.arrays(np.float64, hnp.array_shapes(min_dims=1, max_dims=2, max_side=4), elements=ENTRY))
def test_floats_are_integers_times_one_power_of_two(values):
    whole, exponent = integers(values)
    assert whole.shape == values.shape
    for found, value in zip(whole.ravel().tolist(), values.ravel().tolist(), strict=True):
        assert found * Fraction(2) ** exponent == Fraction(value), (found, exponent, value)


@given(MATRIX)
def test_rank_of_small_integer_matrices(X):
    rows = RowSpace.of(X).rows
    assert len(rows) == len(eliminated(fractions(X))), (rows, X)
    assert not rows or len(eliminated(fractions(X[list(rows)]))) == len(rows), (rows, X)


@pytest.mark.parametrize(
    ("X", "rank"),
    [
        ([[0.1, 0.2], [0.1, 0.2]], 1),
        ([[0.1, 0.2], [0.2, 0.4], [0.4, 0.8]], 1),
        ([[0.1, 0.3], [0.3, 0.9]], 2),
        ([[1.0, 2.0], [1.0, 2.0 + 2.0**-51]], 2),
        ([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.0]], 2),
        ([[1e-300, 1e300], [1e-300, 1e300]], 1),
        ([[5e-324, 0.0], [0.0, 1e308]], 2),
        (np.zeros((3, 2)), 0),
        (np.ones((5, 1)), 1),
    ],
)
def test_rank_of_known_constructions(X, rank):
    assert RowSpace.of(np.array(X)).rank == rank


@pytest.mark.parametrize("seed", range(5))
def test_integer_combinations_of_rows_are_found_dependent(seed):
    random = np.random.default_rng(seed)
    X = np.round(random.normal(size=(3, 7)) * 2**20) / 2**24
    mixed = np.concatenate([X, random.integers(-9, 10, (4, 3)) @ X])[random.permutation(7)]
    assert RowSpace.of(mixed).rank == 3
    found = squared_distance(mixed, X[0])
    assert found == 0


def rational(values):
    """A column of `RowSpace` as Fractions."""
    over, denominator = numerators(values)
    return [Fraction(int(v), denominator) for v in over]


@given(MATRIX, st.data())
def test_projections_are_those_of_gram_and_schmidt(X, data):
    space = RowSpace.of(X)
    rows = [[Fraction(int(v)) for v in row] for row in space.A.tolist()]
    w, t = ([Fraction(data.draw(st.integers(-(10**6), 10**6))) for _ in range(size)] for size in X.shape)
    whole_w, whole_t = (rationals.column(np.array([int(v) for v in x], dtype=object)) for x in (w, t))
    inside, outside = split(w, transposed(rows))
    assert rational(space.outside(whole_w)) == outside, (X, w)
    assert rational(space.residual(whole_t)) == split(t, rows)[1], (X, t)
    for u, image, wanted in (
        (rational(space.coupling(whole_w)), lambda y: y, inside),
        (
            rational(space.fitted(whole_t)),
            lambda y: [inner(c, y) for c in transposed(rows)],
            split(t, rows)[0],
        ),
    ):
        assert image([inner(row, u) for row in rows]) == wanted, (X, u)
        assert not any(split(u, rows)[1]), (X, u)


@given(MATRIX, st.data())
def test_squared_distance_is_the_rational_least_squares_value(X, data):
    o = data.draw(hnp.arrays(np.float64, X.shape[1], elements=SMALL | st.sampled_from([0.1, 2.0**-40])))
    assert squared_distance(X, o) == distance(X, o)


@pytest.mark.parametrize(
    "X", [[[0.1, 0.7, 3.0], [0.1, 0.7, np.nextafter(3.0, 4)]], [[1e-150, 1e150, 1.0], [5e-324, 1.0, 1.0]]]
)
def test_squared_distance_of_hard_floats(X):
    o = np.array([0.3, 0.2, -1.0])
    assert squared_distance(np.array(X), o) == distance(X, o)


@pytest.mark.parametrize("p", MULTIPLES)
def test_multiples_of_the_prime_give_the_right_distance(p):
    for X, o in (([[p]], [1.0]), ([[p, 0.0], [0.0, p]], [1.0, 2.0]), ([[p, 1.0], [0.0, p]], [1.0, 2.0])):
        assert squared_distance(np.array(X), np.array(o)) == distance(X, o), (X, o)


def is_null(X, ball):
    """Whether the ball holds an exact b with X'b = 0: for every free choice that its exact entries leave."""
    rows, mid = fractions(X), fractions(ball.mid)
    exact = [i for i, rad in enumerate(ball.rad.tolist()) if rad == 0.0]
    blurred = [i for i in range(len(mid)) if i not in exact]
    columns = transposed(rows)
    system = [[c[i] for i in blurred] + [-sum(c[i] * mid[i] for i in exact)] for c in columns]
    echelon = eliminated(system)
    value = {}
    for row in reversed(echelon):
        lead = next(k for k, v in enumerate(row) if v)
        assert lead < len(blurred), f"no solution: {row}"
        value[lead] = (row[-1] - sum(row[k] * value[k] for k in range(lead + 1, len(blurred)))) / row[lead]
    for k, i in enumerate(blurred):
        assert abs(value[k] - mid[i]) <= Fraction(ball.rad[i]), (i, float(value[k] - mid[i]), ball.rad[i])


@given(MATRIX, st.data())
def test_the_left_null_space_is_hit_exactly(X, data):
    X = X * data.draw(st.sampled_from([1.0, 0.1, 2.0**-30]))
    b = data.draw(hnp.arrays(np.float64, X.shape[0], elements=st.floats(-9, 9)))
    ball = into_left_null_space(X, b)
    assert ball is not None
    is_null(X, ball)
    if RowSpace.of(X).rank == X.shape[0]:
        assert not ball.mid.any(), ball


@pytest.mark.parametrize(
    ("X", "b", "expected"),
    [
        ([[1.0, 2.0], [0.0, 0.0]], [3.0, 5.0], [0.0, 5.0]),
        ([[1.0], [1.0]], [3.0, 5.0], [-5.0, 5.0]),
        ([[3.0], [1.0], [0.0]], [7.0, 1.0, 2.0], [-1 / 3, 1.0, 2.0]),
        ([[1.0, 0.0], [0.0, 1.0]], [3.0, 5.0], [0.0, 0.0]),
        (np.zeros((2, 2)), [3.0, 5.0], [3.0, 5.0]),
    ],
)
def test_left_null_space_of_known_matrices(X, b, expected):
    ball = into_left_null_space(np.array(X), np.array(b))
    assert ball.mid.tolist() == expected
    is_null(np.array(X), ball)


@pytest.mark.parametrize("p", MULTIPLES)
@pytest.mark.parametrize("shape", [(1, 1), (2, 1), (2, 3)])
def test_multiples_of_the_prime_never_pass_for_zero_rows(p, shape):
    X = np.full(shape, p)
    assert RowSpace.of(X).rows == (0,)
    is_null(X, into_left_null_space(X, np.arange(1.0, shape[0] + 1)))


def test_a_null_vector_beyond_float64_is_not_claimed():
    assert into_left_null_space(np.array([[5e-324], [0.75]]), np.array([0.0, -2.0])) is None


def of_two_sizes(X):
    """Entries 1e+-150, which make integers of a thousand bits."""
    return X * 10.0 ** np.random.default_rng(4).choice([-150, 150], size=X.shape)


@pytest.mark.parametrize("shape", [(60, 500), (500, 60)])
def test_the_limit_of_exact_work_counts_bits(shape):
    random = np.random.default_rng(3)
    X, o = random.normal(size=shape), random.normal(size=shape[1])
    assert squared_distance(X, o) is not None
    assert squared_distance(of_two_sizes(X), o) is None
    assert squared_distance(of_two_sizes(X[:12, :40]), o[:40]) is not None


@pytest.mark.parametrize(("shape", "known"), [((40, 30), True), ((200, 100), False)])
def test_the_limit_of_exact_work_counts_what_deficient_rank_costs(shape, known):
    X = np.random.default_rng(5).normal(size=shape)
    assert RowSpace.within_limit(X).rank == shape[1]
    X[:, 0] = X[:, 1]
    space = RowSpace.within_limit(X)
    assert (space is not None) == known, space
    assert space is None or space.rank == shape[1] - 1, space.rank
