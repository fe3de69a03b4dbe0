"""What may be called certified or 0, against optima that are known in closed form."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from convexperc.problem.problem import Problem
from verification.checks.acceptance import (
    ABSOLUTE,
    RELATIVE,
    false_zeros,
    without_modality,
    without_view,
    wrongly_certified,
    wrongly_enclosed,
)
from verification.exact import referee

NONE, ALL = np.zeros(2, dtype=bool), np.ones(2, dtype=bool)


def separate(first: float, second: float, *, lambda2: float = 1.0, lambda3: float = 0.0) -> Problem:
    """X = I and lambda1 = 0: w_j = sign(o_j) max(0, |o_j| - lambda2/2), each on its own."""
    return Problem(
        np.eye(2), [first, second], modalities=[1, 1], lambda1=0.0, lambda2=lambda2, lambda3=lambda3
    )


def without_slack(problem: Problem) -> referee.Optimum:
    """The optimum with a dual point that speaks against no zero."""
    found = referee.optimum(problem)
    return replace(found, views=found.views * Fraction(0), modalities=())


def soft(o: Fraction, lambda2: Fraction) -> Fraction:
    """min_w (w - o)^2 + lambda2 |w|."""
    return o * o if abs(o) <= lambda2 / 2 else lambda2 * abs(o) - lambda2 * lambda2 / 4


@pytest.mark.parametrize("j", [0, 1])
def test_without_a_view_the_optimum_is_that_of_a_stiffer_problem(j: int) -> None:
    value = without_view(separate(2.0, 0.25), j)
    # (w - 2)^2 + w^2 + |w| is least at w = 3/4, where it is 23/8; a weight that is 0 costs nothing more
    true = (Fraction(23, 8) if j == 0 else soft(Fraction(2), Fraction(1))) + Fraction(1, 16)
    assert value.lower <= true <= value.upper, (float(value.lower), float(true))
    assert value.upper - value.lower < Fraction(1, 10**20), value


def test_without_a_modality_nothing_of_it_is_used() -> None:
    problem = Problem([[1.0, 1.0]], [3.0, 1.0], modalities=[1, 1], lambda1=1.0, lambda2=0.5, lambda3=0.5)
    # with u^2 = 0 and w > 1/4, u^1 = w - 1/4, so that F = (w - 3)^2 + (w - 1)^2 + w - 1/16, least at w = 7/4
    true = Fraction(25, 16) + Fraction(9, 16) + Fraction(7, 4) - Fraction(1, 16)
    value = without_modality(problem, 1)
    assert value.lower <= true <= value.upper, (float(value.lower), float(true))
    assert value.upper - value.lower < Fraction(1, 10**20), value


def test_a_weight_that_every_optimum_uses_is_not_0_even_if_the_dual_point_says_nothing() -> None:
    problem = separate(2.0, 0.25)
    truth = without_slack(problem)
    assert not false_zeros(problem, np.array([False, True]), ALL, truth), "u and w_1 are 0"
    found = false_zeros(problem, ALL, NONE, truth)
    assert len(found) == 1, found
    assert found[0].startswith("w*_0 = 0 is not so: without it F* is"), found


def test_a_weight_that_some_optimum_uses_is_not_proved_0() -> None:
    # |o_1| = lambda2 / 2 exactly: v_1 = lambda2, so that the constraint of the view has no slack
    problem = separate(2.0, 0.5)
    found = false_zeros(problem, np.array([False, True]), NONE, referee.optimum(problem))
    assert found == ["w*_1 = 0 is not so: an optimum may use it"], found


def test_a_modality_that_every_optimum_uses_is_not_0() -> None:
    problem = Problem([[1.0, 0.5]], [3.0, 1.0], modalities=[1, 1], lambda1=1.0, lambda2=0.5, lambda3=0.5)
    found = false_zeros(problem, np.array([False]), ALL, without_slack(problem))
    assert any(each.startswith("u*^0 = 0 is not so: without it") for each in found), found


def test_the_tolerances_are_the_documented_ones() -> None:
    assert (Fraction(1e-9), Fraction(1e-14)) == (RELATIVE, ABSOLUTE)


@pytest.mark.parametrize("factor", [Fraction(1, 2), Fraction(2)])
def test_a_gap_is_held_against_the_documented_tolerances(factor: Fraction) -> None:
    problem = separate(2.0, 0.25)
    truth = referee.optimum(problem)
    gap = float(factor * RELATIVE * truth.value.upper)
    false = factor > 1
    assert bool(wrongly_certified(gap, problem, truth)) is false
    lower = float(truth.value.lower)
    assert bool(wrongly_enclosed(lower, lower + gap, problem, truth)) is false
    assert wrongly_certified(np.inf, problem, truth)
    zero = separate(0.0, 0.0)
    assert wrongly_certified(1e-9, zero, referee.optimum(zero)), "nothing but 0 is certified where o = 0"


def test_the_absolute_tolerance_is_a_share_of_the_target() -> None:
    problem = Problem([[1.0]], [1e-3], lambda1=0.0, lambda2=0.0, lambda3=0.0)
    truth = referee.optimum(problem)
    assert truth.value.upper == 0, truth
    allowed = float(ABSOLUTE) * 1e-6
    assert not wrongly_certified(0.5 * allowed, problem, truth)
    assert wrongly_certified(2.0 * allowed, problem, truth)
