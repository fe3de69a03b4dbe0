from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rational import term_bounds

from convexperc.problem.formulation import objective, residuals, terms
from convexperc.problem.problem import Problem

PARTITIONS = [[4], [1, 3], [1, 1, 1, 1], {"a": [0, 2], "b": [3, 1]}]


@st.composite
def small_cases(draw):
    """Dyadic entries so short that every term without a root is exact in float64."""
    n, spec = draw(st.integers(1, 3)), draw(st.sampled_from(PARTITIONS))
    entry = st.integers(-32, 32).map(lambda k: k / 8)
    X = np.array(draw(st.lists(st.lists(entry, min_size=4, max_size=4), min_size=n, max_size=n)))
    o, u = (np.array(draw(st.lists(entry, min_size=4, max_size=4))) for _ in range(2))
    w = np.array(draw(st.lists(entry, min_size=n, max_size=n)))
    one, two, three = (draw(st.integers(0, 40)) / 16 for _ in range(3))
    return (X, o, {"modalities": spec, "lambda1": one, "lambda2": two, "lambda3": three}), w, u


@given(small_cases())
def test_terms_equal_the_rational_ones(case):
    (X, o, settings), w, u = case
    problem = Problem(X, o, **settings)
    groups = [np.r_[c].tolist() for c in problem.modalities]
    loss, coupling, views, (low, high) = term_bounds(problem.X, problem.o, groups, problem.lambdas, (w, u))
    found = terms(problem, w, u)
    assert Fraction(found.loss) == loss
    assert Fraction(found.coupling) == coupling
    assert Fraction(found.view_norm) == views
    assert float(low) * (1 - 2e-15) <= found.modality_norm <= float(high) * (1 + 2e-15)
    assert found.total == objective(problem, w, u)
    assert found.total == pytest.approx(float(loss + coupling + views + high), rel=1e-14)


@given(small_cases(), st.integers(-40, 40), st.integers(-40, 40))
def test_both_homogeneities_hold_bit_for_bit(case, x, y):
    (X, o, settings), w, u = case
    problem = Problem(X, o, **settings)
    s, t = 2.0**x, 2.0**y
    one, two, three = problem.lambdas
    moved = Problem(
        s * problem.X,
        t * problem.o,
        modalities=problem.modalities,
        lambda1=s * s * one,
        lambda2=s * t * two,
        lambda3=s * s * t * three,
    )
    assert objective(moved, w * t / s, u * t / (s * s)) == t * t * objective(problem, w, u)


def test_residuals_are_x_transposed_w_minus_o_and_x_u_minus_w():
    problem = Problem([[1, 2, 3], [4, 5, 6]], [7, 8, 9], lambda1=1, lambda2=1, lambda3=1)
    p, q = residuals(problem, np.array([1.0, -1.0]), np.array([1.0, 0.0, 2.0]))
    assert p.tolist() == [-10.0, -11.0, -12.0]
    assert q.tolist() == [6.0, 17.0]


def test_a_term_without_its_lambda_is_absent_even_where_it_overflows():
    problem = Problem([[0.0]], [1.0], lambda1=0, lambda2=0, lambda3=0)
    with np.errstate(over="ignore"):
        found = terms(problem, np.array([1e308]), np.array([1e308]))
    assert (found.coupling, found.view_norm, found.modality_norm, found.total) == (0.0, 0.0, 0.0, 1.0)
