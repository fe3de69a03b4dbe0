"""Exact updates of reweighted loops, against values that are known, and against the library's own loop."""

from fractions import Fraction

import numpy as np
import pytest
from flint import arb, fmpq

from convexperc.errors import InputError
from convexperc.problem.problem import Problem
from verification.exact.algorithm import Update
from verification.exact.balls import precision
from verification.exact.loop import step as paper_step
from verification.exact.reweighting import UndefinedUpdateError
from verification.reweighted import Loop, each_loss, loss, norm, norm1, squares, variable
from verification.reweighted.gallery import recognition
from verification.reweighted.loops.loop import float_run, in_unit, unbounded_at_zero
from verification.reweighted.loops.meeting import meetings
from verification.reweighted.objectives.objective import Objective, rational_point


def distances(points: list[int], **options: str) -> Loop:
    x = variable("x", 1)
    return Loop(sum((norm(x - [p]) for p in points), Objective(())), **options)


def at(loop: Loop, x: Fraction | int) -> Fraction:
    found = loop.step(rational_point({"x": [x]}))["x"][0]
    return Fraction(int(found.p), int(found.q))


def test_the_failure_of_chandrasekaran_and_tamir() -> None:
    loop = distances([0, 0, 0, 1, 2])
    assert at(loop, Fraction(3, 2)) == 1  # T(3/2) = (1/(1/2) + 2/(1/2)) / (3/(3/2) + 1/(1/2) + 1/(1/2)) = 6/6
    assert at(loop, 1) == 1
    assert [loop.objective.at(rational_point({"x": [x]})) for x in (1, 0)] == [4, 3]
    met = [each for each in meetings(loop) if each.zero == 1]
    assert [(each.lower, each.upper) for each in met] == [(Fraction(3, 2), Fraction(3, 2))]


def test_vardi_and_zhang_leave_a_point_that_is_no_median_and_rest_at_one() -> None:
    loop = distances([0, 0, 0, 1, 2], at_zero="leave")
    # T = (2/1)/(3/1 + 1/1) = 1/2, R = -3 + 1 = -2, eta = 1: x+ = 1 + (1 - 1/2)(1/2 - 1)
    assert at(loop, 1) == Fraction(3, 4)
    assert at(loop, 0) == 0


def test_the_rule_of_vardi_and_zhang_is_refused_where_it_is_not_theirs() -> None:
    x = variable("x", 2)
    loop = Loop(norm(np.array([[1, 0], [1, 1]]) @ x) + norm(x - [1, 1]), at_zero="leave")
    with pytest.raises(InputError, match="leave"):
        loop.step(rational_point({"x": [0, 0]}))


def test_vardi_and_zhang_have_factors_of_the_residual_and_other_blocks_beside_it() -> None:
    x, u = variable("x", 1), variable("u", 2)
    zero = rational_point({"x": [0]})
    # The rest has 1/2 of (x - 4)^2 and of (x - 6)^2 with a force of 5; the norm that is 0 pulls with 1.
    factors = Loop(norm(x) + norm(-2 * (x - [4])) + norm(3 * (x - [6])), at_zero="leave")
    assert factors.step(zero)["x"] == [4]
    assert Loop(norm(3 * x) + norm(x - [4]) + norm(x - [6]), at_zero="leave").step(zero)["x"] == [0]
    absent = Loop(norm(x) + 7 * norm(0 * x) + 3 * norm(x - [4]), at_zero="leave")
    assert absent.step(zero)["x"] == [fmpq(8, 3)]
    beside = Loop(
        norm(x) + 3 * norm(x - [4]) + squares(np.array([[1, 2]]) @ u - [1]), [["x"], ["u"]], at_zero="leave"
    )
    moved = beside.step(rational_point({"x": [0], "u": [0, 0]}))
    assert (moved["x"], moved["u"]) == ([fmpq(8, 3)], [1, 0])


@pytest.mark.parametrize("several", [True, False])
def test_vardi_and_zhang_are_refused_two_variables_at_once_and_other_losses(several: bool) -> None:
    x, y = variable("x", 1), variable("y", 1)
    other = norm(y - [5]) if several else loss(x, "3*r", "3/(2*r)")
    loop = Loop(norm(x) + norm(x - [4]) + other, at_zero="leave")
    with pytest.raises(InputError, match="leave"):
        loop.step(rational_point({name: [0] for name in loop.objective.sizes}))


def test_what_the_data_leave_free_stays_as_it_is() -> None:
    """In exact numbers as in float64."""
    b = variable("b", 2)
    loop = Loop(norm1(np.array([[1, 0]] * 3) @ b - [1, 2, 7]))
    moved = loop.step(rational_point({"b": [3, 5]}))["b"]
    assert moved[1] == 5
    found = float_run(loop, {"b": np.array([3.0, 5.0])}, 1, 0.0).points[-1]["b"]
    np.testing.assert_allclose(found, [float(x.p) / float(x.q) for x in moved], rtol=1e-12)


def test_an_update_without_a_rule_at_zero_does_not_exist() -> None:
    with pytest.raises(UndefinedUpdateError, match="residual of 0"):
        at(distances([0, 1], at_zero="undefined"), 0)


@pytest.mark.parametrize(
    ("build", "reading", "order"),
    [
        (recognition.printed, "printed", "gauss_seidel"),
        (recognition.corrected, "corrected", "gauss_seidel"),
        (recognition.corrected_jacobi, "corrected", "jacobi"),
    ],
)
def test_the_papers_loop_makes_the_steps_of_the_verifiers_own(
    build: object, reading: str, order: str
) -> None:
    random = np.random.default_rng(0)
    for _ in range(10):
        n, d = random.integers(1, 4, 2)
        X, o = random.integers(-3, 4, (n, d)), random.integers(-3, 4, d)
        w, u = random.integers(1, 4, n) * random.choice([-1, 1], n), random.integers(1, 4, d)
        data = {"X": X.tolist(), "o": o.tolist(), "lambda1": 2, "lambda2": 1, "lambda3": 3}
        lambdas = {"lambda1": 2, "lambda2": 1, "lambda3": 3}
        problem = Problem(X.astype(float), o.astype(float), modalities=[int(d)], **lambdas)
        with precision(256):
            mine = build(**data).step(rational_point({"w": w.tolist(), "u": u.tolist()}))  # type: ignore[operator]
        theirs = paper_step(problem, Update(reading, order), w.astype(float), u.astype(float))
        pairs = zip([*mine["w"], *mine["u"]], [*theirs[0], *theirs[1]], strict=True)
        with precision(256):
            for value, enclosure in pairs:
                low, high = (
                    fmpq(end.numerator, end.denominator) for end in (enclosure.lower, enclosure.upper)
                )
                assert bool(arb(value) > arb(low) - arb(2) ** -200)
                assert bool(arb(value) < arb(high) + arb(2) ** -200)


def test_an_entry_at_zero_is_held_and_the_others_move() -> None:
    x = variable("x", 2)
    loop = Loop(squares(x - [3, 3]) + norm1(x))
    moved = loop.step(rational_point({"x": [0, 1]}))["x"]
    assert moved == [0, 2]  # (1 + 1/2) x = 3


def test_float64_makes_the_exact_steps() -> None:
    x = variable("x", 2)
    A, y = np.array([[1, 2], [3, -1], [0, 1]]), np.array([1, 2, 5])
    rho, weight = "c**2/2*log(1 + (r/c)**2)", "1/(1 + (r/c)**2)"
    loop = Loop(each_loss(A @ x - y, rho, weight, square="r**2/2", widths={"c": 2}))
    run = float_run(loop, {"x": np.array([1.0, -2.0])}, 5, 0.0)
    with precision(256):
        point = rational_point({"x": [1, -2]})
        for _ in range(5):
            point = loop.step(point)
    np.testing.assert_allclose(
        run.points[-1]["x"], [float(arb(value).mid()) for value in point["x"]], rtol=1e-12
    )


def test_another_unit_makes_the_same_loop() -> None:
    x = variable("x", 1)
    rho, weight = "r**2/2 if r <= c else c*r - c**2/2", "1 if r <= c else c/r"
    huber = loss(x - [3], rho, weight, square="r**2/2", widths={"c": 1})
    slope = {"signed": True, "widths": {"q": Fraction(1, 4)}}
    quantile = loss(x - [2], "q*r if r >= 0 else (q - 1)*r", "q/(2*r) if r >= 0 else (q - 1)/(2*r)", **slope)
    loop = Loop(squares(x - [1]) + 2 * norm(x) + huber + quantile)
    unit = Fraction(1, 1024)
    moved = in_unit(loop, unit)
    assert moved is not None
    for start in (Fraction(5), Fraction(7, 2), Fraction(-1)):
        assert at(moved, start * unit) == at(loop, start) * unit
        here, there = rational_point({"x": [start]}), rational_point({"x": [start * unit]})
        assert loop.objective.at(here) == moved.objective.at(there)


def test_a_width_has_the_unit_that_its_weight_needs() -> None:
    """The loss r alone goes with any unit of the width."""
    x = variable("x", 1)
    smooth = loss(x - [3], "r", "1/(2*sqrt(r**2 + e))", widths={"e": Fraction(1, 100)})
    moved = in_unit(Loop(smooth), Fraction(1, 8))
    assert moved is not None
    (term,) = moved.objective.terms
    assert term.widths["e"] == Fraction(1, 6400)
    rooted = loss(x, "c**4/2*log(1 + (r/c**2)**2)", "1/(1 + (r/c**2)**2)", square="r**2/2", widths={"c": 3})
    assert in_unit(Loop(rooted), Fraction(1, 1000)) is None
    moved = in_unit(Loop(rooted), Fraction(1, 4))
    assert moved is not None
    assert moved.objective.terms[0].widths["c"] == Fraction(3, 2)


def test_a_loss_with_a_unit_of_its_own_has_no_other_unit() -> None:
    x = variable("x", 1)
    assert in_unit(Loop(loss(x, "log(1 + r**2)", "1/(1 + r**2)")), Fraction(1, 2)) is None


def test_zeros_count_only_where_the_weight_grows_without_bound() -> None:
    x = variable("x", 1)
    point = rational_point({"x": [0]})
    assert unbounded_at_zero(norm(x), point)
    assert not unbounded_at_zero(0 * norm(x), point)
    assert not unbounded_at_zero(norm(x, "1/(2*sqrt(r**2 + 1))"), point)
    assert not unbounded_at_zero(norm(x - [1]), point)


def test_affine_expressions_are_those_of_numpy() -> None:
    random = np.random.default_rng(1)
    W, A, B = (random.integers(-4, 5, shape) for shape in ((3, 2), (4, 3), (2, 5)))
    V = variable("V", 3, 2)
    point = rational_point({"V": W.ravel().tolist()})
    for expression, expected in (
        (A @ V @ B, A @ W @ B),
        (V.T @ np.ones((3, 1), dtype=int) - np.array([[1], [2]]), W.T @ np.ones((3, 1)) - [[1], [2]]),
        (2 * V[1:, 0] - V[:2, 1], 2 * W[1:, 0] - W[:2, 1]),
        (1 - V[0], 1 - W[0]),
        (A[0] @ V, A[0] @ W),
    ):
        assert [int(value.p) for value in expression.at(point)] == np.ravel(expected).astype(int).tolist()


@pytest.mark.parametrize(
    ("wrong", "what"),
    [
        (lambda: variable("x", 2) + np.array([1, 2, 3]), "shape"),
        (lambda: variable("not a name", 2), "name"),
        (lambda: np.ones((2, 3)) @ variable("x", 2), "fit"),
        (lambda: -1 * norm(variable("x", 2)), ">= 0"),
        (lambda: norm(variable("x", 1)) * float("nan"), "finite"),
        (lambda: Loop(norm(variable("x", 1)), blocks=[["y"]]), "blocks"),
        (lambda: Loop(norm(variable("x", 1)), order="cyclic"), "order"),
        (lambda: norm(variable("x", 1), "1/s"), "no names but"),
        (lambda: norm(variable("x", 1), "__import__('os')"), "must not hold"),
    ],
)
def test_misuse_is_told(wrong: object, what: str) -> None:
    with pytest.raises(InputError, match=what):
        wrong()  # type: ignore[operator]
