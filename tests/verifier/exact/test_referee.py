"""The exact referee against closed forms, identities and itself."""

from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings

from convexperc.certificate.certificate import certify
from convexperc.problem.problem import Problem
from verification.exact.formulation import dual_objective, is_dual_feasible, objective
from verification.exact.numbers import Enclosure, rationals
from verification.exact.reduced import Reduced
from verification.exact.referee import optimum, violations
from verification.problems.families import FAMILIES, seeded
from verification.problems.strategies import problems

NARROW = Fraction(1, 10**30)
"""The closed forms are met to this share: the referee's own width on them is smaller still."""


def contains(enclosure: Enclosure, value: Fraction) -> bool:
    return enclosure.lower <= value <= enclosure.upper


def scalar(o: float, lambda1: float, lambda2: float, lambda3: float) -> Problem:
    return Problem([[1.0]], [o], lambda1=lambda1, lambda2=lambda2, lambda3=lambda3)


@pytest.mark.parametrize("o", [1.0, -3.0, 1e-8, 1e8, 2.0**-500, 1e150])
def test_the_scalar_family_has_the_optimum_19_o_o_over_32(o: float) -> None:
    truth = optimum(scalar(o, 1.0, abs(o) / 2, abs(o) / 4))
    exact = Fraction(19, 32) * Fraction(o) ** 2
    assert contains(truth.value, exact), (o, truth.value, exact)
    assert truth.value.width <= NARROW * exact, (o, float(truth.relative_width))


CLOSED = {
    "wrong limit of the absolute reading": (([[1.0]], [1.0]), (1.0, 1.0, 0.0), Fraction(3, 4), None),
    "locking of w": (([[1.0, 0.0], [3.0, 1.0]], [1.0, 0.0]), (1.0, 1.0, 0.0), Fraction(3, 8), None),
    "locking of u": (([[1.0, 3.0], [0.0, 1.0]], [1.0, 3.0]), (1.0, 0.0, 1.0), Fraction(135, 476), [1, 1]),
    "sign, all zero": (([[1.0]], [-1.0]), (1.0, 4.0, 0.0), Fraction(1), None),
    "least squares": (([[1.0, 1.0]], [1.0, 0.0]), (0.0, 0.0, 0.0), Fraction(1, 2), None),
    "lasso": (([[1.0]], [1.0]), (0.0, 1.0, 5.0), Fraction(3, 4), None),
}


@pytest.mark.parametrize("name", CLOSED)
def test_known_optima(name: str) -> None:
    (X, o), lambdas, exact, sizes = CLOSED[name]
    one, two, three = lambdas
    truth = optimum(Problem(X, o, modalities=sizes, lambda1=one, lambda2=two, lambda3=three))
    assert contains(truth.value, exact), (name, truth.value, exact)
    assert truth.value.width <= NARROW * exact, (name, float(truth.relative_width))


@pytest.mark.parametrize("family", FAMILIES)
def test_the_enclosure_is_tight_on_every_family(family: str) -> None:
    for index in range(family == "mixed_scales", 3):  # its first takes the referee four seconds
        truth = optimum(seeded(family, 5, index, largest=(5, 20)))
        assert 0 <= truth.value.lower <= truth.value.upper, (family, index, truth.value)
        assert truth.tight, (family, index, float(truth.relative_width))


@settings(max_examples=20)
@given(problem=problems())
def test_weak_duality_holds_exactly(problem: Problem) -> None:
    truth = optimum(problem)
    w, u = np.ones(problem.n), np.ones(problem.d)
    for t in (0.0, 0.5, -3.0):
        value = objective(problem, t * w, t * u)
        assert value.upper >= truth.value.lower, (problem, t, value, truth.value)
    zero = np.zeros(problem.n)
    for t in (0.0, 1e-3, 1.0):
        a = -t * problem.o
        if is_dual_feasible(problem, a, zero):
            dual = dual_objective(problem, a, zero)
            assert dual <= truth.value.upper, (problem, t, dual, truth.value)


@settings(max_examples=40)
@given(problem=problems("random"))
def test_the_gap_is_a_sum_of_terms_that_are_not_negative(problem: Problem) -> None:
    """The identity of the duality gap, over the rationals, where no norm is irrational."""
    w, u = rationals([0.5] * problem.n), rationals([0.0] * problem.d)
    o = rationals(problem.o)
    X = np.array([rationals(row) for row in problem.X])
    lambda1, lambda2 = Fraction(problem.lambda1), Fraction(problem.lambda2)
    a, b = rationals([0.25] * problem.d), rationals([-0.5] * problem.n)
    p, q, v = X.T @ w - o, X @ u - w, X @ a - b
    terms = sum((p - a / 2) ** 2) + lambda1 * sum((q - b / (2 * lambda1)) ** 2)
    terms += sum(lambda2 * abs(w)) + w @ v
    difference = objective(problem, w, u).upper - dual_objective(problem, a, b)
    assert difference == terms, (problem, difference, terms)


def test_an_exact_objective_matches_a_hand_computation() -> None:
    p = Problem([[1.0, 2.0]], [1.0, 1.0], modalities=[2], lambda1=2.0, lambda2=3.0, lambda3=4.0)
    found = objective(p, [2.0], [3.0, 4.0])
    exact = Fraction((2 - 1) ** 2 + (4 - 1) ** 2 + 2 * (11 - 2) ** 2 + 3 * 2 + 4 * 5)
    assert found == Enclosure(exact, exact), (found, exact)


def test_feasibility_is_decided_to_the_last_bit() -> None:
    p = scalar(1.0, 1.0, 0.5, 0.25)
    assert is_dual_feasible(p, [-0.25], [0.25]), "on both boundaries"
    assert not is_dual_feasible(p, [-0.25], [np.nextafter(0.25, 1)]), "one bit beyond lambda3"
    assert not is_dual_feasible(p, [np.nextafter(-0.25, -1)], [0.25]), "one bit beyond lambda2"
    uncoupled = scalar(1.0, 0.0, 0.5, 0.25)
    assert not is_dual_feasible(uncoupled, [0.0], [5e-324]), "b must be 0 without coupling"


@pytest.mark.parametrize("family", ["subnormal_entries", "mixed_scales", "rank_deficient"])
def test_the_reduction_is_exact(family: str) -> None:
    p = seeded(family, 2, 1, largest=(3, 6))
    X = np.array([rationals(row) for row in p.X])
    o = rationals(p.o)
    reduced = Reduced.of(p)
    assert (reduced.G == X @ X.T).all(), (family, p.X)
    assert (reduced.c == X @ o).all(), (family, p.X, p.o)
    assert reduced.target == o @ o, (family, p.o)


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"lower": 0.7}, "lower"),
        ({"upper": 0.5}, "upper"),
        ({"gap": 0.0}, "gap"),
        ({"relative_gap": 1e-3}, "relative gap"),
        ({"objective": (2.0, 3.0)}, "objective"),
        ({"objective": (0.0, 0.5)}, "objective"),
    ],
)
def test_each_false_statement_of_a_certificate_is_named_alone(change: dict[str, Any], named: str) -> None:
    problem = scalar(1.0, 1.0, 0.5, 0.25)  # F* = 19/32 and F(0, 0) = 1
    proof, truth = certify(problem, [0.0], [0.0]), optimum(problem)
    assert violations(problem, np.zeros(1), np.zeros(1), proof, truth) == []
    found = violations(problem, np.zeros(1), np.zeros(1), replace(proof, **change), truth)
    assert [each.startswith(named) for each in found] == [True], found
