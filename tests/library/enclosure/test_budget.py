"""A budget that runs out at any point leaves what is proved, says so, and claims nothing else."""

import json
import math
from fractions import Fraction
from itertools import count

import numpy as np
import pytest

from convexperc import (
    Problem,
    Status,
    Verdict,
    decided_by,
    enclose,
    recognize,
    recognize_path,
    solve,
    solve_many,
    solve_path,
    weight_intervals,
)
from convexperc.enclosure import budget as module
from convexperc.enclosure import levels
from convexperc.enclosure.budget import Budget, OutOfBudget
from convexperc.errors import BudgetError
from convexperc.report import proof_record
from convexperc.solvers.interface import SolverResult
from verification.problems.families import seeded
from verification.proof_checker import check

LAMBDAS = {"lambda1": 1.0, "lambda2": 0.3, "lambda3": 0.2}
RNG = np.random.default_rng(7)
X, O = RNG.normal(size=(4, 9)), RNG.normal(size=(9, 3))
ROOM = 12
"""Ways to end each kind of work, from its first look at the clock to its last."""


class Poor:
    """Answers w = u = 0, whatever it is asked."""

    name = "poor"

    def solve(self, problem: Problem) -> SolverResult:
        return SolverResult(np.zeros(problem.n), np.zeros(problem.d), "optimal", 1)


def deficient(lambda2: float) -> Problem:
    rows = np.vstack([X[:2], X[0] - 2 * X[1]])
    return Problem(rows, O[:, 0], modalities=[4, 5], lambda1=1.0, lambda2=lambda2, lambda3=0.0)


PROBLEMS = {
    "coupled": Problem(X, O[:, 0], modalities=[4, 5], **LAMBDAS),
    "uncoupled": Problem(X, O[:, 0], lambda1=0.0, lambda2=0.3, lambda3=0.2),
    "a lasso with dependent views": deficient(0.3),
    "least squares": deficient(0.0),
    "wide": seeded("mixed_scales", 11, 1, largest=(8, 40)),
    "all zero": Problem(X, O[:, 0], lambda1=1.0, lambda2=1e9, lambda3=1.0),
    "o = 0": Problem(X, np.zeros(9), **LAMBDAS),
}


@pytest.fixture
def clock(monkeypatch):
    """A clock that goes on by one second whenever it is looked at; how often that was."""
    looked = count()
    monkeypatch.setattr(module, "perf_counter", lambda: float(next(looked)))
    return looked


def ends(work, clock):
    """Some budgets from the smallest to the one that is just enough for the work."""
    before = next(clock)
    work(math.inf)
    most = next(clock) - before
    return sorted({0.5, *np.unique(np.geomspace(1, most + 2, ROOM).round()).tolist()})


@pytest.mark.parametrize("name", PROBLEMS)
def test_an_enclosure_holds_the_optimum_wherever_it_ends(name, clock):
    problem = PROBLEMS[name]
    truth = enclose(problem, seconds=math.inf)
    reasons = []
    for seconds in ends(lambda given: enclose(problem, seconds=given), clock):
        found = enclose(problem, seconds=float(seconds))
        assert found.exact.lower <= truth.exact.upper, (seconds, found)
        assert truth.exact.lower <= found.exact.upper, (seconds, found)
        assert Fraction(found.lower) <= found.exact.lower, (seconds, found)
        assert found.exact.upper <= (Fraction(found.upper) if math.isfinite(found.upper) else math.inf)
        narrow = found.relative_width <= 1e-12 or found.share_of_target <= 1e-15
        ran_out = f"the budget of {seconds:g} s for ball arithmetic does not suffice; give more `seconds`"
        assert found.reason == ran_out or narrow, (seconds, found)
        reasons.append(found.reason)
    assert "not suffice" in reasons[0] or math.isfinite(truth.relative_width) or name == "o = 0", reasons
    last = enclose(problem, seconds=math.inf)
    assert (last.lower, last.upper, last.reason) == (truth.lower, truth.upper, truth.reason)


def test_with_nothing_left_for_balls_the_interval_is_that_of_float64():
    problem = PROBLEMS["coupled"]
    found, alone = enclose(problem, seconds=1e-9), solve(problem).certificate
    assert "not suffice" in found.reason, found
    assert found.steps == 0, found
    assert (found.w.tolist(), found.u.tolist()) == ([0.0] * 4, [0.0] * 9)
    assert 0.0 < found.lower <= found.upper, found
    assert found.upper - found.lower <= 1e-6 * found.upper, found
    assert found.lower <= alone.upper, (found, alone)
    assert alone.lower <= found.upper, (found, alone)


@pytest.mark.parametrize("name", PROBLEMS)
def test_a_solution_is_certified_by_its_gap_alone(name, clock):
    problem = PROBLEMS[name]
    truth = enclose(problem, seconds=math.inf).exact

    def work(given):
        return solve(problem, Poor(), escalate=True, seconds=float(given))

    for seconds in ends(work, clock):
        found = work(seconds)
        proof = found.certificate
        assert Fraction(proof.lower) <= truth.upper, (seconds, proof)
        assert math.isinf(proof.upper) or truth.lower <= Fraction(proof.upper), (seconds, proof)
        assert (found.status is Status.CERTIFIED) == proof.certified
        assert not (proof.certified and found.reason), found
        assert proof.enclosed or found.reason, (seconds, found)
    stopped = solve(PROBLEMS["coupled"], Poor(), escalate=True, seconds=1e-9)
    assert (stopped.status, stopped.solver) == (Status.NOT_CERTIFIED, "poor")
    assert "the budget of 1e-09 s" in stopped.reason, stopped.reason


@pytest.mark.parametrize("name", PROBLEMS)
def test_intervals_of_weights_hold_wherever_they_end(name, clock):
    problem = PROBLEMS[name]
    solution = solve(problem, seconds=math.inf)
    truth = weight_intervals(solution, seconds=math.inf)
    for seconds in ends(lambda given: weight_intervals(solution, seconds=float(given)), clock):
        found = weight_intervals(solution, seconds=float(seconds))
        for mine, whole in ((found.views, truth.views), (found.modalities, truth.modalities)):
            assert (mine.lower <= whole.upper).all(), (seconds, mine)
            assert (whole.lower <= mine.upper).all(), (seconds, mine)
            assert mine.determined.all() or mine.reason, (seconds, mine)
    short = weight_intervals(solution, seconds=0.5)
    assert "the budget of 0.5 s" in short.views.reason, short.views
    assert not short.views.determined.any(), short.views


@pytest.mark.parametrize("name", PROBLEMS)
def test_a_proof_file_is_accepted_wherever_its_search_ends(name, clock):
    solution = solve(PROBLEMS[name], Poor())
    for seconds in ends(lambda given: proof_record(solution, seconds=float(given)), clock):
        verdict = check(json.dumps(proof_record(solution, seconds=float(seconds))))
        assert verdict.proved, (seconds, verdict)


CLOSE = {"one": O[:, 0], "another": O[:, 0] * (1 + 2**-40), "the third": O[:, 1]}


def test_a_label_is_proved_or_the_budget_is_named(clock):
    def work(given):
        return recognize(X, CLOSE, solver=Poor(), modalities=[4, 5], seconds=float(given), **LAMBDAS)

    truth = work(math.inf)
    assert (truth.verdict, truth.label) == (Verdict.PROVED, "one"), truth.reason
    seen = set()
    for seconds in ends(work, clock):
        found = work(seconds)
        seen.add(found.verdict)
        assert found.label in (None, "one"), (seconds, found.label)
        named = f"the budget of {seconds:g} s for ball arithmetic does not suffice" in found.reason
        assert named == (found.verdict is Verdict.UNDECIDED), (seconds, found.reason)
    assert seen == {Verdict.UNDECIDED, Verdict.PROVED}


@pytest.fixture
def precisions(monkeypatch):
    """The precisions that are worked in, in order."""
    seen, honest = [], levels.Known._level

    def level(self, bits, tolerances):
        seen.append(bits)
        return honest(self, bits, tolerances)

    monkeypatch.setattr(levels.Known, "_level", level)
    return seen


def test_a_tie_of_the_last_candidates_needs_no_more_bits_than_the_others_exclusion(precisions):
    """With the third rival excluded, the first two are seen to be the same but for the order of the data."""
    views = np.array([[2.0, 1.0, 0.5, 0.25], [1.0, 2.0, 0.25, 0.5]])
    first = np.array([1.0, 0.5, 0.75, 0.25])
    objects = {"a": first, "b": first[[1, 0, 3, 2]], "c": first * (1 + 2**-45), "a again": first}
    found = recognize(views, objects, modalities=[2, 2], lambda1=1.0, lambda2=0.1, lambda3=0.1, prune=False)
    assert found.verdict is Verdict.TIE, found.reason
    assert found.candidates == ("a", "b", "a again"), found
    assert precisions == [128] * 3, precisions


def test_a_rival_that_is_excluded_is_narrowed_no_more(precisions, monkeypatch):
    monkeypatch.setattr(levels, "BITS", (53, 64, 128))
    monkeypatch.setattr("convexperc.recognition.narrowing.BITS", (53, 64, 128))
    o = O[:, 0]
    objects = {"near": o * (1 + 2**-48), "far": o * (1 + 2**-20), "best": o}
    found = recognize(X, objects, modalities=[4, 5], solver=Poor(), escalate=False, **LAMBDAS)
    assert found.verdict is Verdict.UNDECIDED
    assert decided_by(found, "objective").label == "best"
    assert precisions == [53] * 3 + [64] * 2, precisions


DOORS = {
    "solve": lambda seconds: solve(PROBLEMS["coupled"], seconds=seconds),
    "enclose": lambda seconds: enclose(PROBLEMS["coupled"], seconds=seconds),
    "weight_intervals": lambda seconds: weight_intervals(solve(PROBLEMS["coupled"]), seconds=seconds),
    "proof_record": lambda seconds: proof_record(solve(PROBLEMS["coupled"]), seconds=seconds),
    "solve_many": lambda seconds: solve_many(X, O, seconds=seconds, **LAMBDAS),
    "solve_path": lambda seconds: next(solve_path(X, O, [(1, 1, 1)], seconds=seconds)),
    "recognize": lambda seconds: recognize(X, O, seconds=seconds, **LAMBDAS),
    "recognize_path": lambda seconds: next(recognize_path(X, O, [(1, 1, 1)], seconds=seconds)),
    "decided_by": lambda seconds: decided_by(recognize(X, O, **LAMBDAS), "objective", seconds=seconds),
}


@pytest.mark.parametrize("door", DOORS)
@pytest.mark.parametrize("seconds", [0.0, -1.0, math.nan, -math.inf])
def test_a_budget_is_a_number_above_zero_at_every_door(door, seconds):
    with pytest.raises(
        BudgetError, match=r"seconds must be a number > 0; got .* Pass math\.inf for no limit"
    ):
        DOORS[door](seconds)
    DOORS[door](math.inf)


@pytest.mark.parametrize("seconds", ["1", None, True, 1j, [1.0], np.ma.masked])
def test_a_budget_is_a_real_number(seconds):
    with pytest.raises(BudgetError, match="seconds must"):
        Budget(seconds)


def test_a_step_that_would_take_longer_than_what_is_left_is_not_begun(clock):
    budget = Budget(10)
    budget.require(9e9)
    with budget.running():
        budget.require(6e9)
        with budget.running(), pytest.raises(OutOfBudget):
            budget.require(9e9)
    assert budget.spent
    assert 0.0 < budget.left < 10.0, budget.left
    with pytest.raises(OutOfBudget):
        budget.require()
    assert Budget(math.inf).reason == ""
    Budget(math.inf).require(1e300)


def test_the_clock_stands_still_outside(clock):
    budget = Budget(5)
    with budget.running():
        pass
    left = budget.left
    next(clock), next(clock)
    assert budget.left == left == 4.0
