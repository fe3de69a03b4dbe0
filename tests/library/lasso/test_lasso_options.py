"""Sample weights, sparse X, columns without a penalty, and the paths of adelie."""

import warnings
from fractions import Fraction
from types import SimpleNamespace

import numpy as np
import pytest
from exact_fits import Fit
from scipy import sparse
from sklearn.linear_model import ElasticNet, Lasso, LinearRegression, Ridge

from convexperc.errors import InputError, ProblemError
from convexperc.lasso import certify, certify_lasso


def data(seed: int = 0, n: int = 20, p: int = 6):
    rng = np.random.default_rng(seed)
    X = rng.standard_normal((n, p))
    return X, X[:, :2].sum(axis=1) + 0.5 * rng.standard_normal(n) + 1.0, rng


WEIGHTED = [
    Lasso(alpha=0.2, tol=1e-12),
    Lasso(alpha=0.2, tol=1e-12, fit_intercept=False, positive=True),
    ElasticNet(alpha=0.2, l1_ratio=0.4, tol=1e-12),
    Ridge(alpha=0.7, tol=1e-12),
    Ridge(alpha=0.7, fit_intercept=False),
]


@pytest.mark.parametrize("scale", [1.0, 1e-150, 7e200])
@pytest.mark.parametrize("estimator", WEIGHTED, ids=repr)
def test_weighted_fits_of_scikit_learn_are_certified_for_their_weights_alone(estimator, scale):
    X, y, rng = data()
    weights = rng.choice([0.0, 0.5, 1.0, 4.0], y.size)
    ridge = isinstance(estimator, Ridge)
    estimator.fit(X, y, sample_weight=weights)
    used = weights if ridge else weights * scale  # a mean does not change with the scale of its weights
    found = certify(estimator, X, y, sample_weight=used)
    assert found.relative_gap < 1e-8, found
    assert "w_i" in found.assumed
    assert certify(estimator, X, y).relative_gap > 1e-4


@pytest.mark.parametrize("convention", ["scikit-learn", "skglm", "adelie", "scikit-learn ridge"])
def test_a_weight_is_a_number_of_repetitions(convention):
    X, y, rng = data(1)
    counts = rng.integers(0, 4, y.size)
    b = rng.standard_normal(6)
    one = certify_lasso(X, y, b, 0.2, convention=convention, intercept=0.1, sample_weight=counts)
    many = certify_lasso(
        np.repeat(X, counts, axis=0), np.repeat(y, counts), b, 0.2, convention=convention, intercept=0.1
    )
    assert one.objective == pytest.approx(many.objective, rel=1e-12)
    assert one.lower == pytest.approx(many.lower, rel=1e-11)
    assert (one.zero_features == many.zero_features).all()


@pytest.mark.parametrize(
    "bad", [np.ones(3), -np.ones(20), np.zeros(20), np.full(20, np.nan), np.r_[1e-200, np.ones(19)], "equal"]
)
def test_sample_weights_that_cannot_be_used_are_refused(bad):
    X, y, _ = data()
    with pytest.raises(ProblemError, match="sample_weight"):
        certify_lasso(X, y, np.zeros(6), 0.1, sample_weight=bad)


def test_an_objective_without_sample_weights_takes_none():
    X, y, _ = data()
    with pytest.raises(ProblemError, match="sample_weight must be left out"):
        certify_lasso(X, y, np.zeros(6), 0.1, convention="celer", sample_weight=np.ones(20))


FORMATS = ["csr", "csc", "coo", "lil", "dok", "bsr", "dia"]


@pytest.mark.parametrize("weights", [None, np.linspace(0.0, 2.0, 20)])
@pytest.mark.parametrize("form", FORMATS)
def test_a_sparse_matrix_has_the_bounds_of_the_dense_one(form, weights):
    X, y, rng = data(2)
    X[rng.random(X.shape) < 0.6] = 0.0
    X[:, 4] = 0.0
    b = rng.standard_normal(6) * (rng.random(6) < 0.5)
    for alpha, scale in ((0.2, 1.0), (0.0, 1.0), (0.2e-120, 1e-120)):
        options = {"intercept": 0.3, "sample_weight": weights}
        dense = certify_lasso(X * scale, y, b / scale, alpha, **options)
        for made in (sparse.csr_matrix, sparse.csr_array):
            found = certify_lasso(made(X * scale).asformat(form), y, b / scale, alpha, **options)
            assert found.lower == pytest.approx(dense.lower, rel=1e-11)
            assert found.upper == pytest.approx(dense.upper, rel=1e-11)
            assert (found.zero_features == dense.zero_features).all()


def test_a_large_sparse_fit_is_never_made_dense():
    """Dense, X would take 16 GB."""
    rng = np.random.default_rng(3)
    X = sparse.random(20_000, 100_000, density=1e-5, format="csc", random_state=rng)
    y = np.asarray(X @ rng.standard_normal(100_000)) + 0.1 * rng.standard_normal(20_000)
    estimator = Lasso(alpha=1e-4, tol=1e-10).fit(X, y)
    found = certify(estimator, X, y)
    assert found.relative_gap < 1e-6, found
    assert found.zero_features.sum() > 50_000


def test_entries_in_several_parts_are_refused():
    """0.1 + 0.2 is no float64: which matrix is meant is not known."""
    parts = sparse.coo_array(([0.1, 0.2, 1.0], ([0, 0, 1], [0, 0, 1])), shape=(2, 2))
    rows = sparse.csr_array(
        (np.array([0.1, 0.2, 1.0]), np.array([0, 0, 1]), np.array([0, 2, 3])), shape=(2, 2)
    )
    for X in (parts, rows):
        with pytest.raises(ProblemError, match="each entry once"):
            certify_lasso(X, [1.0, 2.0], np.zeros(2), 0.1)
    with pytest.raises(ProblemError, match=r"X\.data"):
        certify_lasso(sparse.csr_array([[np.inf, 1.0]]), [1.0], np.zeros(2), 0.1)
    with pytest.raises(ProblemError, match="a row for each sample"):
        certify_lasso(sparse.csr_array((0, 3)), np.zeros(0), np.zeros(3), 0.1)


@pytest.mark.parametrize("positive", [False, True])
@pytest.mark.parametrize("intercept", [False, True])
@pytest.mark.parametrize("ratio", [1.0, 0.5])
def test_columns_of_weight_0_have_a_bound_that_cvxpy_attains(intercept, ratio, positive):
    """Where b >= 0 one of them is 0 at the optimum."""
    import cvxpy as cp  # noqa: PLC0415

    X, y, _ = data(4)
    weights = np.array([0.0, 1.0, 2.0, 0.0, 1.0, 0.5])
    b, b0 = cp.Variable(6), cp.Variable()
    loss = cp.sum_squares(y - X @ b - b0) / 40
    penalty = weights @ cp.abs(b) * ratio + (1 - ratio) / 2 * (weights @ cp.square(b))
    problem = cp.Problem(cp.Minimize(loss + 0.3 * penalty), [b0 == 0] * (not intercept) + [b >= 0] * positive)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        problem.solve(solver=cp.CLARABEL, tol_gap_abs=1e-12, tol_gap_rel=1e-12, tol_feas=1e-12)
    point = np.maximum(b.value, 0.0) if positive else b.value
    found = certify_lasso(
        X, y, point, 0.3, convention="celer", weights=weights, l1_ratio=ratio, positive=positive,
        intercept=float(b0.value) if intercept else None,
    )  # fmt: skip
    assert found.lower <= problem.value * (1 + 1e-9)
    assert found.relative_gap < 1e-6, found
    assert (np.abs(point)[found.zero_features] < 1e-6).all()


def test_least_squares_are_certified_too():
    """alpha = 0: t is the residual, orthogonal to every column; the exact optimum is that of fractions."""
    X, y, _ = data(5)
    estimator = LinearRegression(fit_intercept=False).fit(X, y)
    found = certify_lasso(X, y, estimator.coef_, 0.0)
    assert found.relative_gap < 1e-12, found
    exact = Fit(X, y, Fraction(1, 20), Fraction(0), {}, Fraction(0))
    assert Fraction(found.lower) <= exact.value(estimator.coef_, 0.0)[1]
    worse = certify_lasso(X, y, estimator.coef_ + 0.1, 0.0)
    assert worse.lower == pytest.approx(found.lower, rel=1e-9)
    assert worse.relative_gap > 1e-3


def test_columns_without_a_penalty_that_repeat_one_another_are_seen_through():
    X, y, _ = data(6)
    twice = np.column_stack([X, X[:, 0], -2.0 * X[:, 1], np.zeros(20)])
    once = certify_lasso(X, y, np.zeros(6), 0.0).lower
    assert once > 0.0
    assert certify_lasso(twice, y, np.zeros(9), 0.0).lower == pytest.approx(once, rel=1e-12)
    constant = certify_lasso(np.column_stack([X, np.full(20, 0.7)]), y, np.zeros(7), 0.0, intercept=0.0)
    assert constant.lower == pytest.approx(
        certify_lasso(X, y, np.zeros(6), 0.0, intercept=0.0).lower, rel=1e-12
    )


@pytest.mark.parametrize("intercept", [None, 0.0])
def test_where_dependence_cannot_be_told_there_is_no_bound_and_the_method_says_so(intercept):
    """A third column that is the sum of two, up to rounding: whether it adds a dimension is not known."""
    X, y, _ = data(7)
    X[:, 2] = X[:, 0] / 3.0 + X[:, 1] / 7.0
    found = certify_lasso(X, y, np.zeros(6), 0.0, intercept=intercept)
    assert (found.lower, found.certified) == (0.0, False)
    assert "depend on one another" in found.method
    others = certify_lasso(
        X,
        y,
        np.zeros(6),
        0.1,
        convention="celer",
        weights=[0.0, 0.0, 1.0, 1.0, 1.0, 1.0],
        intercept=intercept,
    )
    assert others.lower > 0.0


def adelie_state(**changes):
    """The attributes of a state of adelie, and the class by which it is known."""
    fields = {
        "betas": sparse.csr_array([[0.0] * 6, [1.0, 0.5, 0.0, 0.0, 0.0, 0.0]]),
        "intercepts": np.array([1.0, 0.9]), "lmdas": np.array([0.3, 0.1]), "alpha": 0.7,
        "penalty": np.array([1.0, 0.5, 2.0]),
        "groups": np.array([0, 2, 4]), "group_sizes": np.array([2, 2, 2]), "intercept": True,
        "constraints": [None] * 3, "weights": np.full(20, 1 / 20),
    }  # fmt: skip
    kind = type("gaussian_naive_base", (SimpleNamespace,), {"__module__": "adelie.state"})
    return kind(**fields | changes)


@pytest.mark.parametrize("weighted", [False, True])
def test_each_fit_of_an_adelie_path_is_judged_by_its_own_strength(weighted):
    X, y, rng = data(8)
    weights = rng.random(20) if weighted else np.full(20, 1 / 20)
    state = adelie_state(weights=weights / weights.sum())
    for at, alpha, b, b0 in ((0, 0.3, np.zeros(6), 1.0), (1, 0.1, [1.0, 0.5, 0, 0, 0, 0], 0.9)):
        found = certify(state, X, y, at=at)
        r = y - X @ b - b0
        norms = [np.linalg.norm(b[k : k + 2]) for k in (0, 2, 4)]
        penalty = sum(v * (0.7 * s + 0.15 * s * s) for v, s in zip(state.penalty, norms, strict=True))
        assert found.objective[1] == pytest.approx(state.weights @ r**2 / 2 + alpha * penalty, rel=1e-12)
    assert certify(state, X, y).objective == found.objective
    kind = type("GroupElasticNet", (SimpleNamespace,), {"__module__": "adelie.sklearn"})
    estimator = kind(state_=state, coef_=state.betas, family="gaussian")
    assert certify(estimator, X, y).objective == found.objective


def test_what_adelie_has_and_the_objective_has_not_is_refused():
    X, y, _ = data(8)
    with pytest.raises(InputError, match="constraints"):
        certify(adelie_state(constraints=[None, object(), None]), X, y)
    for at in (2, -3, 0.5):
        with pytest.raises(InputError, match="one of the 2 fits"):
            certify(adelie_state(), X, y, at=at)
    kind = type("GroupElasticNet", (SimpleNamespace,), {"__module__": "adelie.sklearn"})
    with pytest.raises(InputError, match="family"):
        certify(kind(state_=adelie_state(), coef_=1, family="poisson"), X, y)
    with pytest.raises(InputError, match="keeps no path"):
        certify(Lasso().fit(X, y), X, y, at=0)


def test_group_lasso_s_weights_are_those_of_groups():
    X, y, _ = data()
    with pytest.raises(ProblemError, match="weights must be left out where there are no groups"):
        certify_lasso(X, y, np.zeros(6), 0.1, convention="group-lasso", weights=np.ones(6))


@pytest.mark.parametrize("scale", [1e-200, 1e200])
def test_data_of_any_scale_are_judged(scale):
    """Columns of zeros, or entries whose squares leave float64, change nothing."""
    X, y, _ = data(9)
    X[:, 3] = 0.0
    plain = certify_lasso(X, y, np.zeros(6), 0.2)
    found = certify_lasso(X * scale, y, np.zeros(6), 0.2 * scale)
    assert found.lower == pytest.approx(plain.lower, rel=1e-9)
    assert certify_lasso(np.zeros((3, 2)), np.ones(3), np.zeros(2), 0.2).certified
