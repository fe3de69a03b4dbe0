"""Clarabel as users call it: every answer is a status, and is measured against the proved interval."""

import cvxpy as cp
import numpy as np
import pytest

from convexperc.solution.single import solve
from verification.checks.clarabel import Answer, Tally, by_scale, solve_directly
from verification.problems.families import seeded


def test_the_problem_that_is_posed_is_ours() -> None:
    for index in range(3):
        proof = solve(problem := seeded("random", 0, index)).certificate
        answer = solve_directly(problem)
        assert answer.optimal, answer
        assert answer.distance(proof.lower, proof.upper) < 1e-7, (index, answer, proof)


def test_a_failure_is_a_status(monkeypatch: pytest.MonkeyPatch) -> None:
    answer = solve_directly(seeded("extreme_target", 0, 4))
    assert (answer.status, answer.value) == ("infeasible", None), "F has a minimum"

    def broken(*args: object, **options: object) -> None:
        raise ArithmeticError("planted")

    monkeypatch.setattr(cp.Problem, "solve", broken)
    answer = solve_directly(seeded("random", 0, 0))
    assert answer == Answer("ArithmeticError", None)
    assert not answer.optimal
    assert not answer.inaccurate


def test_answers_are_measured_against_the_interval() -> None:
    tally = Tally()
    for answer in (
        Answer("optimal", 1.5),
        Answer("optimal", 1.0 - 1e-7),
        Answer("optimal", 2.1),
        Answer("optimal_inaccurate", 9.0),
        Answer("infeasible", None),
    ):
        tally.count(answer, 1.0, 2.0)
    assert tally == Tally(5, 3, 1, 1, 2, 2, 1, 1, worst=tally.worst)
    assert tally.worst == pytest.approx(0.05)
    assert Answer("optimal", 1e-300).distance(0.0, 0.0) == np.inf
    assert Answer("optimal", 1.0 - 1e-7).distance(1.0, 2.0) == pytest.approx(1e-7)


def test_tallies_add_up_but_for_the_worst() -> None:
    tally = Tally(1, 1, worst=0.5)
    tally.add(Tally(4, 2, 1, 1, 2, 2, 1, 1, worst=0.25))
    assert tally == Tally(5, 3, 1, 1, 2, 2, 1, 1, worst=0.5)


def test_every_problem_is_counted_once_at_each_scale() -> None:
    scales = (1e-8, 1.0, 1e8)
    found = by_scale(3, scales=scales)
    assert found == by_scale(3, scales=scales), found
    assert found["per_scale"] == [3, 3, 3], found
    assert found["share_off_1e-6"][0] == 1.0, found
    assert found["share_off_1e-6"][1] == 0.0 == found["share_not_optimal"][1], found
    assert found["share_not_optimal"][2] == 1.0, found
