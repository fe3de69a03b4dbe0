"""Fitted estimators of other packages: strengths, groups and conventions, read from their attributes."""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from convexperc.errors import InputError, is_integer
from convexperc.lasso.certificate import LassoCertificate
from convexperc.lasso.certifying import certify_lasso

Reading = dict[str, Any]
"""Arguments of `certify_lasso`."""


def certify(estimator: Any, X: Any, y: Any, *, at: Any = None, **options: Any) -> LassoCertificate:
    """Bound how far a fitted linear estimator is from the optimum of the objective that it documents.

    Parameters
    ----------
    estimator : fitted estimator
        Of scikit-learn: `Lasso`, `LassoCV`, `LassoLars`, `ElasticNet`, `ElasticNetCV`, `Ridge`; of celer:
        `Lasso`, `ElasticNet`, `GroupLasso`; of skglm: `Lasso`, `WeightedLasso`, `ElasticNet`, `GroupLasso`;
        of group-lasso: `GroupLasso`; of asgl: `Regressor` (``model="lm"``, ``penalization="lasso"``); of
        adelie: `GroupElasticNet` and the state that ``grpnet`` returns for a Gaussian response, whose weights
        of the samples are read as well; or of a class made from one of these.
    X : array_like or sparse matrix of SciPy (n, p)
    y : array_like (n,)
        The data that it was fitted to, as given to ``fit``.
    at : int, optional
        Which fit of a path, as adelie's; the last one without. Other estimators have one fit alone.
    **options
        ``sample_weight``, as given to ``fit``; ``relative_tolerance``, ``absolute_tolerance``; see
        `certify_lasso`.

    Returns
    -------
    LassoCertificate
        `assumed` is the objective that was judged.

    Raises
    ------
    InputError
        An estimator of another class, one that is not fitted, or one with an option under which its objective
        is another one.
    ProblemError, PointError, ToleranceError
        See `certify_lasso`.
    """
    for name in _names(type(estimator)):
        if name in READERS or name in PATHS:
            if name not in STATES and getattr(estimator, "coef_", None) is None:
                raise InputError(
                    "estimator", value=estimator, must="must be fitted", remedy="Call its fit first."
                )
            if name in PATHS:
                reading = PATHS[name](estimator, -1 if at is None else at)
            elif at is not None:
                raise InputError("at", value=at, must=f"must be left out: {name} keeps no path")
            else:
                reading = {"coef": estimator.coef_, **READERS[name](estimator, np.shape(X)[1])}
            return certify_lasso(X, y, **reading, **options)
    known = ", ".join([*READERS, *PATHS])
    raise InputError(
        "estimator", value=type(estimator).__name__, must=f"must be one of {known}",
        remedy="Call certify_lasso with its coefficients and its convention.",
    )  # fmt: skip


def _names(kind: type) -> Iterator[str]:
    """Package and class of an estimator and of what it is made from, the nearest first."""
    return (f"{each.__module__.partition('.')[0]}.{each.__qualname__}" for each in kind.__mro__)


def _refuse(estimator: Any, **others: Any) -> None:
    """Refuse an option under which the objective is another one."""
    for name, usual in others.items():
        if (value := getattr(estimator, name, usual)) != usual:
            must = f"must be {usual!r}: the objective is another one otherwise"
            raise InputError(f"{type(estimator).__name__}.{name}", value=value, must=must)


def _intercept(estimator: Any) -> Any:
    return np.reshape(estimator.intercept_, -1)[0] if estimator.fit_intercept else None


def _usual(estimator: Any, convention: str, **more: Any) -> Reading:
    alpha = getattr(estimator, "alpha_", None)
    return {
        "alpha": estimator.alpha if alpha is None else alpha,
        "convention": convention,
        "intercept": _intercept(estimator),
        "positive": bool(getattr(estimator, "positive", False)),
        **{name: value for name, value in more.items() if value is not None},
    }


def _lasso(convention: str) -> Callable[[Any, int], Reading]:
    def read(estimator: Any, p: int) -> Reading:
        return _usual(estimator, convention, weights=getattr(estimator, "weights", None))

    return read


def _elastic_net(convention: str) -> Callable[[Any, int], Reading]:
    def read(estimator: Any, p: int) -> Reading:
        ratio = getattr(estimator, "l1_ratio_", None)
        weights = getattr(estimator, "weights", None)
        return _usual(
            estimator, convention, weights=weights, l1_ratio=estimator.l1_ratio if ratio is None else ratio
        )

    return read


def _groups(convention: str) -> Callable[[Any, int], Reading]:
    def read(estimator: Any, p: int) -> Reading:
        labels = _labels(estimator.groups, p)
        return _usual(estimator, convention, groups=labels, weights=estimator.weights)

    return read


def _labels(groups: Any, p: int) -> list[int]:
    """Of each column its group, from one size, sizes, or lists of columns."""
    if isinstance(groups, int):
        return [column // groups for column in range(p)]
    labels = [0] * p
    first = 0
    for number, each in enumerate(groups):
        columns = range(first, first + each) if isinstance(each, (int, np.integer)) else each
        for column in columns:
            labels[column] = number
        first += len(columns)
    return labels


def _ridge(estimator: Any, p: int) -> Reading:
    return _usual(estimator, "scikit-learn ridge")


def _group_lasso(estimator: Any, p: int) -> Reading:
    _refuse(estimator, scale_reg="group_size", subsampling_scheme=None, old_regularisation=False)
    labels = np.arange(p) if estimator.groups is None else np.asarray(estimator.groups).reshape(-1)
    if (labels < 0).any():
        must, remedy = "must be at least 0: columns below are not penalised by group", "Call certify_lasso."
        raise InputError("GroupLasso.groups", value=estimator.groups, must=must, remedy=remedy)
    return {
        "alpha": estimator.group_reg,
        "l1_reg": estimator.l1_reg,
        "convention": "group-lasso",
        "groups": labels,
        "intercept": _intercept(estimator),
    }


def _asgl(estimator: Any, p: int) -> Reading:
    _refuse(estimator, model="lm")
    _refuse(estimator, penalization="lasso")
    return {"alpha": estimator.lambda1, "convention": "asgl", "intercept": _intercept(estimator)}


READERS: dict[str, Callable[[Any, int], Reading]] = {
    "sklearn.Lasso": _lasso("scikit-learn"),
    "sklearn.LassoCV": _lasso("scikit-learn"),
    "sklearn.LassoLars": _lasso("scikit-learn"),
    "sklearn.ElasticNet": _elastic_net("scikit-learn"),
    "sklearn.ElasticNetCV": _elastic_net("scikit-learn"),
    "sklearn.Ridge": _ridge,
    "celer.Lasso": _lasso("celer"),
    "celer.ElasticNet": _elastic_net("celer"),
    "celer.GroupLasso": _groups("celer"),
    "skglm.Lasso": _lasso("skglm"),
    "skglm.WeightedLasso": _lasso("skglm"),
    "skglm.ElasticNet": _elastic_net("skglm"),
    "skglm.GroupLasso": _groups("skglm"),
    "group_lasso.GroupLasso": _group_lasso,
    "asgl.Regressor": _asgl,
}
"""By package and class; celer's, which are made from scikit-learn's, come before these."""


def _adelie(state: Any, at: Any) -> Reading:
    """One fit of the path that a state of adelie holds; its weights add up to 1."""
    if any(each is not None for each in state.constraints):
        raise InputError("constraints", value="given", must="must be left out: the objective has none")
    steps = state.betas.shape[0]
    if not (is_integer(at) and -steps <= at < steps):
        raise InputError("at", value=at, must=f"must be the number of one of the {steps} fits of the path")
    weights = np.array(state.weights)
    sizes = np.array(state.group_sizes)
    return {
        "coef": np.asarray(state.betas[[at]].toarray()).reshape(-1),
        "alpha": float(state.lmdas[at]),
        "convention": "adelie",
        "l1_ratio": float(state.alpha),
        "groups": np.repeat(np.arange(sizes.size), sizes),
        "weights": np.array(state.penalty),
        "intercept": float(state.intercepts[at]) if state.intercept else None,
        **({} if (weights == weights[0]).all() else {"sample_weight": weights}),
    }


def _adelie_estimator(estimator: Any, at: Any) -> Reading:
    _refuse(estimator, family="gaussian")
    return _adelie(estimator.state_, at)


STATES = ("adelie.gaussian_naive_base",)
"""What is no estimator, but the result of a fit."""
PATHS: dict[str, Callable[[Any, Any], Reading]] = {
    "adelie.GroupElasticNet": _adelie_estimator,
    **dict.fromkeys(STATES, _adelie),
}
"""By package and class, what keeps several fits."""
