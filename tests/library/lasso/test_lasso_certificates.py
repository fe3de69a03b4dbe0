"""Bounds of penalised fits: against exact values at points that CVXPY finds; and fitted estimators."""

import warnings
from fractions import Fraction

import numpy as np
import pytest
from exact_fits import Fit
from sklearn.linear_model import ElasticNet, ElasticNetCV, Lasso, LassoCV, LassoLars, LinearRegression, Ridge

from convexperc import Problem, enclose
from convexperc.errors import InputError, PointError, ProblemError, ToleranceError
from convexperc.lasso import CONVENTIONS, certify, certify_lasso

LABELS = np.array([2, 0, 0, 1, 2, 1, 1, 3])
SIZES = {label: int((label == LABELS).sum()) for label in range(4)}


def data(seed: int, n: int = 12, p: int = 8):
    rng = np.random.default_rng(seed)
    X = rng.standard_normal((n, p)) * rng.choice([0.1, 1.0, 5.0], p)
    if seed % 3 == 1:
        X[:, 1] = X[:, 0]  # equal columns
    if seed % 3 == 2:
        X[:, 2] = 0.0
    y = X[:, :3].sum(axis=1) + rng.standard_normal(n) + (2.0 if seed % 2 else 0.0)
    return X, y


def fit(name: str, X, y, alpha: float, ratio: float, l1_reg: float, grouped: bool, positive: bool) -> Fit:
    """The objective by its formula, written out again."""
    n, a, r = Fraction(len(y)), Fraction(alpha), Fraction(ratio)
    none = dict.fromkeys(range(0), Fraction(0))
    if name in ("scikit-learn", "glmnet") or (not grouped and name in ("celer", "skglm", "adelie")):
        parts = (1 / n, a * r, none, a * (1 - r))
    elif name == "scikit-learn ridge":
        parts = (Fraction(2), Fraction(0), none, 2 * a)
    elif name in ("celer", "skglm"):
        parts = (1 / n, Fraction(0), dict.fromkeys(SIZES, a), Fraction(0))
    elif name == "residual sum of squares":
        parts = (Fraction(2), Fraction(0), dict.fromkeys(SIZES, a), Fraction(0)) if grouped else (
            Fraction(2), a * r, none, a * (1 - r))  # fmt: skip
    elif name == "group-lasso":
        parts = (1 / n, Fraction(l1_reg), roots(a), Fraction(0)) if grouped else (
            1 / n, a + Fraction(l1_reg), none, Fraction(0))  # fmt: skip
    else:
        assert name == "asgl"
        parts = (2 / n, a * r, roots(a * (1 - r)), Fraction(0)) if grouped else (2 / n, a, none, Fraction(0))
    K, l1, group, ridge = parts
    return Fit(X, y, K, l1, group, ridge, LABELS, positive)


def roots(factor: Fraction) -> dict[int, Fraction]:
    """Square roots of the sizes, to 40 digits: the bounds must allow for what is left."""
    from math import isqrt  # noqa: PLC0415

    return {g: factor * Fraction(isqrt(size * 10**80), 10**40) for g, size in SIZES.items()}


CASES = [
    (name, grouped, intercept, positive)
    for name, convention in CONVENTIONS.items()
    for grouped in (False, True)
    for intercept in (False, True)
    for positive in (False, True)
    if not (grouped and "groups" not in convention.takes) and (name, grouped) != ("adelie", True)
]


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(("name", "grouped", "intercept", "positive"), CASES)
def test_the_bounds_hold_and_are_narrow_at_what_cvxpy_finds(name, grouped, intercept, positive, seed):
    X, y = data(seed)
    rng = np.random.default_rng(seed)
    taken = CONVENTIONS[name].takes
    alpha, ratio, l1_reg = 0.3, 0.4 if "l1_ratio" in taken else 1.0, 0.05 if "l1_reg" in taken else 0.0
    if grouped and name in ("celer", "skglm", "residual sum of squares"):
        ratio = 1.0
    given = {"alpha": alpha, "convention": name, "positive": positive}
    given |= {"l1_ratio": ratio} if "l1_ratio" in taken and not (name == "asgl" and not grouped) else {}
    given |= {"l1_reg": l1_reg} if "l1_reg" in taken else {}
    given |= {"groups": LABELS} if grouped else {}
    exact = fit(name, X, y, alpha, ratio, l1_reg, grouped, positive)
    b, b0 = exact.solved(intercept)
    best = exact.value(b, b0)[1]
    points = [(b, b0), (np.round(b, 3), b0), (np.zeros(8), 0.0), (np.abs(rng.standard_normal(8)), 1.0)]
    for point, shift in points:
        found = certify_lasso(X, y, point, **given, intercept=shift if intercept else None)
        low, high = exact.value(point, shift if intercept else 0.0)
        assert found.objective[0] <= low
        assert high <= found.objective[1]
        assert Fraction(found.lower) <= best
        assert Fraction(found.gap) >= low - best
        assert found.upper <= found.objective[1]
        assert not (found.zero_features & (np.abs(b) > 1e-4)).any()
    narrow = certify_lasso(X, y, b, **given, intercept=b0 if intercept else None)
    assert narrow.relative_gap < 1e-6, narrow


@pytest.mark.parametrize("scale", [1.0, 2.0**-300, 2.0**300, 1e-6])
def test_the_paper_s_problem_without_coupling_is_a_lasso(scale):
    """F with lambda1 = 0 is ||y - X b||^2 + lambda2 ||b||_1; ball arithmetic bounds it in its own way."""
    rng = np.random.default_rng(7)
    X, o = rng.standard_normal((4, 9)), rng.standard_normal(9)
    known = enclose(Problem(X, o, lambda1=0.0, lambda2=0.7, lambda3=0.1))
    w = np.array([float(x) for x in known.exact.w]) if hasattr(known, "exact") else np.zeros(4)
    found = certify_lasso(
        X.T * scale, o * scale, w, 0.7 * scale * scale, convention="residual sum of squares"
    )
    assert found.lower <= known.upper * scale * scale * (1 + 1e-12)
    assert known.lower * scale * scale * (1 - 1e-12) <= found.upper
    assert found.certified, found


WEIGHTS = np.array([0.5, 1.0, 2.0, 0.25, 4.0, 1.0, 0.5, 2.0])


@pytest.mark.parametrize("name", ["celer", "skglm", "adelie", "residual sum of squares", "glmnet"])
def test_weights_of_columns_are_those_of_scaled_columns(name):
    """A weight is a power of two here, so that dividing the column by it gives the same problem."""
    X, y = data(0)
    scale = 8.0 / WEIGHTS.sum() if name == "glmnet" else 1.0
    convention = "residual sum of squares" if name.startswith("residual") else "scikit-learn"
    for b in (np.zeros(8), np.linspace(-1.0, 1.0, 8)):
        weighted = certify_lasso(X, y, b, 0.3, convention=name, weights=WEIGHTS)
        plain = certify_lasso(X / WEIGHTS, y, b * WEIGHTS, 0.3 * scale, convention=convention)
        assert weighted.lower == pytest.approx(plain.lower, rel=1e-12)
        assert weighted.objective == pytest.approx(plain.objective, rel=1e-12)


@pytest.mark.parametrize("name", ["celer", "skglm", "adelie", "group-lasso", "residual sum of squares"])
def test_weights_of_groups_are_in_the_order_of_the_labels(name):
    X, y = data(1)
    weights, b = np.array([0.5, 2.0, 1.0, 4.0]), np.linspace(-1.0, 1.0, 8)
    none = certify_lasso(X, y, b, 0.0, convention=name, groups=LABELS)
    some = certify_lasso(X, y, b, 0.3, convention=name, groups=LABELS, weights=weights)
    added = 0.3 * sum(w * np.linalg.norm(b[label == LABELS]) for label, w in enumerate(weights))
    assert some.objective[1] - none.objective[1] == pytest.approx(added, rel=1e-12)


ESTIMATORS = [
    Lasso(alpha=0.2, tol=1e-10),
    Lasso(alpha=0.2, tol=1e-10, fit_intercept=False, positive=True),
    LassoCV(cv=3, tol=1e-10),
    LassoLars(alpha=0.2),
    ElasticNet(alpha=0.2, l1_ratio=0.3, tol=1e-10),
    ElasticNetCV(l1_ratio=[0.5, 0.8], cv=3, tol=1e-10),
    Ridge(alpha=0.7),
    Ridge(alpha=0.7, fit_intercept=False),
]


@pytest.mark.parametrize("estimator", ESTIMATORS, ids=repr)
def test_a_fitted_estimator_is_judged_by_its_own_objective(estimator):
    X, y = data(3, n=40)
    found = certify(estimator.fit(X, y), X, y)
    assert found.relative_gap < 1e-7, found
    worse = estimator.fit(X, y)
    worse.coef_ = worse.coef_ + 0.1
    if not getattr(estimator, "positive", False):
        assert certify(worse, X, y).relative_gap > 1e-4


def test_an_early_stop_is_seen_whatever_the_package_says():
    """scikit-learn ends after its iterations with a warning alone."""
    X, y = data(4, n=60)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        estimator = Lasso(alpha=1e-3, max_iter=1).fit(X, y)
    found = certify(estimator, X, y)
    assert not found.certified
    assert found.relative_gap > 1e-3
    exact = fit("scikit-learn", X, y, 1e-3, 1.0, 0.0, False, False)
    b, b0 = exact.solved(True)
    assert Fraction(found.lower) <= exact.value(b, b0)[1] <= Fraction(found.upper)


def test_what_cannot_be_judged_is_refused():
    X, y = data(0)
    with pytest.raises(InputError, match=r"must be one of sklearn\.Lasso"):
        certify(LinearRegression().fit(X, y), X, y)
    with pytest.raises(InputError, match="must be fitted"):
        certify(Lasso(), X, y)
    with pytest.raises(InputError, match="convention"):
        certify_lasso(X, y, np.zeros(8), 0.1, convention="sklearn")
    with pytest.raises(ProblemError, match="groups must be left out"):
        certify_lasso(X, y, np.zeros(8), 0.1, groups=LABELS)
    with pytest.raises(ProblemError, match="l1_ratio must be between 0 and 1"):
        certify_lasso(X, y, np.zeros(8), 0.1, l1_ratio=1.5)
    with pytest.raises(PointError, match="coef must have shape"):
        certify_lasso(X, y, np.zeros(7), 0.1)
    with pytest.raises(PointError, match="must be finite"):
        certify_lasso(X, y, np.full(8, np.nan), 0.1)
    with pytest.raises(ProblemError, match="y must have shape"):
        certify_lasso(X, y[:-1], np.zeros(8), 0.1)
    with pytest.raises(ProblemError, match="must be finite"):
        certify_lasso(np.full_like(X, np.inf), y, np.zeros(8), 0.1)
    with pytest.raises(ProblemError, match="alpha"):
        certify_lasso(X, y, np.zeros(8), -1.0)
    with pytest.raises(ToleranceError):
        certify_lasso(X, y, np.zeros(8), 0.1, relative_tolerance=-1.0)
    with pytest.raises(TypeError, match="unexpected keyword argument 'l2'"):
        certify_lasso(X, y, np.zeros(8), 0.1, l2=1.0)


def test_a_negative_entry_where_none_is_allowed_has_no_finite_gap():
    X, y = data(0)
    found = certify_lasso(X, y, np.full(8, -0.1), 0.1, positive=True)
    assert found.gap == np.inf
    assert found.lower <= found.upper < np.inf
