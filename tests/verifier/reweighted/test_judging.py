"""Loops judged: known failures are found, planted faults are named, and sound loops are not accused."""

from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import strategies as st

from convexperc.errors import InputError
from verification.exact.balls import Numbers
from verification.reweighted import Answer, Loop, Word, each_loss, norm, norm1, squares, variable
from verification.reweighted.loops.judging import QUESTIONS, judge_loop
from verification.reweighted.objectives.objective import Objective

Build = Callable[..., Loop]
LINE = {"points": st.lists(st.integers(-4, 4), min_size=2, max_size=5)}
ROW = {"a": st.integers(1, 3), "y": st.integers(-3, 3)}
COLUMN = {"y": st.lists(st.integers(-4, 4), min_size=2, max_size=4)}
HUBER = "r**2/2 if abs(r) <= c else c*abs(r) - c**2/2"
CAUCHY = "c**2/2*log(1 + (r/c)**2)"
HALF = "r**2/2"


def median(weight: str = "1/(2*r)", **options: Any) -> Build:
    def build(points: list[int]) -> Loop:
        x = variable("x", 1)
        return Loop(sum((norm(x - [p], weight) for p in points), Objective(())), **options)

    return build


def lasso(weight: str = "1/(2*abs(r))", **options: Any) -> Build:
    def build(a: int, y: int) -> Loop:
        x = variable("x", 1)
        return Loop(squares(np.array([[a]]) @ x - [y]) + norm1(x, weight), **options)

    return build


def smoothed_median(points: list[int]) -> Loop:
    """With a width that has the unit of r squared, and a stopping rule that has none."""
    x = variable("x", 1)

    def stop(before: Any, after: Any) -> bool:
        return bool(np.abs(after["x"] - before["x"]).max() <= 1e-12 * np.abs(after["x"]).max())

    weight, widths = "1/(2*sqrt(r**2 + e))", {"e": Fraction(1, 10**12)}
    return Loop(sum((norm(x - [p], weight, widths=widths) for p in points), Objective(())), stop=stop)


def deviations(row: list[int]) -> Build:
    """Of data that determine no more than one of two coefficients."""

    def build(points: list[int]) -> Loop:
        b = variable("b", 2)
        return Loop(norm1(np.array([row] * len(points)) @ b - points))

    return build


def group(weight: str = "1/(2*r)", of_each: bool = False) -> Build:
    def build(a: int, y: int) -> Loop:
        x = variable("x", 2)
        fit = squares(np.array([[a, 1]]) @ x - [y]) + squares(x[:1] - [y])
        return Loop(fit + norm(x, weight) if not of_each else fit + norm(x[:1], weight) + norm(x[1:], weight))

    return build


def location(loss: str, weight: str, square: str = HALF, start: int | None = None, **widths: Any) -> Build:
    def build(y: list[int]) -> Loop:
        residual = np.ones((len(y), 1), dtype=int) @ variable("x", 1) - y
        begin = None if start is None else {"x": [start]}
        return Loop(each_loss(residual, loss, weight, square=square, widths=widths), start=begin)

    return build


def views(of_w: str = "1/(2*abs(r))", of_u: str = "1/(2*r)", order: str = "gauss_seidel") -> Build:
    def build(a: int, y: int) -> Loop:
        w, u = variable("w", 1), variable("u", 1)
        X = np.array([[a]])
        F = squares(X.T @ w - [y]) + squares(X @ u - w) + norm1(w, of_w) + norm(u, of_u)
        return Loop(F, [["w"], ["u"]], order)

    return build


def stale(points: list[int]) -> Loop:
    """Weights of the start, never computed anew: what is updated is the mean of the data by these."""
    x = variable("x", 1)

    def update(point: Mapping[str, Numbers]) -> Mapping[str, Numbers]:
        weights = [1 / (1 + abs(p)) for p in map(int, points)]
        mean = sum(w * p for w, p in zip(weights, points, strict=True)) / sum(weights)
        return {"x": [(point["x"][0] + round(mean)) / 2]}

    return Loop(sum((norm(x - [p]) for p in points), Objective(())), update=update)


def mean(points: list[int]) -> Loop:
    """The mean in place of the median: the weights are missing."""
    x = variable("x", 1)
    return Loop(sum((norm(x - [p], "1") for p in points), Objective(())))


def absolute_stop(points: list[int]) -> Loop:
    def stop(before: Mapping[str, Any], after: Mapping[str, Any]) -> bool:
        return abs(float(after["x"][0] - before["x"][0])) <= 1e-3

    x = variable("x", 1)
    return Loop(sum((norm(x - [p]) for p in points), Objective(())), stop=stop)


PLANTED: tuple[tuple[str, Build, Mapping[str, Any], str], ...] = (
    ("the factor of a norm beside squares", lasso("1/abs(r)"), ROW, "descends"),
    ("half of it", lasso("1/(4*abs(r))"), ROW, "descends"),
    ("the sign of an entry", lasso("1/(2*r)"), ROW, "descends"),
    ("the missing square: weight 1", lasso("1"), ROW, "descends"),
    ("the weight of a square root of the norm", lasso("1/(4*abs(r)**(3/2))"), ROW, "descends"),
    ("a weight that rises", lasso("abs(r)"), ROW, "descends"),
    ("a negative weight", lasso("-1/(8*abs(r))"), ROW, "descends"),
    ("the factor of a group", group("1/r"), ROW, "descends"),
    ("groups of one in place of a group", group("1/(2*r**2)"), ROW, "descends"),
    ("the paper's sign", views("1/(2*r)"), ROW, "descends"),
    ("the paper's factor of w", views("1/(4*abs(r))"), ROW, "descends"),
    ("the paper's factor of u", views("1/(2*abs(r))", "1/(4*r)"), ROW, "descends"),
    ("the paper's factor, Jacobi", views("1/(4*abs(r))", "1/(4*r)", "jacobi"), ROW, "descends"),
    ("the mean in place of the median", mean, LINE, "descends"),
    ("weights that are never computed anew", stale, LINE, "descends"),
    ("squared distances in the weights of a median", median("1/r**2"), LINE, "descends"),
    ("Cauchy's weight for Huber's loss", location(HUBER, "1/(1 + (r/c)**2)", c=1), COLUMN, "descends"),
    ("another width", location(HUBER, "1 if abs(r) <= 3*c else 3*c/abs(r)", c=1), COLUMN, "descends"),
    ("a width squared", location(CAUCHY, "1/(1 + r**2/c)", c=3), COLUMN, "descends"),
    ("a width with a unit", location(HUBER, "1 if abs(r) <= c**2 else c**2/abs(r)", c=2), COLUMN, "units"),
    ("an absolute floor", median("1/(2*max(r, 0.01))", stop=None), LINE, "units"),
    ("an absolute stop", absolute_stop, LINE, "units"),
    ("an absolute smoothing", lasso("1/(2*sqrt(r**2 + 1/10000))"), ROW, "units"),
    ("no rule at a residual of 0", median(at_zero="undefined"), LINE, "defined"),
    ("a median that rests at the data", median(), LINE, "starts"),
    ("a median that meets the data", median(), LINE, "zeros"),
    ("a lasso that rests at 0", lasso(), ROW, "starts"),
    ("deviations that rest at the data, with a column of zeros", deviations([1, 0]), LINE, "starts"),
    ("deviations that rest at the data, with equal columns", deviations([1, 1]), LINE, "starts"),
    ("the limit of a wrong factor", lasso("1/abs(r)"), ROW, "limit"),
)


@pytest.mark.parametrize(("name", "build", "data", "question"), PLANTED, ids=[each[0] for each in PLANTED])
def test_a_planted_fault_is_named(name: str, build: Build, data: Mapping[str, Any], question: str) -> None:
    answer = judge_loop(build, examples=100, questions=(question,), **data)[question]
    assert answer.accuses, answer
    assert answer.instance


SOUND: tuple[tuple[str, Build, Mapping[str, Any]], ...] = (
    ("Weiszfeld's weights, with either factor", median("1/r"), LINE),
    ("half of them", median("1/(4*r)"), LINE),
    ("Vardi and Zhang", median(at_zero="leave"), LINE),
    ("a lasso", lasso(), ROW),
    ("a group", group(), ROW),
    ("groups of one entry", group(of_each=True), ROW),
    ("the corrected loop", views(), ROW),
    ("the corrected loop, both from the last iterate", views(order="jacobi"), ROW),
    ("Huber", location(HUBER, "1 if abs(r) <= c else c/abs(r)", c=1), COLUMN),
    ("Cauchy", location(CAUCHY, "1/(1 + (r/c)**2)", c=1), COLUMN),
    ("Charbonnier", location("c**2*(sqrt(1 + (r/c)**2) - 1)", "1/sqrt(1 + (r/c)**2)", c=1), COLUMN),
    ("Welsch", location("c**2/2*(1 - exp(-(r/c)**2))", "exp(-(r/c)**2)", c=2), COLUMN),
    ("Geman and McClure", location("r**2/2/(1 + (r/c)**2)", "1/(1 + (r/c)**2)**2", c=2), COLUMN),
    ("a smoothing with the unit of r squared", smoothed_median, LINE),
    ("smoothed absolute values", location("abs(r)", "1/(2*sqrt(r**2 + e**2))", "r**2", e="1/100"), COLUMN),
)


@pytest.mark.parametrize(("name", "build", "data"), SOUND, ids=[each[0] for each in SOUND])
def test_a_sound_loop_is_not_accused(name: str, build: Build, data: Mapping[str, Any]) -> None:
    """But for what is true of every norm that is not smoothed: it rests at a residual of 0."""
    answers = judge_loop(build, examples=40, questions=("descends", "defined", "units", "limit"), **data)
    assert not answers.faults, answers


def test_the_geometric_median_is_judged_as_its_history_says() -> None:
    found = judge_loop(median(), **LINE)
    assert [found[question].word for question in QUESTIONS] == [
        Word.YES,
        Word.YES,
        Word.UNDECIDED,
        Word.NO,
        Word.NO,
        Word.YES,
        Word.UNDECIDED,
    ]
    assert found.subject == "build"
    repaired = judge_loop(
        median(at_zero="leave"), questions=("starts", "zeros"), name="Vardi and Zhang", **LINE
    )
    assert not repaired.faults
    assert repaired.subject == "Vardi and Zhang"


def test_three_blocks_from_the_last_iterate_rise_and_in_turn_they_do_not() -> None:
    def build(y: int, order: str) -> Loop:
        a, b, c = (variable(name, 1) for name in "abc")
        F = squares(a + b + c - [y]) + norm1(a) + norm1(b) + norm1(c)
        return Loop(F, [["a"], ["b"], ["c"]], order)

    def descends(order: str) -> Answer:
        found = judge_loop(build, questions=("descends",), y=st.integers(1, 9), order=st.just(order))
        return found["descends"]

    assert descends("jacobi").accuses
    assert descends("gauss_seidel").word is Word.YES


def test_a_loop_is_built_or_refused() -> None:
    with pytest.raises(InputError, match="Loop"):
        judge_loop(lambda y: y, y=st.integers())  # type: ignore[arg-type, return-value]
    with pytest.raises(InputError, match="questions"):
        judge_loop(median(), questions=("rises",), **LINE)
