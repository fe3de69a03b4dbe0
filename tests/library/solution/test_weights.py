"""Intervals of the optimal weights: closed forms, long arithmetic, planted faults, and what has no answer."""

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction

import flint
import numpy as np
import pytest

import convexperc.solution.weights as module
from convexperc.certificate.certificate import certify
from convexperc.enclosure import convexity as curvature
from convexperc.enclosure.enclosure import enclose
from convexperc.errors import PointError
from convexperc.problem.problem import Problem
from convexperc.solution.single import solve
from convexperc.solution.solution import Solution, Timings
from convexperc.solution.weights import Intervals, WeightIntervals, weight_intervals
from verification.bench.instances import LAMBDAS, Instance, Shape
from verification.problems.families import seeded


def given(problem: Problem, w, u, dual=None) -> Solution:
    """Any point as if a solver had answered it."""
    w, u = np.array(w, dtype=float), np.array(u, dtype=float)
    return Solution(problem, w, u, certify(problem, w, u, dual=dual), "given", "", 0, Timings(0.0, 0.0, 0.0))


def separable(x: float, o: float, lambdas: tuple[float, float, float]) -> tuple[Fraction, Fraction]:
    """The optimum of (x w - o)^2 + lambda1 (x u - w)^2 + lambda2 |w| + lambda3 |u| for x, o > 0."""
    x, o, one, two, three = (Fraction(v) for v in (x, o, *lambdas))
    if one:
        w = (o - (two + three / x) / (2 * x)) / x
        u = (w - three / (2 * one * x)) / x
        if w >= 0 and u >= 0:
            return w, u
    return max(Fraction(0), (x * o - two / 2) / (x * x + one)), Fraction(0)


ROWS = (0.5, 1.0, 4.0)
TARGETS = (3.0, 2.0, 0.75)


def diagonal(lambdas: tuple[float, float, float]) -> tuple[Problem, list[Fraction], list[Fraction]]:
    """Three problems of one view and one modality each, in one, with the optimal w and |u|."""
    names = dict(zip(("lambda1", "lambda2", "lambda3"), lambdas, strict=True))
    problem = Problem(np.diag(ROWS), TARGETS, modalities=[1, 1, 1], **names)
    pairs = [separable(x, o, lambdas) for x, o in zip(ROWS, TARGETS, strict=True)]
    return problem, [w for w, _ in pairs], [u for _, u in pairs]


def twins() -> tuple[Problem, list[Fraction], list[Fraction]]:
    """Two robots that see the same: w* = (7/8, 7/8), u* = 3/4 (by symmetry and convexity)."""
    problem = Problem([[1.0], [1.0]], [2.0], lambda1=1, lambda2=0.25, lambda3=0.5)
    return problem, [Fraction(7, 8)] * 2, [Fraction(3, 4)]


def missed(intervals: Intervals, exact: list[Fraction]) -> list[int]:
    """The weights outside their intervals."""
    bounds = zip(intervals.lower, exact, intervals.upper, strict=True)
    return [k for k, (low, value, high) in enumerate(bounds) if not (low <= value <= high)]


def cases() -> Iterator[tuple[Solution, list[Fraction], list[Fraction]]]:
    """Points beside a known optimum, judged by the optimal dual, so that sqrt(gap) is their distance."""
    for lambdas in [(1.0, 0.5, 0.25), (0.0, 0.5, 0.25), (0.0, 0.0, 1.0), (4.0, 0.25, 8.0)]:
        problem, w, u = diagonal(lambdas)
        base_w, base_u = np.array([float(v) for v in w]), np.array([float(v) for v in u])
        dual = 2 * (problem.X.T @ base_w - problem.o), 2 * lambdas[0] * (problem.X @ base_u - base_w)
        for j in range(3):
            for step in (2.0**-10, -(2.0**-10)):
                move = step * np.eye(3)[j]
                along = move / problem.X[j, j] if lambdas[0] and base_u[j] else 0 * move
                yield given(problem, base_w + move, base_u + along, dual), w, u
                yield given(problem, base_w, base_u + along, dual), w, u
    problem, w, u = twins()
    for step in (2.0**-10, -(2.0**-10)):
        yield given(problem, [0.875 + step, 0.875 - step], [0.75], ([-0.5], [-0.25, -0.25])), w, u


@pytest.fixture(scope="module")
def known() -> list[tuple[Solution, list[Fraction], list[Fraction]]]:
    return list(cases())


def all_missed(known) -> Iterator[WeightIntervals]:
    """The intervals outside of which a weight lies."""
    for solution, w, u in known:
        found = weight_intervals(solution)
        assert found.gap <= 2.0**-14, found.gap
        if missed(found.views, w) or missed(found.modalities, u):
            yield found


def test_every_point_beside_a_known_optimum_encloses_it(known):
    assert list(all_missed(known)) == []


def scaled_reach(change):
    return lambda patch: patch.setattr(module._Point, "reach", property(lambda point: change(point.gap)))


def squared_inverse(patch):
    honest = curvature._inverse

    def squared(A, budget):
        found = honest(A, budget)
        return None if found is None else found * found

    patch.setattr(curvature, "_inverse", squared)


def stiffer_null_space(patch):
    honest = curvature.null_projection
    patch.setattr(curvature, "null_projection", lambda *given: 4 * honest(*given))


def zeros_without_radius(patch):
    honest = module._proved_zeros
    patch.setattr(
        module, "_proved_zeros",
        lambda frame, point, solution: honest(frame, replace(point, gap=flint.arb(0)), solution),
    )  # fmt: skip


def exact_dual(patch):
    honest = module._multipliers
    patch.setattr(module, "_multipliers", lambda frame, K, w, q: honest(frame, K, w, [v.mid() for v in q]))


def no_radius(patch):
    patch.setattr(module, "_within", lambda radius: flint.arb(0))


@pytest.mark.parametrize(
    "plant",
    [
        scaled_reach(lambda gap: gap.sqrt() / 2),
        scaled_reach(lambda gap: gap),
        scaled_reach(lambda gap: 0 * gap),
        squared_inverse,
        stiffer_null_space,
        zeros_without_radius,
        exact_dual,
        no_radius,
    ],
    ids=["half", "no root", "nothing", "inverse", "null space", "zeros", "dual", "no radius"],
)
def test_a_planted_fault_is_seen(known, monkeypatch, plant):
    plant(monkeypatch)
    assert any(True for _ in all_missed(known))


@pytest.mark.parametrize("lambdas", [(1.0, 0.5, 0.25), (0.0, 0.5, 0.25), (4.0, 0.25, 8.0), (2.0, 40.0, 1.0)])
def test_the_enclosure_gives_closed_forms_to_the_last_digits(lambdas):
    problem, w, u = diagonal(lambdas)
    found = weight_intervals(solve(problem), enclose(problem))
    assert not missed(found.views, w), found
    assert not missed(found.modalities, u), found
    assert found.views.determined.all(), found
    assert found.modalities.determined.all(), found
    for part, exact in ((found.views, w), (found.modalities, u)):
        width = part.upper - part.lower
        assert (width <= 4e-16 * np.array([max(1.0, float(v)) for v in exact])).all(), part
        assert [bool(x) for x in (width == 0)] >= [v == 0 for v in exact], part


@pytest.mark.parametrize("o", [2.0**-200, 1.0, 2.0**200])
def test_the_one_dimensional_case(o):
    problem = Problem([[1.0]], [o], lambda1=1, lambda2=o / 2, lambda3=o / 4)
    solution = solve(problem)
    for enclosure in (None, enclose(problem)):
        found = weight_intervals(solution, enclosure)
        assert not missed(found.views, [Fraction(5, 8) * Fraction(o)]), found
        assert not missed(found.modalities, [Fraction(1, 2) * Fraction(o)]), found
        assert found.views.upper[0] - found.views.lower[0] <= 1e-6 * o, found


@pytest.mark.parametrize("lambdas", LAMBDAS)
def test_a_float_answer_and_long_arithmetic_agree_on_a_frame(lambdas):
    problem = Instance.of(Shape("like S", 6, (76, 176, 26), 1, 71)).problem(0, lambdas)
    solution = solve(problem)
    fine = weight_intervals(solution, enclose(problem))
    check_agreement(weight_intervals(solution), fine)
    for part in (fine.views, fine.modalities):
        assert part.determined.all(), part
        assert (part.upper - part.lower <= 1e-15).all(), part


@pytest.mark.parametrize(
    "family", ["random", "duplicate_rows", "lambda1_zero", "lambda2_zero", "scaled_data"]
)
@pytest.mark.parametrize("index", range(6))
def test_a_float_answer_and_long_arithmetic_agree(family, index):
    problem = seeded(family, 21, index)
    solution, long = solve(problem), enclose(problem, bits=256)
    fine = weight_intervals(solution, long)
    check_agreement(weight_intervals(solution), fine)
    exact = [Fraction(v) for v in long.exact.w]
    for j in np.flatnonzero(fine.views.determined):
        width = fine.views.upper[j] - fine.views.lower[j]
        assert Fraction(fine.views.lower[j]) - Fraction(width) <= exact[j], (j, fine)
        assert exact[j] <= Fraction(fine.views.upper[j]) + Fraction(width), (j, fine)


def check_agreement(coarse: WeightIntervals, fine: WeightIntervals) -> None:
    """Two intervals of one number overlap, and zeros stay zeros."""
    for one, other in ((coarse.views, fine.views), (coarse.modalities, fine.modalities)):
        assert (one.lower <= other.upper).all(), (one, other)
        assert (other.lower <= one.upper).all(), (one, other)
        assert (one.lower <= one.upper).all(), one
        known = one.determined
        assert np.isfinite(one.upper[known]).all(), one
        assert np.isinf(one.upper[~known]).all(), one
        assert bool(one.reason) != bool(known.all()), one


def test_equal_rows_without_coupling_leave_only_their_own_weights_open():
    X = [[1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 2.0, 1.0]]
    problem = Problem(X, [2.0, 1.0, 3.0], lambda1=0, lambda2=0.5, lambda3=1)
    for enclosure in (None, enclose(problem)):
        found = weight_intervals(solve(problem), enclosure)
        assert found.views.determined.tolist() == [False, False, True], found
        assert "dependent" in found.views.reason, found
        assert found.modalities.determined.all(), found
    # with s = w_1 + w_2 > 0: G (s, w_3) = c - (1/4, 1/4), G = [[2, 1], [1, 5]], c = (5, 5)
    assert not missed(found.views, [Fraction(0), Fraction(0), Fraction(19, 4) / 9]), found


def test_equal_rows_with_coupling_are_determined():
    problem, w, u = twins()
    found = weight_intervals(solve(problem), enclose(problem))
    assert found.views.determined.all(), found
    assert not missed(found.views, w), found
    assert not missed(found.modalities, u), found
    assert (found.views.upper - found.views.lower <= 1e-15).all(), found


def test_equal_modalities_are_not_determined():
    problem = Problem([[1.0, 1.0]], [2.0, 2.0], modalities=[1, 1], lambda1=1, lambda2=0.1, lambda3=0.1)
    found = weight_intervals(solve(problem), enclose(problem))
    assert found.views.determined.all(), found
    assert not found.modalities.determined.any(), found
    assert "independent" in found.modalities.reason, found


@pytest.mark.parametrize("lambda1", [0.0, 1.0])
def test_modality_weights_without_a_price_are_not_determined(lambda1):
    problem = Problem([[1.0, 2.0]], [2.0, 1.0], lambda1=lambda1, lambda2=0.5, lambda3=0)
    found = weight_intervals(solve(problem), enclose(problem))
    assert not found.modalities.determined.any(), found
    assert not missed(found.views, [Fraction(15, 20)]), found
    assert found.views.determined.all(), found


def test_no_finite_gap_proves_nothing():
    problem = Problem(np.eye(2), [1.0, 1.0], lambda1=1, lambda2=0.1, lambda3=0.1)
    found = weight_intervals(given(problem, [np.nan, 1.0], [0.0, 0.0]))
    assert not found.views.determined.any(), found
    assert not found.modalities.determined.any(), found
    assert "gap" in found.views.reason, found


def test_an_enclosure_of_another_shape_is_refused():
    problem, _, _ = twins()
    with pytest.raises(PointError, match="enclosure"):
        weight_intervals(solve(problem), enclose(Problem([[1.0]], [1.0], lambda1=1, lambda2=1, lambda3=1)))
