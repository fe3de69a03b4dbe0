"""Each faulty solver is caught at the level that names its fault; sound ones pass every level."""

from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from faulty_solvers import NUMERIC, library, method

from convexperc.problem.problem import Problem
from convexperc.solution.single import solve
from verification.conformance import adapters
from verification.conformance.answers import Answer
from verification.conformance.doors import Function, Reply
from verification.conformance.judge import Level, judge
from verification.conformance.profiles import FLOAT32, FLOAT64
from verification.conformance.request import Request
from verification.conformance.suite import Report, Selection, run
from verification.conformance.vectors import Vector, all_vectors
from verification.ledger.evidence import Outcome


def reports(solver: Callable[..., Any], *only: str, **selection: Any) -> list[Report]:
    return [run(Function(solver), Selection(only=each, **selection)) for each in only]


@pytest.mark.parametrize("name", NUMERIC)
def test_a_fault_is_caught_at_its_level(name: str):
    level, solver = NUMERIC[name]
    found = reports(solver, "random-0[1357]", "set-2[01]", "malformed", "sensitive-*")
    failed = {each.level for report in found for each in report.failed}
    assert failed, name
    assert min(failed) == level, (name, failed, [report.failed[:2] for report in found])


def test_a_label_is_judged_by_what_the_solver_says_its_optimum_is():
    def reversed_(X: Any, o: Any, modalities: Any, **weights: float) -> Any:
        found = library(X, o, modalities, **weights)
        return found | {"objective": 1.0 / (1.0 + found["objective"])}

    failed = reports(reversed_, "set-2[0-3]")[0].failed
    assert {each.id for each in failed if each.level is Level.L3} == {f"set-2{k}" for k in range(4)}, failed
    assert "proved is" in failed[-1].detail


def test_a_zero_that_is_not_one_is_named():
    failed = reports(NUMERIC["zeros filled"][1], "zero-*")[0].failed
    named = [each for each in failed if each.level is Level.L3]
    assert named, failed
    assert all("proved is 0" in each.detail for each in named), named


@pytest.mark.parametrize("solver", [library, adapters.library], ids=["function", "adapter"])
def test_the_library_passes_every_level(solver: Callable[..., Any]):
    extreme = run(Function(solver), Selection(only="extreme"))
    assert not extreme.failed, extreme.failed
    report = run(Function(solver), Selection())
    assert not report.failed, report.failed
    assert not report.open, report.open
    assert report.reached == "L3"
    assert min(report.digits) > 8.9


def test_the_exact_referee_passes_every_level():
    report = run(Function(adapters.exact), Selection(only="random-*"))
    assert not report.failed, report.failed
    assert report.reached == "L3"


def test_a_sound_method_in_float32_passes_in_float32_and_not_in_float64():
    import numpy as np  # noqa: PLC0415

    solver = method(kind=np.float32, iterations=3000)
    single = run(Function(solver), Selection(FLOAT32, "random-0*"))
    assert not single.failed, single.failed
    double = run(Function(solver), Selection(FLOAT64, "sensitive-*"))
    assert {each.level for each in double.failed} >= {Level.L1, Level.L2}, double.failed


def test_the_corrected_algorithm_never_rises_and_the_printed_one_does():
    corrected = run(Function(adapters.paper_corrected), Selection(only="random-*"))
    assert not [each for each in corrected.failed if each.level is Level.L4], corrected.failed
    assert corrected.counts(Level.L4)["held"] > 0
    printed = run(Function(adapters.paper_printed), Selection(only="random-*"))
    assert [each for each in printed.failed if each.level is Level.L4]


def test_what_a_solver_declines_is_no_pass():
    def declines(X: Any, o: Any, modalities: Any, **weights: float) -> Any:
        if len(X) > 1:
            raise NotImplementedError("one robot only")
        return library(X, o, modalities, **weights)

    report = run(Function(declines), Selection(only="random-*"))
    assert not report.failed, report.failed
    assert report.open
    assert "declined" in report.statement
    assert len(all_vectors().problems) >= 400


def test_a_malformed_line_may_be_declined():
    def declines(X: Any, o: Any, modalities: Any, **weights: float) -> Any:
        raise NotImplementedError("nothing")

    report = run(Function(declines), Selection(only="malformed"))
    assert not report.failed
    assert report.declined


@pytest.mark.parametrize(("said", "outcome"), [(3.3e-13, Outcome.HELD), (1e-10, Outcome.FAILED)])
def test_what_is_said_of_f_is_known_no_better_than_f_can_be_computed(said: float, outcome: Outcome):
    """Two views are nearly equal, no weight holds them, and w of 1.5e8 cancels in X'w - o."""
    almost = [1.5000000027939677, 1.0000000018626451, -1.9999999962747097, 0.0]
    X = [almost, [1.5, 1.0, -2.0, 0.0], [1.0, -2.5, 1.0, 2.0], [-2.5, -2.5, 3.0, 1.0]]
    o = [-4.625, 2.8125, -0.5, -2.0]
    problem = Problem(X, o, modalities=[1, 1, 1, 1], lambda1=0.0, lambda2=0.0, lambda3=1.0)
    found = solve(problem)
    bounds = Fraction(found.certificate.lower), Fraction(found.certificate.upper)
    answer = Answer(found.w, found.u, said, np.array([said]))
    case = Vector(Request("found", problem), *bounds)
    judged = {each.level: each for each in judge(case, Reply(answer), FLOAT64).findings}
    assert judged[Level.L1].outcome is outcome, judged[Level.L1]
    assert (judged[Level.L4].outcome is Outcome.FAILED) == (outcome is Outcome.FAILED), judged[Level.L4]
