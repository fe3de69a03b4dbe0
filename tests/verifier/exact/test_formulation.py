"""F, D and the residuals over the rationals against the tests' own formulas, in every family."""

from fractions import Fraction

import numpy as np
import pytest
from flint import arb
from rational import fractions, inner, objective_bounds, root_bounds, transposed

from convexperc.errors import InputError
from convexperc.problem.problem import Problem
from verification.checks.measures import drawn_point
from verification.exact.balls import exact, precision
from verification.exact.formulation import dual_objective, is_dual_feasible, norms, objective, residuals
from verification.exact.numbers import Enclosure, rationals
from verification.exact.problem import ExactProblem
from verification.problems.families import FAMILIES, seeded
from verification.problems.sources import Seeded

BALL_BITS = 8192
"""Bits of the balls: more than the squares of any family's entries span."""

NARROW = Fraction(1, 2**390)


def meet(first: Enclosure, second: Enclosure) -> bool:
    return first.lower <= second.upper and second.lower <= first.upper


def drawn(family: str, index: int) -> tuple[Problem, np.ndarray, np.ndarray]:
    problem = seeded(family, 2, index, largest=(4, 9))
    return problem, *drawn_point(problem, Seeded(np.random.default_rng(index), (4, 9)))


@pytest.mark.parametrize("family", FAMILIES)
def test_the_objective_is_that_of_the_tests_at_floats_and_at_balls(family: str) -> None:
    for index in range(3):
        problem, w, u = drawn(family, index)
        own = objective_bounds(problem.X, problem.o, ExactProblem.of(problem).groups, problem.lambdas, (w, u))
        found = objective(problem, w, u)
        assert meet(found, Enclosure(*own)), (family, index, found, own)
        assert found.width <= NARROW * found.upper, (family, index, found)
        with precision(BALL_BITS):
            ball_w, ball_u = ([arb(exact(x)) for x in part.tolist()] for part in (w, u))
            mixed = objective(problem, w, ball_u)
            inside = objective(problem, ball_w, ball_u)
        for each in (mixed, inside):
            assert meet(each, Enclosure(*own)), (family, index, each, own)
            assert each.width <= NARROW * found.upper, (family, index, each)


@pytest.mark.parametrize("family", FAMILIES)
def test_each_term_is_that_of_the_tests_at_rationals(family: str) -> None:
    problem, w, u = drawn(family, 0)
    w, u = rationals(w) / 3, rationals(u) / 7
    X, o = fractions(problem.X), fractions(problem.o)
    own_p = [inner(column, w) - target for column, target in zip(transposed(X), o, strict=True)]
    own_q = [inner(row, u) - weight for row, weight in zip(X, w, strict=True)]
    p, q = residuals(problem, w, u)
    assert (list(p), list(q)) == (own_p, own_q), family
    bounds = [root_bounds(inner(u[c], u[c])) for c in problem.modalities]
    found = norms(problem, u)
    assert all(meet(x, Enclosure(*y)) for x, y in zip(found, bounds, strict=True)), family
    l1, l2, l3 = fractions(problem.lambdas)
    smooth = inner(p, p) + l1 * inner(q, q) + l2 * sum(map(abs, w))
    ends = (smooth + l3 * sum(getattr(x, end) for x in found) for end in ("lower", "upper"))
    assert objective(problem, w, u) == Enclosure(*ends), family


@pytest.mark.parametrize("family", FAMILIES)
def test_the_dual_is_that_of_the_tests(family: str) -> None:
    problem, w, _ = drawn(family, 1)
    X, o, (l1, l2, l3) = fractions(problem.X), fractions(problem.o), fractions(problem.lambdas)
    for t in (Fraction(0), Fraction(1, 3), Fraction(1, 10**9), Fraction(-5)):
        a, b = [t * x for x in o], [t * Fraction(float(x)) if l1 else Fraction(0) for x in w]
        value = -inner(a, o) - inner(a, a) / 4 - (inner(b, b) / (4 * l1) if l1 else 0)
        assert dual_objective(problem, a, b) == value, (family, t)
        pull = [inner(column, b) for column in transposed(X)]
        blocks = [[pull[k] for k in np.arange(problem.d)[c]] for c in problem.modalities]
        feasible = all(abs(inner(row, a) - v) <= l2 for row, v in zip(X, b, strict=True))
        feasible = feasible and all(inner(block, block) <= l3 * l3 for block in blocks)
        assert is_dual_feasible(problem, a, b) == feasible, (family, t)


def test_norms_are_rational_where_they_can_be() -> None:
    problem = ExactProblem.small([[1, 0, 0]], [1, 1, 1], [2, 1], 1, 0, 1)
    u = (Fraction(3, 7), Fraction(4, 7), Fraction(0))
    assert norms(problem, u) == [
        Enclosure(Fraction(5, 7), Fraction(5, 7)),
        Enclosure(Fraction(0), Fraction(0)),
    ]
    assert objective(problem, (Fraction(1),), u).width == 0


def test_points_of_another_size_are_named() -> None:
    problem = ExactProblem.small([[1, 2]], [1, 1], [2], 1, 1, 1)
    with pytest.raises(InputError, match="w must have 1 entries"):
        objective(problem, [1.0, 2.0], [1.0, 2.0])
    with pytest.raises(InputError, match="u must have 2 entries"):
        norms(problem, [1.0])
