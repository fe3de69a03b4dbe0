"""What users of other packages reported of their fits, judged: each with the verdict of the certificate."""

import warnings

import numpy as np
import pytest
from sklearn.linear_model import ElasticNet, Lasso

from convexperc.lasso import certify, certify_lasso


def test_scikit_learn_27928_a_tiny_strength_ends_far_from_the_optimum_without_a_warning():
    """256 samples of 512 columns, no noise, alpha = 0.01/256, the usual tol.

    The report is of several targets at once; with its seed one target shows the same.
    """
    rng = np.random.RandomState(114514)
    X, u = rng.randn(256, 512), np.zeros(512)
    u[rng.choice(512, 25, replace=False)] = rng.randn(25)
    y = X @ u
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        estimator = Lasso(alpha=0.01 / 256, fit_intercept=False).fit(X, y)
    found = certify(estimator, X, y)
    best = certify_lasso(X, y, u, 0.01 / 256)  # the point that made the data: its value is an upper bound
    assert not found.certified
    assert found.objective[0] > 3.0 * best.upper, "more than three times the optimum, by proof"
    assert found.lower <= best.upper


X_173 = np.zeros((20, 1))
X_173[[7, 10, 13, 16, 19], 0] = [0.001, 0.015, 0.046, 0.061, 0.062]
Y_173 = np.array(
    [0.008, 0.0, 0.001, 0.02, 0.0, 0.001, 0.024, 0.001, 0.001, 0.023, 0.006, 0.0, 0.011, 0.032, 0.0, 0.002,
     0.056, 0.001, 0.001, 0.062]
)  # fmt: skip


def test_celer_173_the_zero_that_was_returned_is_within_its_tolerance_and_no_optimum():
    """Data so small that a gap of 1e-4 is all of the objective; scikit-learn's 0.55 is the optimum."""
    estimator = Lasso(alpha=1e-4).fit(X_173, Y_173)
    right = certify(estimator, X_173, Y_173)
    assert estimator.coef_[0] == pytest.approx(0.55, abs=0.005)
    assert right.certified
    zero = certify_lasso(X_173, Y_173, [0.0], 1e-4, convention="celer", intercept=Y_173.mean())
    assert not zero.certified
    assert zero.gap < 1e-4, "which is why it was returned"
    assert zero.objective[0] > 1.2 * right.upper, "by proof"
    assert not right.zero_features[0]


def test_group_lasso_18_an_answer_that_diverged_is_bounded_and_refused():
    """A design whose columns are nearly parallel, and an answer of the reported length, 3.6e140."""
    rng = np.random.default_rng(18)
    X = np.abs(rng.standard_normal((72, 200))) + 3.0
    X /= np.linalg.norm(X, axis=0)
    y = X @ rng.standard_normal(200)
    y /= np.linalg.norm(y)
    alpha = np.abs(X.T @ y).max() / 72 / 2
    b = rng.standard_normal(200)
    found = certify_lasso(
        X, y, b * (3.6e140 / np.linalg.norm(b)), alpha, convention="group-lasso", groups=range(200)
    )
    best = certify(Lasso(alpha=alpha, tol=1e-12, fit_intercept=False).fit(X, y), X, y)
    assert not found.certified
    assert found.objective[0] > 1e270
    assert found.lower <= best.upper <= found.upper * (1 + 1e-12)


def test_group_lasso_23_the_strength_is_that_of_an_objective_with_alpha_doubled():
    """Half the least strength that gives zeros gave zeros: the optimum for twice the strength."""
    rng = np.random.default_rng(23)
    X = rng.standard_normal((60, 30))
    y = X[:, :4].sum(axis=1) + 0.5 * rng.standard_normal(60)
    X /= np.linalg.norm(X, axis=0)
    alpha = np.abs(X.T @ y).max() / 60 / 2
    zero = {"convention": "group-lasso", "groups": range(30)}
    documented = certify_lasso(X, y, np.zeros(30), alpha, **zero)
    solved = certify_lasso(X, y, np.zeros(30), 2 * alpha, **zero)
    assert solved.certified, "zeros are the optimum for twice the strength"
    right = Lasso(alpha=alpha, tol=1e-12, fit_intercept=False).fit(X, y)
    assert certify(right, X, y).certified
    assert documented.objective[0] > 1.05 * certify(right, X, y).upper, "and not for the one asked for"


def test_pyglmnet_395_of_three_answers_the_certificate_tells_the_optimum():
    """Its data by the same recipe; two solvers of one package differed from each other and from a third."""
    from sklearn.datasets import make_regression  # noqa: PLC0415

    X, y = make_regression(n_samples=200, n_features=20, noise=1, n_informative=10, random_state=1)
    right = ElasticNet(alpha=0.9, l1_ratio=0.5).fit(X, y)
    assert certify(right, X, y).certified
    options = {"convention": "glmnet", "l1_ratio": 0.5}
    same = certify_lasso(X, y, right.coef_, 0.9, intercept=right.intercept_, **options)
    assert same.certified
    early = descended(X - X.mean(axis=0), y - y.mean(), 0.9, 0.5, steps=20)
    centre = float(y.mean() - X.mean(axis=0) @ early)
    other = certify_lasso(X, y, early, 0.9, intercept=centre, **options)
    assert np.linalg.norm(early - right.coef_) > 1.0
    assert not other.certified
    assert other.objective[0] > same.upper * (1 + 1e-4), "by proof"


def descended(X, y, alpha, ratio, steps):
    """Proximal gradient steps that stop early, as a batch gradient with a loose tolerance does."""
    b, rate = np.zeros(X.shape[1]), len(y) / np.linalg.norm(X, 2) ** 2 / 10
    for _ in range(steps):
        moved = b + rate * X.T @ (y - X @ b) / len(y)
        b = np.sign(moved) * np.maximum(np.abs(moved) - rate * alpha * ratio, 0.0)
        b = b / (1.0 + rate * alpha * (1 - ratio))
    return b


def test_cuml_6759_small_steps_are_no_small_gap():
    """Coordinate descent that ends when no coefficient moves by 1e-3 of the largest; correlated columns."""
    rng = np.random.default_rng(6759)
    X = rng.standard_normal((100, 1)) + 0.1 * rng.standard_normal((100, 40))
    y = X @ rng.standard_normal(40) + 0.1 * rng.standard_normal(100)
    alpha, squares = 1e-4, (X * X).sum(axis=0)
    b, r, still = np.zeros(40), y.copy(), False
    for _ in range(10_000):
        before = b.copy()
        for j in range(40):
            pull = X[:, j] @ r + squares[j] * b[j]
            new = np.sign(pull) * max(abs(pull) - 100 * alpha, 0.0) / squares[j]
            r += X[:, j] * (b[j] - new)
            b[j] = new
        still = bool(np.abs(b - before).max() <= 1e-3 * np.abs(b).max())
        if still:
            break
    assert still, "it ended by its own rule"
    found = certify_lasso(X, y, b, alpha)
    best = certify(Lasso(alpha=alpha, tol=1e-10, max_iter=500_000, fit_intercept=False).fit(X, y), X, y)
    assert best.relative_gap < 1e-3
    assert not found.certified
    assert found.objective[0] > 1.001 * best.upper, "by proof"
