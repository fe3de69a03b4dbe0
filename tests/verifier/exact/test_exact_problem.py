"""The problem over the rationals: of floats, as JSON, for another template, scaled."""

from fractions import Fraction

import pytest

from convexperc.errors import FileFormatError, ProblemError
from convexperc.problem.problem import Problem
from verification.exact.formulation import objective
from verification.exact.problem import ExactProblem
from verification.problems.families import FAMILIES, seeded

P = ExactProblem.small
GROUPED = P([[1, 2, 0], [0, 1, -1]], [1, -2, 1], [2, 1], 1, 2, 3)
ROOT_FREE = P([["1/3", 2, "5/7"], [0, 1, -1]], [1, "-2/9", 1], [1, 2], "1/5", 2, "3/4")


@pytest.mark.parametrize("family", FAMILIES)
def test_the_data_are_those_of_the_floats(family: str) -> None:
    problem = seeded(family, 3, 0, largest=(4, 8))
    found = ExactProblem.of(problem)
    assert [[float(x) for x in row] for row in found.X] == problem.X.tolist(), family
    assert [float(x) for x in found.o] == problem.o.tolist(), family
    assert [list(column) for column in found.columns] == [list(x) for x in zip(*found.X, strict=True)], family
    assert tuple(map(float, found.lambdas)) == problem.lambdas, family
    again = found.in_floats()
    assert again is not None, family
    assert ExactProblem.of(again) == found, family


def test_another_template_replaces_o_alone() -> None:
    o = (Fraction(1, 3), Fraction(2, 5), Fraction(-7))
    found = GROUPED.for_template(o)
    assert (found.o, found.X, found.groups, found.lambdas) == (o, GROUPED.X, GROUPED.groups, GROUPED.lambdas)
    assert found == P(GROUPED.X, o, [2, 1], 1, 2, 3), found


def test_a_scaled_problem_has_t_squared_of_the_objective() -> None:
    s, t = Fraction(3, 2), Fraction(5, 7)
    scaled = ROOT_FREE.scaled(s, t)
    w, u = (Fraction(2), Fraction(-1, 3)), (Fraction(1, 2), Fraction(3), Fraction(-4))
    there = objective(scaled, [t / s * x for x in w], [t / s**2 * x for x in u])
    here = objective(ROOT_FREE, w, u)
    assert here.width == there.width == 0, (here, there)
    assert there.lower == t**2 * here.lower, (here, there)


def test_problems_go_to_json_and_back() -> None:
    for problem in (GROUPED, P([["1/3"]], [1], [1], 0, "1/7", 2)):
        assert ExactProblem.from_json(problem.as_json()) == problem
    data = GROUPED.as_json()
    for key, bad, words in (
        ("X", [["1", "2"]], "rows of 3"),
        ("X", [[1.5, 2, 3]], "strings p/q"),
        ("o", ["1/0", "1", "1"], "strings p/q"),
        ("modalities", [2], "add up to 3"),
        ("modalities", [2, 0, 1], "whole numbers"),
        ("lambda2", "-1", "lambda2 must be >= 0"),
    ):
        with pytest.raises(FileFormatError, match=words):
            ExactProblem.from_json(data | {key: bad})
    apart = Problem(
        [[1, 2, 3]], [1, 2, 3], modalities={"a": [0, 2], "b": [1]}, lambda1=1, lambda2=1, lambda3=1
    )
    with pytest.raises(ProblemError, match="follow each other"):
        ExactProblem.of(apart).as_json()
    assert ExactProblem.of(apart).in_floats() is not None
    assert P([["1/3"]], [1], [1], 1, 1, 1).in_floats() is None
