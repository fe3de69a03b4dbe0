"""Certified optima against what nobody here wrote: closed forms, linear programs, other certificates."""

from fractions import Fraction
from itertools import product

import numpy as np
import pytest
from flint import fmpq
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

from convexperc import Problem, solve
from convexperc.lasso import certify_lasso
from verification.exact.balls import exact, precision
from verification.reweighted import each_loss, loss, norm, norm1, squares, variable
from verification.reweighted.objectives import optimum as module
from verification.reweighted.objectives.conjugates import NotCoveredError, blocks
from verification.reweighted.objectives.optimum import optimum
from verification.reweighted.objectives.system import System

TIGHT = 1e-30
SCALES = (1.0, 1e-10, 1e10)


def points_objective(points):
    p = variable("p", len(points[0]))
    return sum(norm(p - np.array(point, dtype=object)) for point in points)


def holds(found, value, tight=TIGHT):
    assert found.lower is not None, found.reason
    assert found.lower <= value <= found.upper
    assert found.gap <= tight


@given(st.lists(st.tuples(st.integers(-50, 50), st.integers(1, 9)), min_size=1, max_size=7))
@settings(max_examples=40)
def test_weighted_medians_of_integers(pairs):
    """The least value lies at one of the points."""
    m = variable("m")
    objective = sum(norm(m - y) * w for y, w in pairs)
    holds(optimum(objective), min(sum(w * abs(y - x) for y, w in pairs) for x, _ in pairs))


@pytest.mark.parametrize("q", ["1/4", "9/10"])
def test_quantiles_of_integers(q):
    y, share = [3, -1, 7, 7, 12, 0], Fraction(q)
    objective = each_loss(
        np.array(y) - np.ones((6, 1), dtype=int) @ variable("m", 1),
        f"{q}*r if r>=0 else ({q}-1)*r",
        "1/abs(r)",
    )
    values = [sum(share * max(v - x, 0) + (1 - share) * max(x - v, 0) for v in y) for x in y]
    holds(optimum(objective), min(values))


@pytest.mark.parametrize("scale", [1, Fraction(1, 10**10), 10**10])
def test_four_points_have_their_median_where_the_diagonals_cross(scale):
    corners = [(0, 0), (3, 4), (0, 4), (3, 0)]
    holds(optimum(points_objective([[x * scale for x in corner] for corner in corners])), 10 * scale)


def test_fermat_points():
    """An angle of 120 degrees or more: the corner; else the length that Torricelli's circles give."""
    found = optimum(points_objective([(0, 0), (-4, 3), (4, 3)]))  # 106 degrees at the first corner
    assert found.gap < TIGHT
    # |distances|^2 = (a^2 + b^2 + c^2)/2 + 2 sqrt(3) area, with sides 5, 5, 8 and area 12
    assert float(found.upper) == pytest.approx(np.sqrt(57 + 24 * np.sqrt(3)), rel=1e-15)
    corner = optimum(points_objective([(0, 0), (-12, 5), (12, 5)]))  # 135 degrees: 13 + 13
    holds(corner, 26)


def test_points_on_a_line_and_one_point_alone():
    holds(optimum(points_objective([(0, 0), (3, 4), (6, 8), (15, 20)])), 30)  # the distances 0, 5, 10, 25
    holds(optimum(points_objective([(5, -2)])), 0)


def least_absolute(X, y, q=0.5):
    n, p = X.shape
    costs = np.concatenate([np.zeros(p), np.full(n, q), np.full(n, 1 - q)])
    free = [(None, None)] * p + [(0, None)] * (2 * n)
    return linprog(costs, A_eq=np.hstack([X, np.eye(n), -np.eye(n)]), b_eq=y, bounds=free).fun


@pytest.mark.parametrize("seed", range(6))
def test_least_absolute_deviations_are_linear_programs(seed):
    rng = np.random.default_rng(seed)
    X, y = rng.integers(-4, 5, (9, 3)).astype(float), rng.integers(-9, 10, 9).astype(float)
    if seed % 2:
        X[:, 2] = X[:, 0] - 2 * X[:, 1]  # of rank 2
    q = 0.5 if seed < 3 else 0.25
    expected = least_absolute(X, y, q)
    for scale in SCALES:
        objective = each_loss(y * scale - X @ variable("b", 3), f"{q}*r if r>=0 else ({q}-1)*r", "1/abs(r)")
        found = optimum(objective)
        assert found.gap < TIGHT
        assert float(found.upper) == pytest.approx(expected * scale, rel=1e-9, abs=1e-12 * scale)


@pytest.mark.parametrize("scale", SCALES)
@pytest.mark.parametrize("penalty", [0.3, 4.0, 1e6])
def test_lassos_agree_with_their_certificates(scale, penalty):
    rng = np.random.default_rng(7)
    X, y = rng.normal(size=(12, 5)), rng.normal(size=12) * scale
    b = variable("b", 5)
    found = optimum(squares(X @ b - y) * Fraction(1, 2) + norm1(b) * (penalty * scale))
    assert found.gap < TIGHT
    point = np.array([float(x) for x in found.point["b"]])
    other = certify_lasso(X, y, point, penalty * scale / 12)
    lower, upper = other.lower * 12, other.upper * 12
    assert lower * (1 - 1e-12) <= float(found.lower) <= upper * (1 + 1e-12)
    assert upper - lower <= 1e-6 * upper


@pytest.mark.parametrize("seed", range(3))
def test_the_paper_s_objective_agrees_with_its_certificates(seed):
    rng = np.random.default_rng(seed)
    X, o = rng.normal(size=(3, 6)), rng.normal(size=6)
    modalities = [2, 4]
    proof = solve(
        Problem(X, o, lambda1=0.5, lambda2=0.25, lambda3=0.125 * (1 + seed), modalities=modalities)
    ).certificate
    w, u = variable("w", 3), variable("u", 6)
    objective = squares(X.T @ w - o) + squares(X @ u - w) * 0.5 + norm1(w) * 0.25
    objective = objective + (norm(u[:2]) + norm(u[2:])) * (0.125 * (1 + seed))
    found = optimum(objective)
    assert found.gap < TIGHT
    assert proof.lower <= found.upper
    assert found.lower <= proof.upper


def test_huber_and_smoothed_losses_in_closed_form():
    m = variable("m", 1)
    residuals = np.ones((2, 1), dtype=int) @ m - np.array([0, 10])
    formula = "r**2/2 if abs(r) <= 2 else 2*abs(r) - 2"
    holds(optimum(each_loss(residuals, formula, "1")), 16)  # any m between 2 and 8: 2 m - 2 + 2 (10 - m) - 2
    three = each_loss(np.ones((3, 1), dtype=int) @ m - np.array([0, 0, 10]), formula, "1")
    holds(optimum(three), 1 + 16)  # slope 2 m - 2 = 0: m = 1, 1/2 + 1/2 + 2 * 9 - 2
    smoothed = optimum(
        loss(variable("z", 2) - np.array([3, 4]), "2*sqrt(r**2 + 1/4)", "1") + norm(variable("z", 2))
    )
    holds(smoothed, smoothed.upper)
    curve = [2 * np.sqrt((5 - t) ** 2 + 0.25) + t for t in np.linspace(0, 5, 100_001)]
    assert float(smoothed.upper) == pytest.approx(min(curve), rel=1e-9)


def test_two_norms_of_matrices():
    rng = np.random.default_rng(3)
    X, Y, W = rng.normal(size=(5, 3)), rng.normal(size=(5, 2)), variable("W", 3, 2)
    residual = X @ W - Y
    found = optimum(sum(norm(residual[i]) for i in range(5)) + sum(norm(W[j]) for j in range(3)) * 0.5)
    assert found.gap < TIGHT

    def value(entries):
        M = entries.reshape(3, 2)
        return np.linalg.norm(X @ M - Y, axis=1).sum() + 0.5 * np.linalg.norm(M, axis=1).sum()

    best = np.array([float(x) for x in found.point["W"]])
    assert value(best) == pytest.approx(float(found.upper), rel=1e-12)
    assert all(value(best + 1e-3 * step) >= value(best) for step in rng.normal(size=(200, 6)))


@given(st.integers(0, 10**6))
@settings(max_examples=30)
def test_the_bounds_hold_whatever_is_suggested(seed):
    """A suggestion of noise, of any size: the optimum stays between the bounds."""
    rng = np.random.default_rng(seed)
    X, y = rng.integers(-3, 4, (6, 2)), rng.integers(-5, 6, 6)
    objective = norm1(X @ variable("b", 2) - y) + squares(variable("b", 2)) * Fraction(1, 8)
    truth = optimum(objective)

    def noise(system):
        size = 10.0 ** rng.integers(-3, 4)
        return [exact(x) for x in rng.normal(size=2) * size], [
            exact(x) for x in rng.normal(size=len(system.d)) * size
        ]

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(module, "suggested", noise)
        found = optimum(objective)
    assert found.lower <= truth.upper
    assert truth.lower <= found.upper


def test_a_dual_vector_is_made_feasible_before_it_bounds():
    """Twice the optimal vector, and one that misses the equality, would both claim more than the optimum."""
    system = System(blocks(points_objective([(0,), (1,), (5,)])))
    best = [fmpq(1), fmpq(0), fmpq(-1)]
    with precision(256):
        assert system.below(best) == 5
        doubled = [2 * x for x in best]
        assert sum(x * b for x, b in zip(doubled, system.d, strict=True)) == 10
        assert 5 * (1 - fmpq(1, 10**60)) < system.below(doubled) <= 5
        astray = [fmpq(-1), fmpq(-1), fmpq(-1)]
        assert sum(x * b for x, b in zip(astray, system.d, strict=True)) == 6
        moved = system.feasible(astray)
        assert sum(moved) == 0
        assert system.below(moved) <= 5


def test_without_a_dual_vector_there_is_no_lower_bound():
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(module, "suggested", lambda system: ([fmpq(0)] * system.n, None))
        found = optimum(points_objective([(0, 0), (2, 0), (0, 2)]))
    assert found.lower is None
    assert "no dual vector" in found.reason
    assert found.gap == float("inf")
    assert float(found.upper) >= 3.8


def test_losses_of_which_no_conjugate_is_known_are_refused():
    m = variable("m")
    for formula in ("log(1 + r**2)", "r**2/2 if r <= 1 else r", "sqrt(2)*r", "r**4"):
        with pytest.raises(NotCoveredError, match="k\\*r"):
            optimum(loss(m - 1, formula, "1"))


@pytest.mark.parametrize(("outlier", "unit"), list(product([1e6, 1e12], [1.0, 1e-8])))
def test_outliers_and_columns_of_other_units(outlier, unit):
    X = np.array([[1.0, 2], [1, 5], [1, -3], [1, 0], [1, 4]]) * np.array([1.0, unit])
    y = np.array([1.0, 2, -1, 0, outlier])
    found = optimum(norm1(X @ variable("b", 2) - y))
    assert found.gap < 1e-9
    assert float(found.upper) == pytest.approx(least_absolute(X / np.array([1.0, unit]), y) * 2, rel=1e-9)
