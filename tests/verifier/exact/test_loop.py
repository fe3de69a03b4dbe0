"""Algorithm 1 in exact arithmetic: known runs, the equations of each update, balls that contain."""

import pickle
from fractions import Fraction
from itertools import product
from typing import Any

import numpy as np
import pytest

from convexperc.errors import InputError, ProblemError
from convexperc.problem.problem import Problem
from convexperc.solvers.paper.loop import run
from verification.exact import algorithm as exact_update
from verification.exact.algorithm import ORDERS, SIZES, Update
from verification.exact.balls import UnresolvedError
from verification.exact.formulation import objective
from verification.exact.loop import Rise, image, iterates, rise_confirmed, start, step
from verification.exact.numbers import Enclosure
from verification.exact.optimality import is_optimal, optimum_bounds
from verification.exact.problem import ExactProblem
from verification.exact.reweighting import SingularStepError
from verification.problems.families import EXTREME, FAMILIES, seeded

P = ExactProblem.small
SIGN = P([[1]], [-1], [1], 1, 4, 0)
LIMIT = P([[1]], [1], [1], 1, 1, 0)
LOCKED = P([[1, 0], [1, 1]], [1, 0], [1, 1], 1, 1, 1)
GROUPED = P([[1, 2, 0], [0, 1, -1]], [1, -2, 1], [2, 1], 1, 2, 3)
UPDATES = [Update(name, order, Fraction(name == "smoothed", 3)) for name, order in product(SIZES, ORDERS)]

MOSTLY_SINGULAR = ("lambda3_zero", "lambda1_lambda3_zero", "lambda2_lambda3_zero", "all_lambdas_zero")
"""Families whose loop may have no iteration in any of a few problems."""


def names(update: Update) -> str:
    return f"{update.reading}-{update.order}"


def fractions(*values: Any) -> tuple[Fraction, ...]:
    return tuple(Fraction(v) for v in values)


def equations(problem: ExactProblem, update: Update, before: Any, after: Any) -> list[float]:
    """What the paper's two systems leave over, in floats, written from the box with NumPy."""
    (w0, u0), (w, u) = ([np.array([float(x) for x in part]) for part in point] for point in (before, after))
    X, o = np.array(problem.X, dtype=float), np.array(problem.o, dtype=float)
    l1, l2, l3 = map(float, problem.lambdas)
    sizes = {
        "printed": w0,
        "absolute": np.abs(w0),
        "corrected": np.abs(w0),
        "appendix_half": np.full_like(w0, np.abs(w0).sum()),
        "appendix_full": np.full_like(w0, np.abs(w0).sum()),
        "smoothed": np.sqrt(w0**2 + float(update.eps) ** 2),
    }[update.reading]
    factor = 1.0 if update.reading in ("corrected", "appendix_full", "smoothed") else 0.5
    Du = np.zeros(problem.d)
    for group in problem.groups:
        columns = list(group)
        Du[columns] = 1 / (2 * np.sqrt((u0[columns] ** 2).sum() + float(update.eps) ** 2))
    left = (X @ X.T + l1 * np.eye(problem.n) + factor * l2 * np.diag(1 / (2 * sizes))) @ w
    seen = w if update.order == "gauss_seidel" else w0
    other = (l1 * X.T @ X + factor * l3 * np.diag(Du)) @ u
    return [*(left - X @ (o + l1 * u0)), *(other - l1 * X.T @ seen)]


def test_a_known_run_is_exact() -> None:
    course = iterates(SIGN, Update("printed", "gauss_seidel"), None, 3)
    assert [at.w[0] for at in course] == [Enclosure(Fraction(v), Fraction(v)) for v in (-1, -2, -2, -2)]
    assert [at.F.lower for at in course] == [4, 9, 9, 9], course
    assert all(at.F.width == 0 for at in course), course


def test_the_rise_of_the_absolute_reading_is_known() -> None:
    rising = P([[1, -3], [-1, 2]], [1, -4], [1, 1], 2, 2, 2)
    assert start(rising) == (fractions(2, 1), fractions(-7, -3))
    course = iterates(rising, Update("absolute", "gauss_seidel"), None, 8)
    change = [course[i + 1].F.lower - course[i].F.upper for i in range(8)]
    assert [i + 1 for i, rise in enumerate(change) if rise > 0] == [7, 8], [float(x) for x in change]
    assert float(change[6]) == pytest.approx(0.0034338235412328, rel=1e-12), float(change[6])


@pytest.mark.parametrize("update", UPDATES, ids=names)
@pytest.mark.parametrize("problem", [LIMIT, GROUPED], ids=["scalar", "grouped"])
def test_each_update_solves_its_equations(problem: ExactProblem, update: Update) -> None:
    w, u = (fractions(*(range(2, 2 + size))) for size in (problem.n, problem.d))
    new_w, new_u = step(problem, update, w, u)
    after = [x.lower for x in new_w], [x.lower for x in new_u]
    left = equations(problem, update, (w, u), after)
    np.testing.assert_allclose(left, 0.0, atol=1e-12)
    assert all(x.width < Fraction(1, 10**60) for x in (*new_w, *new_u)), (new_w, new_u)


@pytest.mark.parametrize("update", UPDATES, ids=names)
def test_a_planted_factor_is_seen(update: Update, monkeypatch: pytest.MonkeyPatch) -> None:
    stands, factor = SIZES[update.reading]
    wrong = Fraction(3, 2) - factor
    monkeypatch.setitem(exact_update.SIZES, update.reading, (stands, wrong))
    w, u = fractions(2, 3), fractions(2, 3, 4)
    new = step(GROUPED, update, w, u)
    after = [[x.lower for x in part] for part in new]
    assert np.abs(equations(GROUPED, update, (w, u), after)).max() > 1e-2, update


@pytest.mark.parametrize("family", [name for name in FAMILIES if name not in EXTREME])
def test_the_loop_of_the_library_agrees(family: str) -> None:
    compared = 0
    for index in range(4):
        problem = seeded(family, 5, index, largest=(3, 6))
        for name, order in product(SIZES, ORDERS):
            trace = run(problem, variant=name, order=order, max_iterations=1, keep_iterates=True)
            if trace.iterations < 1:
                continue
            update = Update(
                name, order, Fraction(trace.variant.eps or 0) if name == "smoothed" else Fraction(0)
            )
            found = rise_confirmed(problem, update, trace.path_w[0], trace.path_u[0])
            assert found.after is not None, (family, index, name)
            allowed = 1e-5 * max(trace.scale, trace.F[1])
            assert abs(float(found.after.lower) - trace.F[1]) <= allowed, (
                family,
                index,
                name,
                order,
                trace.F,
            )
            compared += 1
    assert compared > 0 or family in MOSTLY_SINGULAR, family


def test_the_start_is_of_least_norm_at_any_rank() -> None:
    for X in ([[1, 2, 3], [2, 4, 6]], [[1, 0], [0, 1], [1, 1]], [[0, 0], [0, 3]], [[0]]):
        o = list(range(1, len(X[0]) + 1))
        w, u = start(P(X, o, [len(o)], 1, 1, 1))
        A = np.array(X, dtype=float)
        np.testing.assert_allclose([float(x) for x in w], np.linalg.pinv(A).T @ o, atol=1e-12)
        np.testing.assert_allclose(
            [float(x) for x in u], np.linalg.pinv(A) @ [float(x) for x in w], atol=1e-12
        )


def test_an_exact_zero_is_held() -> None:
    for order in ORDERS:
        course = iterates(LOCKED, Update("corrected", order), None, 6)
        assert len(course) == 7, course
        assert all(at.w[1] == Enclosure(Fraction(0), Fraction(0)) for at in course), course
    free = P([[1, 0], [1, 1]], [1, 0], [1, 1], 1, 0, 1)
    (first, second), _ = step(free, Update("corrected", "jacobi"), fractions(1, 0), fractions(0, 0))
    assert (first.lower, second.lower) == fractions("2/5", "1/5"), (first, second)


def test_a_singular_matrix_is_proved_by_its_rank() -> None:
    with pytest.raises(SingularStepError, match="rank 0") as caught:
        step(P([[1]], [-2], [1], 1, 16, 0), Update("printed", "gauss_seidel"), fractions(-2), fractions(-2))
    again = pickle.loads(pickle.dumps(caught.value))
    assert (again.system, again.order, again.rank) == ("w", 1, 0), again
    wide = P([[1, 1]], [1, 1], [2], 1, 1, 0)
    with pytest.raises(SingularStepError, match="update of u") as second:
        step(wide, Update("corrected", "jacobi"), *start(wide))
    assert (second.value.order, second.value.rank) == (2, 1), second.value
    assert len(iterates(wide, Update("corrected", "jacobi"), None, 5)) == 1
    assert rise_confirmed(wide, Update("corrected", "jacobi"), *start(wide)).after is None


def test_long_fractions_become_balls_that_contain_the_number() -> None:
    update = Update("corrected", "gauss_seidel")
    course = iterates(LIMIT, update, None, 14)
    w = u = Fraction(1)
    for at in course[1:]:
        w = (1 + u) / (2 + 1 / (2 * w))
        u = w
        assert at.w[0].lower <= w <= at.w[0].upper, at
        assert at.F.lower <= (w - 1) ** 2 + w <= at.F.upper, at
    assert course[-1].w[0].width > 0, "the last iterates must have come out as balls"


def test_a_rise_is_confirmed_only_beyond_doubt() -> None:
    half = np.array([0.5])
    risen = rise_confirmed(LIMIT, Update("absolute", "gauss_seidel"), half, half)
    assert risen == Rise(True, Enclosure(Fraction(3, 4), Fraction(3, 4)), risen.after), risen
    assert risen.after is not None
    assert abs(risen.after.lower - Fraction(19, 25)) < Fraction(1, 10**60), risen
    assert not rise_confirmed(LIMIT, Update("absolute", "jacobi"), half, half, least=Fraction(1, 2)).confirmed
    fixed = fractions("3/4")
    assert not rise_confirmed(LIMIT, Update("absolute", "gauss_seidel"), fixed, fixed).confirmed
    for index in range(10):
        problem = seeded("random", 1, index, largest=(4, 8))
        w, u = np.ones(problem.n), np.linspace(1, 2, problem.d)
        for order in ORDERS:
            assert not rise_confirmed(problem, Update("corrected", order), w, u).confirmed, (index, order)


def test_a_fixed_point_is_no_rise() -> None:
    one = P([[1, 0], [0, 1]], [1, 1], [2], 0, 0, 1)
    held = rise_confirmed(one, Update("corrected", "jacobi"), fractions(1, 1), fractions(0, 0))
    assert held == Rise(False, Enclosure(Fraction(0), Fraction(0)), Enclosure(Fraction(0), Fraction(0))), held
    tangled = P([[1, 0], [0, 1]], [2, 2], [2], 1, 0, 1)
    course = iterates(tangled, Update("corrected", "gauss_seidel"), None, 60)
    w_, u_ = ([float(x.lower) for x in part] for part in (course[-1].w, course[-1].u))
    assert not rise_confirmed(tangled, Update("corrected", "gauss_seidel"), w_, u_).confirmed, (w_, u_)


def test_the_image_of_a_box_holds_the_image_of_its_points() -> None:
    for update in UPDATES:
        centre = [fractions(2, 3), fractions(2, 3, 4)]
        box = [[Enclosure(x - Fraction(1, 50), x + Fraction(1, 50)) for x in part] for part in centre]
        *boxes, F = image(GROUPED, update, *box)
        for signs in product((-1, 0, 1), repeat=2):
            point = [
                tuple(x + Fraction(sign, 50) for x in part) for sign, part in zip(signs, centre, strict=True)
            ]
            at = objective(GROUPED, *point)
            assert F.lower <= at.lower, (update, F)
            assert at.upper <= F.upper, (update, F)
            for inner, outer in zip(step(GROUPED, update, *point), boxes, strict=True):
                assert all(
                    b.lower <= a.lower <= a.upper <= b.upper for a, b in zip(inner, outer, strict=True)
                )


def test_a_box_across_zero_is_not_resolved() -> None:
    box = [Enclosure(Fraction(-1), Fraction(1))]
    with pytest.raises(UnresolvedError, match="exclude 0"):
        image(LIMIT, Update("absolute", "jacobi"), box, box)


def test_the_optimum_of_fractions_is_scaled_from_whole_numbers() -> None:
    third = P([[1]], ["1/3"], [1], 1, "1/3", 0)
    bounds = optimum_bounds(third)
    assert bounds.lower <= Fraction(1, 12) <= bounds.upper, bounds
    assert bounds.width < Fraction(1, 10**20), bounds
    scaled = P([["1/3", "2/7"]], ["1/5", 1], [1, 1], "1/11", "1/13", "3/7")
    near = Problem(
        [[1 / 3, 2 / 7]], [0.2, 1], lambda1=1 / 11, lambda2=1 / 13, lambda3=3 / 7, modalities=[1, 1]
    )
    assert float(optimum_bounds(scaled).lower) == pytest.approx(
        float(optimum_bounds(ExactProblem.of(near)).lower)
    )
    with pytest.raises(ProblemError, match="fit into float64"):
        optimum_bounds(P([[Fraction(1, 3**40)]], [1], [1], Fraction(1, 7**30), 1, 1))


def test_optimality_is_decided_exactly() -> None:
    assert is_optimal(LIMIT, fractions("1/2"), fractions("1/2"))
    assert not is_optimal(LIMIT, fractions("3/4"), fractions("3/4"))
    assert is_optimal(LOCKED, fractions("1/4", 0), fractions(0, 0), held=[1])
    assert not is_optimal(LOCKED, fractions("1/4", 0), fractions(0, 0))
    assert not is_optimal(LOCKED, fractions("1/5", "1/10"), fractions(0, 0), held=[1])
    assert not is_optimal(LIMIT, fractions("1/2"), fractions("-1/2"))
    grouped = P([[3, 4]], [3, 4], [2], 1, 0, 1)
    assert is_optimal(grouped, fractions("249/250"), fractions("336/3125", "448/3125"))
    assert not is_optimal(grouped, fractions("249/250"), fractions("448/3125", "336/3125"))


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("exact", "jacobi"), "reading must be one of printed, absolute"),
        (("printed", "chaotic"), "order must be one of gauss_seidel, jacobi"),
        (("smoothed", "jacobi"), "eps must be > 0 in the smoothed"),
        (("printed", "jacobi", Fraction(1)), "eps must be > 0 in the smoothed"),
    ],
)
def test_bad_updates_are_named(arguments: Any, words: str) -> None:
    with pytest.raises(InputError, match=words):
        Update(*arguments)
