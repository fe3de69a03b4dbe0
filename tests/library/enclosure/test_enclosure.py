"""Ball arithmetic: its interval against closed forms, exact rationals and the float64 certificate."""

import itertools
from dataclasses import replace
from fractions import Fraction

import flint
import numpy as np
import pytest

from convexperc.certificate.certificate import certify
from convexperc.certificate.rationals import PRIME, exact_optimum
from convexperc.enclosure.active_set import ActiveSetNewton, Start
from convexperc.enclosure.balls import precision
from convexperc.enclosure.central_path import Central
from convexperc.enclosure.enclosure import certify_in_balls, enclose
from convexperc.enclosure.interval import _limited, dual_value, objective_at, primal_value
from convexperc.enclosure.reduced import ReducedBalls
from convexperc.errors import PrecisionError
from convexperc.problem.problem import Problem
from convexperc.problem.scaling import Scaling
from convexperc.solution.single import solve
from convexperc.solution.solution import Status
from convexperc.solution.weights import weight_intervals
from convexperc.solvers.conic import Conic
from convexperc.solvers.interface import SolverResult
from verification.bench.instances import LAMBDAS, Instance, Shape
from verification.exact.referee import optimum
from verification.problems.families import seeded

CLOSED_FORMS = {
    "19/32": (Problem([[1.0]], [1.0], lambda1=1, lambda2=0.5, lambda3=0.25), Fraction(19, 32)),
    "3/4": (Problem([[1.0]], [1.0], lambda1=1, lambda2=1, lambda3=0), Fraction(3, 4)),
    "3/8": (Problem([[1, 0], [3, 1]], [1, 0], lambda1=1, lambda2=1, lambda3=0), Fraction(3, 8)),
    "135/476": (
        Problem([[1, 3], [0, 1]], [1, 3], lambda1=1, lambda2=0, lambda3=1, modalities=[1, 1]),
        Fraction(135, 476),
    ),
    "least squares": (Problem([[1, 0], [1, 0]], [3, 2], lambda1=1, lambda2=0, lambda3=0), Fraction(4)),
    "0 modulo a prime": (
        Problem([[PRIME]], [1], lambda1=1, lambda2=1, lambda3=0),
        Fraction(1, PRIME) - Fraction(1, 4 * PRIME**2),
    ),
    "dependent modulo a prime": (
        Problem([[PRIME, 0], [0, 1]], [0, 3], lambda1=1, lambda2=2, lambda3=0),
        Fraction(5),
    ),
    "o = 0": (Problem([[1, 2]], [0, 0], lambda1=1, lambda2=1, lambda3=1), Fraction(0)),
}


@pytest.mark.parametrize("name", CLOSED_FORMS)
@pytest.mark.parametrize("exponent", [0, -400, 400])
def test_the_interval_holds_the_closed_form(name, exponent):
    base, value = CLOSED_FORMS[name]
    t = 2.0**exponent
    problem = Problem(
        base.X, base.o * t, modalities=base.modalities, lambda1=base.lambda1, lambda2=base.lambda2 * t,
        lambda3=base.lambda3 * t,
    )  # fmt: skip
    found = enclose(problem)
    exact = value * Fraction(2) ** (2 * exponent)
    assert Fraction(found.lower) <= exact <= Fraction(found.upper), (found, float(exact))
    assert found.relative_width <= 1e-12 or found.share_of_target <= 1e-15, found


@pytest.mark.parametrize("lambdas", LAMBDAS)
def test_newton_gives_a_hundred_bits_from_a_float_answer_in_a_few_steps(lambdas):
    shape = Shape("like S", 6, (76, 176, 26), 1, 71)
    problem = Instance.of(shape).problem(0, lambdas)
    found, referee = enclose(problem), optimum(problem)
    assert found.bits == 128, found
    assert found.relative_width <= 1e-30, found
    assert found.steps <= 6, found
    assert found.exact.lower <= referee.value.upper, found
    assert referee.value.lower <= found.exact.upper, found
    assert Fraction(found.lower) <= found.exact.lower <= found.exact.upper <= Fraction(found.upper), found
    coarse, fine = enclose(problem, bits=53), enclose(problem, bits=256)
    assert coarse.bits == 53, coarse
    assert fine.relative_width <= 1e-65, fine
    assert coarse.exact.lower <= fine.exact.lower <= fine.exact.upper <= coarse.exact.upper, (coarse, fine)


def test_fewer_bits_than_a_float_are_refused():
    with pytest.raises(PrecisionError, match="at least 53"):
        enclose(CLOSED_FORMS["19/32"][0], bits=52)


@pytest.mark.parametrize("seed", range(12))
def test_no_start_is_believed(seed):
    rng = np.random.default_rng(seed)
    X, o = rng.normal(size=(4, 9)), rng.normal(size=9)
    problem = Problem(X, o, modalities=[2, 3, 4], lambda1=1, lambda2=0.3, lambda3=0.3)
    truth = enclose(problem, bits=256)
    given = rng.normal(size=4) * 10.0 ** rng.uniform(-9, 9), rng.normal(size=9) * (seed % 3)
    found = enclose(problem, start=given)
    assert found.exact.lower <= truth.exact.lower <= truth.exact.upper <= found.exact.upper, (found, truth)
    assert found.relative_width <= 1e-12, found


@pytest.mark.parametrize("seed", range(12))
def test_newton_mends_a_start_with_wrong_signs_and_zeros(seed):
    rng = np.random.default_rng(seed)
    X, o = rng.normal(size=(5, 12)), rng.normal(size=12)
    problem = Problem(X, o, modalities=[3, 4, 5], lambda1=1, lambda2=0.6, lambda3=0.4)
    answer = enclose(problem)
    w = np.where(answer.w == 0, rng.normal(size=5) * 1e-3, answer.w)
    w[np.argmin(abs(w))] *= 0.0 if seed % 2 else -1.0
    with precision(128):
        scaling = Scaling.of(problem)
        frame = ReducedBalls.of(problem, (scaling.x, scaling.o))
        t = 2.0 * problem.modalities.norms(answer.u) / problem.lambda3
        start = Start(w * 2.0 ** (scaling.x - scaling.o), t * 2.0 ** (4 * scaling.x))
        point = ActiveSetNewton(frame, start).point()
        width = primal_value(frame, point).upper() - dual_value(frame, point).lower()
        assert width <= frame.target * 1e-30, (width, answer.w, w)


@pytest.mark.parametrize("lambdas", list(itertools.product((0.0, 0.7), repeat=3)))
@pytest.mark.parametrize("deficient", [False, True])
def test_no_dual_value_exceeds_a_primal_one(lambdas, deficient):
    rng = np.random.default_rng(5)
    for _ in range(30):
        X = rng.normal(size=(3, 6))
        X[2] = X[0] - 2 * X[1] if deficient else X[2]
        names = dict(zip(("lambda1", "lambda2", "lambda3"), lambdas, strict=True))
        problem = Problem(X, rng.normal(size=6), modalities=[2, 4], **names)
        with precision(128):
            frame = ReducedBalls.of(problem, (0, 0))
            low = max(dual_value(frame, scattered(rng)).lower() for _ in range(10))
            high = min(primal_value(frame, scattered(rng)).upper() for _ in range(10))
            assert low <= high, (low, high)


@pytest.mark.parametrize("lambdas", list(itertools.product((0.0, 0.2), (0.0, 0.7), (0.0, 0.1))))
def test_no_dual_value_beside_the_optimum_exceeds_it(lambdas):
    rng = np.random.default_rng(6)
    names = dict(zip(("lambda1", "lambda2", "lambda3"), lambdas, strict=True))
    for _ in range(8):
        problem = Problem(rng.random((3, 6)), rng.random(6), modalities=[2, 4], **names)
        found = enclose(problem).exact
        with precision(128):
            frame = ReducedBalls.of(problem, (0, 0))
            high = flint.arb(flint.fmpq(found.upper.numerator, found.upper.denominator))
            for factors in itertools.product((0.9, 1.0, 1.1), repeat=2):
                parts = (found.w, found.t, found.q)
                w, t, q = ([flint.arb(float(v)) for v in part] for part in parts)
                w, q = [(v * factors[0]).mid() for v in w], [(v * factors[1]).mid() for v in q]
                low = dual_value(frame, Central(w, t, q, flint.arb(0))).lower()
                assert low <= high, (low, high, factors)


def scattered(rng: np.random.Generator) -> Central:
    """Any point of three views and two modalities."""
    w, q, t = rng.normal(size=3), rng.normal(size=3), rng.random(2)
    return Central(*([flint.arb(float(v)) for v in part] for part in (w, t, q)), flint.arb(0))


@pytest.mark.parametrize("deficient", [False, True])
@pytest.mark.parametrize("lambdas", [(1, 0, 0), (0, 0, 1), (0, 0, 0)])
def test_an_equality_case_too_large_for_exact_rationals_is_still_enclosed(monkeypatch, lambdas, deficient):
    rng = np.random.default_rng(8)
    X = rng.normal(size=(3, 7))
    X[2] = X[0] if deficient else X[2]
    names = dict(zip(("lambda1", "lambda2", "lambda3"), lambdas, strict=True))
    problem = Problem(X, rng.normal(size=7), **names)
    value = exact_optimum(problem)
    monkeypatch.setattr("convexperc.certificate.rationals.WORK_LIMIT", 0)
    assert exact_optimum(problem) is None, problem
    found = enclose(problem)
    assert found.exact.lower <= value <= found.exact.upper, (found, float(value))
    assert found.relative_width <= 1e-12, found


@pytest.mark.parametrize("exponent", [0, -300, 300])
def test_the_exact_point_attains_its_value(exponent):
    t = 2.0**exponent
    problem = Problem([[2.0]], [t], lambda1=1, lambda2=0.5 * t, lambda3=0.25 * t)
    exact = enclose(problem).exact
    w, u = exact.w[0], exact.t[0] * 2 * exact.q[0]
    o, half = Fraction(t), Fraction(t) / 2
    value = (2 * w - o) ** 2 + (2 * u - w) ** 2 + half * abs(w) + half / 2 * abs(u)
    assert exact.lower <= exact.upper <= exact.value, exact
    assert exact.lower <= value <= exact.value, exact
    assert u != 0, exact


def hard(seed: int) -> Problem:
    """Rows scaled by 1e+-6, and lambdas of any size or 0: float64 alone often misses these."""
    rng = np.random.default_rng(seed)
    n, d = int(rng.integers(1, 6)), int(rng.integers(2, 20))
    X = rng.normal(size=(n, d)) * 10.0 ** rng.uniform(-6, 6, (n, 1))
    one, two, three = (float(rng.choice([0, 1e-3, 0.1, 10])) for _ in range(3))
    cut = int(rng.integers(1, d))
    return Problem(X, rng.normal(size=d), modalities=[cut, d - cut], lambda1=one, lambda2=two, lambda3=three)


@pytest.mark.parametrize("seed", range(40))
def test_it_agrees_with_the_float_certificate_and_is_narrow(seed):
    problem = hard(seed)
    found = enclose(problem)
    judged = certify(problem, found.w, found.u)
    assert found.lower <= judged.upper, (found, judged)
    assert judged.lower <= found.upper, (found, judged)
    assert found.relative_width <= 1e-12 or found.share_of_target <= 1e-15, found


@pytest.mark.parametrize("seed", range(8))
def test_the_objective_at_floats_is_the_rational_one(seed):
    rng = np.random.default_rng(seed)
    X, o = rng.normal(size=(2, 3)), rng.normal(size=3)
    w, u = rng.normal(size=2), rng.normal(size=3)
    problem = Problem(X, o, lambda1=0.5, lambda2=0.25, lambda3=0.0)
    A, t, x, y = ([Fraction(float(v)) for v in a.ravel()] for a in (X, o, w, u))
    rows = A[:3], A[3:]
    loss = sum((sum(rows[i][k] * x[i] for i in range(2)) - t[k]) ** 2 for k in range(3))
    coupling = sum((sum(rows[i][k] * y[k] for k in range(3)) - x[i]) ** 2 for i in range(2))
    exact = loss + coupling / 2 + sum(abs(v) for v in x) / 4
    with precision(200):
        value = objective_at(problem, w, u)
    with precision(1000):
        assert value.contains(flint.arb(flint.fmpq(exact.numerator, exact.denominator))), (value, exact)


class Poor:
    """Answers w = u = 0, whatever it is asked."""

    name = "poor"

    def solve(self, problem: Problem) -> SolverResult:
        return SolverResult(np.zeros(problem.n), np.zeros(problem.d), "optimal", 1)


@pytest.mark.parametrize("seed", [0, 1, 2, 3])
def test_escalation_certifies_what_a_poor_solver_leaves(seed):
    rng = np.random.default_rng(seed)
    problem = Problem(rng.normal(size=(3, 8)), rng.normal(size=8), lambda1=1, lambda2=0.1, lambda3=0.1)
    left = solve(problem, Poor())
    assert left.status is Status.NOT_CERTIFIED, left.certificate
    found = solve(problem, Poor(), escalate=True)
    assert found.status is Status.CERTIFIED, found.certificate
    assert "ball arithmetic" in found.solver, found.solver
    reference = solve(problem, Conic())
    assert abs(found.value - reference.value) <= 1e-8 * reference.value, (found.value, reference.value)


def test_an_optimum_that_no_float_point_attains_is_called_enclosed():
    X = np.array([[1.0, 0.1], [1.0, 0.1 * (1 + 2**-52)]])
    problem = Problem(X, [1.0, 3.0], lambda1=1, lambda2=0, lambda3=0)
    found = solve(problem, Poor(), escalate=True)
    assert found.status is Status.ENCLOSED, (found.status, found.certificate)
    assert found.certificate.upper <= 1e-14 * 10, found.certificate


def test_certifying_in_balls_judges_the_point_itself():
    problem = Problem([[1.0]], [1.0], lambda1=1, lambda2=0.5, lambda3=0.25)
    found = enclose(problem)
    judged = certify_in_balls(problem, found, certify(problem, found.w, found.u))
    assert judged.certified, judged
    assert judged.objective[0] <= 19 / 32 * (1 + 1e-12), judged
    assert judged.gap >= judged.objective[0] - judged.upper, judged


@pytest.mark.parametrize("hole", [np.nan, np.inf])
def test_a_point_with_holes_is_never_certified_in_balls(hole):
    problem = Problem([[1.0]], [1.0], lambda1=1, lambda2=0.5, lambda3=0.25)
    found = enclose(problem)
    point = np.array([hole]), np.array([0.5])
    judged = certify_in_balls(problem, found, certify(problem, *point), point)
    assert not judged.certified, judged
    assert judged.gap == np.inf, judged
    assert judged.objective == (0.0, np.inf), judged


@pytest.mark.parametrize("index", [1, 3])
def test_a_matrix_singular_in_one_precision_is_met_with_more_bits(index):
    problem = seeded("mixed_scales", 11, index, largest=(8, 40))
    found = enclose(problem)
    judged = certify(problem, found.w, found.u)
    assert 0.0 <= found.lower <= found.upper, found
    assert found.lower <= judged.upper, (found, judged)
    assert judged.lower <= found.upper, (found, judged)


@pytest.mark.parametrize("index", [10, 21, 28])
def test_entries_of_any_size_in_one_matrix_still_give_a_narrow_interval(index):
    problem = seeded("mixed_scales", 0, index)
    found = solve(problem, Poor(), escalate=True)
    assert found.certificate.enclosed, (found.status, found.certificate)


NEARLY_ZERO = {"one": [1.0], "several": [1.0, -2.0], "the same": [1.0, 1.0]}
"""Views in multiples of the size."""


@pytest.mark.parametrize("size", [1e-25, 1e-100, 1e-300])
@pytest.mark.parametrize("name", NEARLY_ZERO)
def test_nearly_zero_views_leave_the_optimum_of_the_others(name, size):
    """X = (1, 3)', o = 2, lambda = (1, 1/10, 0): X'w = 99/50 and w = (21, 75.5) / 125."""
    X = [*(size * multiple for multiple in NEARLY_ZERO[name]), 1.0, 3.0]
    problem = Problem([[x] for x in X], [2.0], lambda1=1, lambda2=0.1, lambda3=0)
    value, w = Fraction(393, 5000), [0.0] * (len(X) - 2) + [0.168, 0.604]
    solution, found = solve(problem), enclose(problem)
    assert solution.certificate.enclosed, solution.certificate
    assert found.bits == 128, found
    assert found.relative_width <= 1e-12, found
    assert abs(found.exact.upper - value) <= Fraction(1e-16) * value, found
    assert found.w == pytest.approx(w, abs=1e-12), found.w
    assert found.u == pytest.approx([0.198], rel=1e-12), found.u
    for intervals in (weight_intervals(solution).views, weight_intervals(solution, found).views):
        assert intervals.determined.all(), intervals
        assert (intervals.lower <= np.array(w) + 1e-15).all(), intervals
        assert (intervals.upper >= np.array(w) - 1e-15).all(), intervals


@pytest.mark.parametrize("size", [1e-25, 1e-100, 1e-300])
def test_nearly_zero_views_of_least_squares_keep_the_exact_distance(size):
    problem = Problem([[size, size], [1, 1], [3, 3]], [1, 0], lambda1=1, lambda2=0, lambda3=0)
    found, solution = enclose(problem), solve(problem)
    assert found.exact.lower <= Fraction(1, 2) <= found.exact.upper, found
    assert solution.certificate.enclosed, solution.certificate
    assert solution.certificate.lower <= 0.5 <= solution.certificate.upper, solution.certificate


@pytest.mark.parametrize("index", range(10))
def test_the_referee_agrees_on_nearly_zero_views(index):
    problem = seeded("nearly_zero_view", 3, index, largest=(5, 4))
    found, truth = enclose(problem), optimum(problem).value
    assert found.exact.lower <= truth.upper, (found, truth)
    assert truth.lower <= found.exact.upper, (found, truth)
    assert found.relative_width <= 1e-12 or found.share_of_target <= 1e-15, found


def test_a_start_that_is_far_off_costs_steps_and_not_the_interval():
    problem = seeded("extreme_data", 0, 403)
    nothing = np.zeros(problem.n), np.zeros(problem.d)
    without, given = enclose(problem), enclose(problem, start=nothing)
    assert without.relative_width <= 1e-12, without.relative_width
    assert given.relative_width <= 1e-12, given.relative_width
    assert given.lower <= without.upper, (given.lower, without.upper)
    assert without.lower <= given.upper, (without.lower, given.upper)


def test_the_scale_of_a_dual_point_fits_the_largest_norm_of_its_ball():
    one = flint.arb(1)
    assert _limited(one, one, flint.arb(2, 0.5)) * 2.5 <= one
    assert _limited(one, one, flint.arb(0.5, 0.25)) == one


def test_the_gap_in_balls_reaches_down_to_the_lower_bound():
    problem = Problem([[1.0, 0.5], [0.25, 1.0]], [1.0, 1.0], lambda1=1.0, lambda2=0.1, lambda3=0.1)
    found = enclose(problem)
    before = replace(certify(problem, found.w, found.u), lower=0.0)
    proof = certify_in_balls(problem, replace(found, lower=0.5 * found.lower), before)
    assert proof.lower == 0.5 * found.lower, proof
    assert proof.gap >= proof.objective[0] - proof.lower > 0.0, proof
