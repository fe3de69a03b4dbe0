import itertools
import math
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from rational import objective_bounds, smallest_scalar

from convexperc.certificate.certificate import SUFFICIENT_SHARE, Certifier, certify
from convexperc.certificate.duality import dual_value
from convexperc.certificate.evaluation import NormalizedData
from convexperc.problem.problem import Problem
from convexperc.problem.scaling import Scaling
from convexperc.solution.single import solve
from convexperc.solvers.conic import Conic


def posed(X, o, lambdas, modalities=None):
    one, two, three = lambdas
    return Problem(X, o, modalities=modalities, lambda1=one, lambda2=two, lambda3=three)


def judged(problem, w, u, exact, **options):
    """Certify, and hold every bound against the exact optimum and the exact F(w, u)."""
    proof = certify(problem, w, u, **options)
    groups = [np.r_[c].tolist() for c in problem.modalities]
    low, high = objective_bounds(problem.X, problem.o, groups, problem.lambdas, (np.array(w), np.array(u)))
    assert Fraction(proof.lower) <= exact <= Fraction(proof.upper), (proof.lower, float(exact), proof.upper)
    assert Fraction(proof.objective[0]) <= high, (proof.objective, float(high))
    assert low <= Fraction(proof.objective[1]), (proof.objective, float(low))
    assert low - exact <= Fraction(proof.gap), (float(low - exact), proof.gap)
    return proof


KNOWN = [
    ([[1]], [1], (1, 0.5, 0.25), [0.625], [0.5], "19/32"),
    ([[1]], [1], (1, 1, 0), [0.5], [0.5], "3/4"),
    ([[1]], [-1], (1, 4, 0), [0], [0], "1"),
    ([[1]], [3], (0, 2, 1), [2], [0], "5"),
    ([[1, 0], [3, 1]], [1, 0], (1, 1, 0), [0, 0.25], [0, 0.25], "3/8"),
    ([[1, 1]], [3, 1], (0, 0, 0), [2], [7, -7], "2"),
    ([[1], [1]], [6], (0, 0, 5), [3, 3], [0], "0"),
    ([[1], [1]], [6], (2, 0, 0), [3, 3], [3], "0"),
    ([[1, 0], [0, 1]], [0, 0], (1, 1, 1), [0, 0], [0, 0], "0"),
    ([[0, 0]], [3, 4], (1, 1, 1), [0], [0, 0], "25"),
    ([[0, 0]], [3, 4], (1, 0, 0), [0], [0, 0], "25"),
    ([[0]], [0], (0, 0, 0), [0], [0], "0"),
]


@pytest.mark.parametrize(("X", "o", "lambdas", "w", "u", "exact"), KNOWN)
def test_known_optima_are_certified(X, o, lambdas, w, u, exact):
    problem, exact = posed(X, o, lambdas), Fraction(exact)
    proof = judged(problem, w, u, exact)
    assert proof.certified, (proof.gap, proof.relative_gap, proof.share_of_target)
    assert proof.upper - proof.lower <= 1e-13 * max(float(exact), float(problem.o @ problem.o)), proof
    assert proof.is_optimal(proof.gap), proof.gap
    assert not proof.is_optimal(math.nextafter(proof.gap, -1.0)), proof.gap


@pytest.mark.parametrize(
    ("X", "o", "lambdas", "exact"),
    [
        ([[1, 3], [0, 1]], [1, 3], (1, 0, 1), "135/476"),
        ([[1, -3], [-1, 2]], [1, -4], (2, 2, 2), None),
    ],
)
def test_solved_counterexamples_of_the_paper(X, o, lambdas, exact):
    problem = posed(X, o, lambdas, [1] * len(o))
    proof = solve(problem, Conic()).certificate
    assert proof.certified, proof
    if exact is not None:
        assert Fraction(proof.lower) <= Fraction(exact) <= Fraction(proof.upper), (proof.lower, proof.upper)
        assert proof.upper - proof.lower < 1e-9, (proof.lower, proof.upper)


NUMBER = st.integers(0, 400).map(lambda k: k / 64) | st.floats(2.0**-20, 100)


@settings(max_examples=50)
@given(
    st.floats(0.01, 100), st.tuples(NUMBER, NUMBER, NUMBER), st.tuples(*[st.booleans()] * 3), st.floats(-2, 2)
)
@example(1.0, (1.0, 1.0, 1.0), (True, True, True), 0.5)
def test_one_entry_against_its_closed_form_for_every_lambda_zero(o, lambdas, absent, away):
    lambdas = tuple(0.0 if gone else value for gone, value in zip(absent, lambdas, strict=True))
    w, u, exact = smallest_scalar(Fraction(o), [Fraction(v) for v in lambdas])
    problem = posed([[1.0]], [o], lambdas)
    at = judged(problem, [float(w)], [float(u)], exact)
    assert at.certified, (at.relative_gap, at.share_of_target, at.method)
    judged(problem, [float(w) + away], [float(u) - away], exact)
    judged(problem, [float(w)], [float(u)], exact, dual=([1e9], [-1e9]))


@pytest.mark.parametrize("zero", list(itertools.product([True, False], repeat=3)))
@pytest.mark.parametrize("shape", [(3, 7), (5, 3)])
def test_every_lambda_zero_on_wide_and_tall_data(zero, shape):
    random = np.random.default_rng(11)
    lambdas = [0.0 if gone else value for gone, value in zip(zero, (0.7, 0.2, 0.3), strict=True)]
    problem = posed(random.normal(size=shape), random.normal(size=shape[1]), lambdas, [1, shape[1] - 1])
    found = solve(problem, Conic())
    proof = found.certificate
    assert proof.certified, (
        lambdas,
        found.solver_status,
        proof.method,
        proof.relative_gap,
        proof.share_of_target,
    )
    worse = certify(problem, found.w + 0.01, found.u)
    assert not worse.certified, (worse.relative_gap, worse.share_of_target)
    assert worse.lower <= proof.upper, (worse.lower, proof.upper)


@settings(max_examples=20)
@given(st.integers(0, 2**32 - 1), st.sampled_from([0.0, 2.0**-40, 1.0]))
def test_no_point_lies_below_any_lower_bound(seed, noise):
    random = np.random.default_rng(seed)
    n, d = random.integers(1, 4, 2)
    X, o = random.normal(size=(n, d)), random.normal(size=d)
    lambdas = random.choice([0.0, 2.0**-30, 0.3, 5.0], 3)
    problem = posed(X, o, lambdas.tolist(), [d])
    base = np.linalg.lstsq(X.T, o)[0], np.zeros(d)
    points = [(base[0] + noise * random.normal(size=n), noise * random.normal(size=d)) for _ in range(3)]
    hint = 2 * (X.T @ base[0] - o), random.normal(size=n)
    lower = max(
        certify(problem, *point, dual=dual).lower for point in [*points, base] for dual in (None, hint)
    )
    for point in [*points, base]:
        high = objective_bounds(X, o, [range(d)], lambdas.tolist(), point)[1]
        assert Fraction(lower) <= high, (lower, float(high), lambdas)


@settings(max_examples=40)
@given(st.floats(-1, 1), st.floats(-1, 1), st.integers(-300, 300))
def test_perturbed_points_are_not_certified_and_the_gap_is_true(dw, du, exponent):
    o = math.ldexp(8.0, exponent)
    problem = posed([[1.0]], [o], (1, o / 2, o / 4))
    w, u = 5 * o / 8 + dw * o, o / 2 + du * o
    proof = judged(problem, [w], [u], Fraction(19, 32) * Fraction(o) ** 2)
    if abs(dw) + abs(du) > 1e-3:
        assert not proof.certified, (dw, du, proof.relative_gap)


@settings(max_examples=25)
@given(st.integers(0, 2**32 - 1))
def test_gap_terms_are_the_brackets_of_the_formula_and_sum_to_the_gap(seed):
    random = np.random.default_rng(seed)
    X, o, w, u = (random.normal(size=s) for s in ((2, 4), 4, 2, 4))
    problem = posed(X, o, random.uniform(0.1, 2.0, 3).tolist(), [1, 3])
    proof = certify(problem, w, u)
    scaling = Scaling.of(problem)
    frame = NormalizedData.of(problem, scaling)
    point, terms, (w_, u_) = proof.dual, proof.terms, scaling.point(w, u)
    assert (point is None) == (terms is None), proof
    if point is None:
        assert proof.method == "F >= 0", proof.method
        return
    a, b, v = point.scale * point.a, point.scale * point.b.mid, point.scale * point.v.mid
    one, two, three = frame.lambda1[0], frame.lambda2[0], frame.lambda3[0]
    p, q, Xb = frame.X.T @ w_ - frame.o, frame.X @ u_ - w_, frame.X.T @ b
    assert v == pytest.approx(frame.X @ a - b, abs=1e-12)
    assert terms.loss == pytest.approx(float(np.sum((p - a / 2) ** 2)), rel=1e-9, abs=1e-12)
    assert terms.coupling == pytest.approx(one * float(np.sum((q - b / (2 * one)) ** 2)), rel=1e-9, abs=1e-12)
    if point.feasible:
        assert terms.view_norm == pytest.approx(float(np.abs(w_) @ (two + np.sign(w_) * v)), abs=1e-12)
        norms = float(problem.modalities.norms(u_).sum())
        assert terms.modality_norm == pytest.approx(three * norms + float(u_ @ Xb), abs=1e-12)
        low, high = dual_value(point)
        assert low <= high <= low + 1e-12, (low, high)
    total = sum((terms.loss, terms.coupling, terms.view_norm, terms.modality_norm))
    assert total <= terms.total <= total * (1 + 1e-15) + 1e-300, (total, terms.total)
    assert proof.gap <= math.ldexp(terms.total, 2 * scaling.o) * (1 + 1e-9) or not point.feasible, proof


def test_tolerances_decide_and_are_recorded():
    problem = posed([[1]], [8], (1, 4, 2))
    options = {"relative_tolerance": 1e-2, "absolute_tolerance": 0.0}
    near = [5.0 + 2.0**-6], [4.0]
    strict, loose = certify(problem, *near), certify(problem, *near, **options)
    share = certify(problem, *near, relative_tolerance=0.0, absolute_tolerance=1e-2)
    assert [proof.certified for proof in (strict, loose, share)] == [False, True, True], strict.relative_gap
    assert (loose.relative_tolerance, loose.absolute_tolerance) == (1e-2, 0.0)
    assert strict.relative_gap == pytest.approx(strict.gap / strict.lower)
    assert strict.share_of_target == pytest.approx(strict.gap / 64)


def test_an_interval_is_enclosed_by_its_width_whatever_the_gap_of_the_point():
    proof = certify(posed([[1.0, 0.5], [0.25, 1.0]], [1.0, 1.0], (1.0, 0.1, 0.1)), [0.0, 0.0], [0.0, 0.0])
    infinite = dict.fromkeys(("gap", "relative_gap", "share_of_target"), math.inf)
    proof = replace(proof, **infinite, lower=1.0, target=1.0)
    assert replace(proof, upper=1.0 + 0.9e-9).enclosed
    assert not replace(proof, upper=1.0 + 1.1e-9).enclosed
    assert not replace(proof, upper=1.0 + 0.9e-9).certified


@pytest.mark.parametrize("lambdas", list(itertools.product([0.0, 0.75], [0.0, 0.25], [0.0, 0.5])))
@pytest.mark.parametrize(("x", "y"), [(0, 40), (33, 0), (-60, 150), (100, -200), (120, 200)])
def test_the_certificate_of_a_scaled_problem_is_the_same_bit_for_bit(lambdas, x, y):
    random = np.random.default_rng(3)
    X, o, w, u = (random.normal(size=s) for s in ((3, 4), 4, 3, 4))
    s, t, (one, two, three) = 2.0**x, 2.0**y, lambdas
    plain = certify(posed(X, o, lambdas, [2, 2]), w, u)
    moved = certify(
        posed(s * X, t * o, (s * s * one, s * t * two, s * s * t * three), [2, 2]), w * t / s, u * t / (s * s)
    )
    for field in ("lower", "upper", "gap"):
        assert getattr(moved, field) == t * t * getattr(plain, field), field
    for field in ("relative_gap", "share_of_target", "method", "terms"):
        assert getattr(moved, field) == getattr(plain, field), field
    assert moved.zero_views.tolist() == plain.zero_views.tolist()


def test_zeros_are_proved_of_every_optimum():
    X = [[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0], [0.1, 0.0, 0.0, 1.0]]
    problem = posed(X, [1.0, 0.0, 0.0, 0.0], (1, 0.5, 0.25), [1, 2, 1])
    found = solve(problem, Conic())
    assert found.certificate.zero_views.tolist() == [False, True, True], (found.w, found.certificate)
    assert found.certificate.zero_modalities.tolist()[:2] == [False, True], (found.u, found.certificate)
    assert found.w[0] > 0.1, found.w
    poor = certify(problem, [0.0, 0.0, 0.0], [0.0] * 4)
    assert not poor.zero_views[0], poor


def test_the_search_ends_with_the_first_proof_unless_the_best_is_wanted():
    random = np.random.default_rng(4)
    X, o = random.normal(size=(3, 7)), random.normal(size=7)
    problem = posed(X, o, (0.7, 0.2, 0.3), [3, 4])
    found = solve(problem, Conic())
    first, best = (certify(problem, found.w, found.u, thorough=thorough) for thorough in (False, True))
    assert first.certified, first
    assert first.method == "dual point 'slack', scaled", first.method
    assert first.relative_gap <= SUFFICIENT_SHARE * first.relative_tolerance, first
    assert best.gap <= first.gap, (best.gap, first.gap)
    assert best.lower >= first.lower, (best.lower, first.lower)
    assert (best.zero_views >= first.zero_views).all(), (best.zero_views, first.zero_views)
    away = [certify(problem, found.w + 0.1, found.u, thorough=thorough) for thorough in (False, True)]
    assert not away[0].certified, away[0]
    assert away[0].gap == away[1].gap, "what is not certified was tried with every dual point"
    hard = {"relative_tolerance": 0.0, "absolute_tolerance": 0.0}
    assert certify(problem, found.w, found.u, **hard).gap == best.gap


def test_a_judge_judges_many_points_as_certify_does():
    random = np.random.default_rng(4)
    X, o = random.normal(size=(3, 7)), random.normal(size=7)
    for lambdas in ((0.7, 0.2, 0.3), (0.7, 0.0, 0.0)):
        problem = posed(X, o, lambdas, [3, 4])
        judge = Certifier.of(problem, thorough=True)
        for _ in range(3):
            w, u = random.normal(size=3), random.normal(size=7)
            mine, plain = judge.certificate(w, u), certify(problem, w, u, thorough=True)
            assert (mine.lower, mine.upper, mine.gap) == (plain.lower, plain.upper, plain.gap)
            assert mine.method == plain.method, (mine.method, plain.method)
