"""Reweighted programs in installed packages, each against the objective that it states.

Each case says what the package promises, and is judged by that; where the promise can be read in two ways,
both are cases. A package that is not installed is left out.
"""

import importlib
import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any

import numpy as np
from numpy.typing import NDArray

from convexperc.errors import installed
from verification.reweighted.objectives.objective import Objective, each_loss, norm, norm1, squares, variable
from verification.reweighted.programs.judging import ProgramAnswers, judge_program
from verification.reweighted.programs.questions import Data, Question, all_questions, as_given, other_units
from verification.reweighted.programs.verdicts import Rule

Array = NDArray[Any]

TRIPLES = ({"y": [0.0, 0.0, 1.0]}, {"y": [0.0, 1.0, 5.0]})
"""With the medians 0 and 1."""

HUBER = "r**2/2 if abs(r) <= 1.345 else 1.345*abs(r) - 1.345**2/2"
"""The loss of statsmodels' HuberT with its default width."""


@dataclass(frozen=True)
class Case:
    """A program of a package, and what it promises.

    Attributes
    ----------
    distribution, module : str
        Names by which it is installed and imported.
    program : str
        What is called.
    promise : str
        What the rule is taken from.
    rule : Rule
    call, build : functions of the data
    inputs : sequence of mappings
    questions : sequence of Question
    """

    distribution: str
    module: str
    program: str
    promise: str
    rule: Rule
    call: Callable[..., Any]
    build: Callable[..., Objective]
    inputs: Sequence[Data]
    questions: Sequence[Question]


@dataclass(frozen=True)
class Judged:
    """What was found of a case, in the version that is installed."""

    case: Case
    version: str
    answers: ProgramAnswers


def judge_packages(chosen: Sequence[Case] | None = None) -> Iterator[Judged]:
    """Judge the cases whose packages are installed, one after the other."""
    for case in cases() if chosen is None else chosen:
        if installed(case.module):
            name = f"{case.distribution} {version(case.distribution)}, {case.program}"
            found = judge_program(
                case.call,
                case.build,
                inputs=case.inputs,
                questions=case.questions,
                rule=case.rule,
                name=name,
            )
            yield Judged(case, version(case.distribution), found)


def cases() -> tuple[Case, ...]:
    """All cases; those that are known to be right stand beside the others."""
    return (*_statsmodels(), *_geometric_medians(), *_feature_selections(), *_exact_programs())


def median(y: Array) -> Objective:
    """Sum of |y_i - m|."""
    return norm1(np.ones((len(y), 1)) @ variable("m", 1) - y)


def quantiles(X: Array, y: Array, q: float = 0.5) -> Objective:
    """Check loss: sum of q r for r = y_i - x_i'b > 0 and (q - 1) r for r < 0."""
    formula = f"{q!r}*r if r >= 0 else ({q!r} - 1)*r"
    return each_loss(y - X @ variable("b", X.shape[1]), formula, "1/abs(r)")


def geometric_median(points: Array) -> Objective:
    """Sum of ||p_i - m||."""
    m = variable("m", points.shape[1])
    return sum((norm(m - p) for p in points), Objective(()))


def huber_regression(X: Array, y: Array) -> Objective:
    """Huber's loss of the residuals in units of the scale of the least squares fit, which stays."""
    return each_loss((X @ variable("b", X.shape[1]) - y) * (1 / deviation(X, y)), HUBER, "1")


def deviation(X: Array, y: Array) -> float:
    """Median of the absolute residuals of least squares, by that of a normal variable."""
    rest = y - X @ np.linalg.lstsq(X, y, rcond=None)[0]
    return float(np.median(np.abs(rest)) / 0.6744897501960817)


def row_norms(X: Array, labels: Array, gamma: float) -> Objective:
    """Norms of the rows of X W - Y and gamma times those of W; each row of Y is -1, but 1 at its label."""
    Y = np.where(labels[:, None] == np.unique(labels), 1.0, -1.0)
    W = variable("W", X.shape[1], Y.shape[1])
    residual = X @ W - Y
    loss = sum((norm(residual[i]) for i in range(len(X))), Objective(()))
    return loss + sum((norm(W[j]) for j in range(X.shape[1])), Objective(())) * gamma


def lasso(X: Array, y: Array, penalty: float) -> Objective:
    """||X b - y||^2/2 + penalty ||b||_1."""
    b = variable("b", X.shape[1])
    return squares(X @ b - y) * 0.5 + norm1(b) * penalty


def _regression(seed: int, n: int, p: int) -> dict[str, Any]:
    """Small integers: an intercept, regressors, and y with a few outliers."""
    rng = np.random.default_rng(seed)
    X = np.column_stack([np.ones(n), rng.integers(-5, 6, (n, p - 1))]).astype(float)
    return {"X": X, "y": X.sum(axis=1) + rng.integers(-3, 4, n) + 20.0 * (np.arange(n) % 7 == 3)}


def _statsmodels() -> Iterator[Case]:
    def medians(y: Array, **options: Any) -> Any:
        model = importlib.import_module("statsmodels.regression.quantile_regression")
        return model.QuantReg(y, np.ones(len(y))).fit(q=0.5, **options).params

    def fine_medians(y: Array) -> Any:
        return medians(y, p_tol=1e-15)

    def regressions(X: Array, y: Array, q: float = 0.5) -> Any:
        model = importlib.import_module("statsmodels.regression.quantile_regression")
        return model.QuantReg(y, X).fit(q=q).params

    def robust(X: Array, y: Array, **options: Any) -> Any:
        api, how = (
            importlib.import_module("statsmodels.api"),
            {"update_scale": False, "maxiter": 500} | options,
        )
        return api.RLM(y, X, M=api.robust.norms.HuberT()).fit(**how).params

    def robust_by_coefficients(X: Array, y: Array) -> Any:
        return robust(X, y, conv="coefs", tol=1e-16)

    alone = (as_given(), other_units({"y": 1}))
    whole = all_questions(rows=("X", "y"), powers={"y": 1})
    relative = "an answer to 1e-6, as p_tol = 1e-6 suggests, in whatever unit y has"
    absolute = "p_tol = 1e-6 read as an error of each parameter in the unit of y: 3e-6 for the sum of three"
    asked = "p_tol = 1e-15 asked for, read as an error of the parameter in the unit of y"
    named = ("statsmodels", "statsmodels")
    quantreg = "QuantReg(y, ones).fit(q=0.5)"
    yield Case(*named, quantreg, relative, Rule(1e-6), medians, median, TRIPLES, alone)
    yield Case(*named, quantreg, absolute, Rule(0.0, 3e-6), medians, median, TRIPLES, alone)
    fine = "QuantReg(y, ones).fit(q=0.5, p_tol=1e-15)"
    yield Case(*named, fine, asked, Rule(1e-6, 3e-15), fine_medians, median, TRIPLES, alone)
    data = [_regression(1, 12, 2), _regression(2, 15, 3)]
    title = "QuantReg(y, X).fit(q=0.5)"
    yield Case(*named, title, relative, Rule(1e-6), regressions, quantiles, data, whole)
    quarters = [{**each, "q": 0.25} for each in data]
    title = "QuantReg(y, X).fit(q=0.25)"
    yield Case(*named, title, relative, Rule(1e-6), regressions, quantiles, quarters, whole)
    title = "RLM(y, X, M=HuberT()).fit(update_scale=False)"
    promise = "tol = 1e-8 for the un-normalized log-likelihood, which has no unit: 1e-6 allowed"
    yield Case(*named, title, promise, Rule(1e-6), robust, huber_regression, data, whole)
    title = 'RLM(y, X, M=HuberT()).fit(update_scale=False, conv="coefs", tol=1e-16)'
    promise = "coefficients until they stay"
    yield Case(*named, title, promise, Rule(1e-6), robust_by_coefficients, huber_regression, data, whole)


def _geometric_medians() -> Iterator[Case]:
    def call(points: Array) -> Any:
        found = importlib.import_module("geom_median.numpy").compute_geometric_median(points)
        return found.median

    rng = np.random.default_rng(3)
    inputs: list[Data] = [
        {"points": [[0.0, 0.0], [0.0, 0.0], [0.0, 0.0], [3.0, 0.0], [0.0, 4.0]]},
        {"points": rng.integers(-9, 10, (7, 2)).astype(float)},
    ]
    named = ("geom_median", "geom_median", "compute_geometric_median(points)")
    asked = (as_given(), other_units({"points": 1}))
    relative = "an answer to 1e-6 in whatever unit the points have, as ftol = 1e-20 suggests"
    yield Case(*named, relative, Rule(1e-6), call, geometric_median, inputs, asked)
    smoothed = "eps = 1e-6, documented as a smoothing parameter: up to eps/2 for each of at most 7 points"
    yield Case(*named, smoothed, Rule(1e-6, 3.5e-6), call, geometric_median, inputs, asked)


def _feature_selections() -> Iterator[Case]:
    def call(X: Array, labels: Array, gamma: float) -> Any:
        rfs = importlib.import_module("skfeature.function.sparse_learning_based.RFS").rfs
        return rfs(X, labels, mode="raw", gamma=gamma)

    rng = np.random.default_rng(4)
    inputs = [{"X": rng.normal(size=(12, 4)), "labels": np.arange(12) % 3, "gamma": 0.5}]
    asked = (as_given(), other_units({"X": 1, "gamma": 1}))
    named = ("skfeature-chappers", "skfeature", 'RFS.rfs(X, labels, mode="raw", gamma=gamma)')
    for tolerance in (1e-6, 1e-2):
        promise = f"none; {tolerance:g} relative is tried"
        yield Case(*named, promise, Rule(tolerance), call, row_norms, inputs, asked)


def _exact_programs() -> Iterator[Case]:
    def by_numpy(y: Array) -> Any:
        return np.median(y)

    def by_linprog(X: Array, y: Array, q: float = 0.5) -> Any:
        optimize = importlib.import_module("scipy.optimize")
        n, p = X.shape
        unit = float(np.max(np.abs(y))) or 1.0
        costs = np.concatenate([np.zeros(p), np.full(n, q), np.full(n, 1 - q)])
        equations = np.hstack([X, np.eye(n), -np.eye(n)])
        bounds = [(None, None)] * p + [(0, None)] * (2 * n)
        return (
            optimize.linprog(costs, A_eq=equations, b_eq=y / unit, bounds=bounds, method="highs").x[:p] * unit
        )

    def by_sklearn(X: Array, y: Array, penalty: float) -> Any:
        linear = importlib.import_module("sklearn.linear_model")
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            model = linear.Lasso(alpha=penalty / len(y), fit_intercept=False, tol=1e-12, max_iter=100_000)
            return model.fit(X, y).coef_

    data = [_regression(1, 12, 2), _regression(2, 15, 3)]
    yield Case(
        "numpy", "numpy", "median(y)", "exact", Rule(1e-12), by_numpy, median, TRIPLES,
        all_questions(rows=("y",), powers={"y": 1}),
    )  # fmt: skip
    yield Case(
        "scipy", "scipy", "optimize.linprog, y divided by its largest entry", "1e-7 of HiGHS", Rule(1e-6),
        by_linprog, quantiles, data, all_questions(rows=("X", "y"), columns=("X",), powers={"y": 1}),
    )  # fmt: skip
    yield Case(
        "scikit-learn", "sklearn", "Lasso(tol=1e-12)", "a duality gap of 1e-12 ||y||^2", Rule(1e-6),
        by_sklearn, lasso, [{**each, "penalty": 3.0} for each in data],
        all_questions(rows=("X", "y"), columns=("X",), powers={"y": 1, "penalty": 1}),
    )  # fmt: skip
