"""Certify an answer to a lasso, group lasso, sparse group lasso, elastic net or ridge fit, from anywhere."""

from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from convexperc.certificate.tolerances import ABSOLUTE, RELATIVE, Tolerances
from convexperc.errors import ProblemError
from convexperc.lasso.certificate import LassoCertificate, certificate
from convexperc.lasso.conventions import Given, check_taken, convention_of
from convexperc.lasso.objective import LeastSquares, column_groups
from convexperc.problem.arrays import nonnegative_number, point_entries, real_array
from convexperc.problem.conversion import real_source

DENSE = "must be a dense array of real numbers, a row for each sample and a column for each feature"


def certify_lasso(
    X: Any,
    y: Any,
    coef: Any,
    alpha: Any,
    *,
    intercept: Any = None,
    convention: str = "scikit-learn",
    groups: Any = None,
    weights: Any = None,
    positive: bool = False,
    **more: Any,
) -> LassoCertificate:
    """Bound the optimum of a penalised least-squares fit, and how far an answer is from it.

    The bounds hold for the data as given and the objective as written, rounding included, wherever the answer
    comes from; no status of a solver is looked at.

    Parameters
    ----------
    X : array_like (n, p)
        A row for each sample, a column for each feature.
    y : array_like (n,)
    coef : array_like (p,), (1, p) or (p, 1)
        The answer b; it may be of float32.
    alpha : float
        The strength of the penalty, >= 0: what the package calls alpha, lambda, lambda1 or group_reg.
    intercept : float, optional
        The answer's b0. Without, the model has no intercept; with, the least value over all b0 is bounded.
    convention : str
        Whose objective it is, a key of `CONVENTIONS`: ``"scikit-learn"``, ``"scikit-learn ridge"``,
        ``"glmnet"``, ``"celer"``, ``"skglm"``, ``"adelie"``, ``"asgl"``, ``"group-lasso"`` or ``"residual sum
        of squares"``.
    groups : sequence of p labels, optional
        Which group each column belongs to; equal labels, one group.
    weights : array_like, optional
        One for each group, in the order of the sorted labels, or without groups for each column; >= 0.
    positive : bool
        Whether b >= 0 is asked for.
    **more
        ``l1_ratio`` (1 by default) and ``l1_reg`` (0 by default), where the convention has them; and
        ``relative_tolerance``, ``absolute_tolerance``: see `LassoCertificate.certified`.

    Returns
    -------
    LassoCertificate

    Raises
    ------
    ProblemError
        Data that are not finite real numbers, of other shapes, or what the convention does not have.
    PointError
        An answer that is not finite, or of another shape.
    InputError
        There is no such convention.
    ToleranceError
        A tolerance that is not a finite number >= 0.

    Notes
    -----
    Where nothing penalises a column but the loss, no dual point is feasible in general, and the lower bound
    may be 0. See `convexperc.lasso.certificate` for the bounds.
    """
    options = _options(more)
    tolerances = Tolerances(options.pop("relative_tolerance"), options.pop("absolute_tolerance"))
    chosen = convention_of(convention)
    check_taken(
        chosen,
        groups=groups is not None,
        weights=weights is not None,
        **{name: name in more for name in options},
    )
    matrix = data_matrix(X)
    n, p = matrix.shape
    target = real_array(_column(y), "y", 1)
    if target.shape != (n,):
        raise ProblemError("y", value=target.shape, must=f"must have shape ({n},), as X has {n} rows")
    parts = None if groups is None else column_groups(groups, p)
    given = Given(
        p,
        Fraction(nonnegative_number(alpha, "alpha")),
        _ratio(options["l1_ratio"]),
        Fraction(nonnegative_number(options["l1_reg"], "l1_reg")),
        parts,
        _weights(weights, p if parts is None else parts.starts.size),
    )
    l1, group, ridge = chosen.penalties(given)
    if type(positive) is not bool:
        raise ProblemError("positive", value=positive, must="must be True or False")
    fit = LeastSquares(
        matrix, target, chosen.loss(n), l1, group, ridge, None if group.zero else parts,
        intercept is not None, positive,
    )  # fmt: skip
    answer = point_entries(_column(coef), p, "coef", finite=True)
    b0 = (
        0.0
        if intercept is None
        else float(point_entries(np.reshape(intercept, -1), 1, "intercept", finite=True)[0])
    )
    formula = chosen.formula if groups is None else chosen.grouped
    if intercept is None:
        formula = formula.replace(" - b0", "")
    return certificate(fit, answer, b0, tolerances, formula + (", b >= 0" if positive else ""))


def _options(more: dict[str, Any]) -> dict[str, Any]:
    defaults = {
        "l1_ratio": 1.0,
        "l1_reg": 0.0,
        "relative_tolerance": RELATIVE,
        "absolute_tolerance": ABSOLUTE,
    }
    for name in more:
        if name not in defaults:
            known = ", ".join(defaults)
            unknown = f"certify_lasso() got an unexpected keyword argument {name!r}"
            raise TypeError(f"{unknown}; further options are {known}")
    return defaults | more


def data_matrix(X: Any) -> NDArray[np.float64]:
    """X as float64, without a copy where it is."""
    if hasattr(X, "toarray"):
        raise ProblemError("X", value=type(X).__name__, must=DENSE, remedy="Pass X.toarray().")
    source = real_source(X, "X", ProblemError)
    if source.ndim != 2 or 0 in source.shape:
        raise ProblemError("X", value=source.shape, must=DENSE)
    if source.dtype == np.float64 and np.isfinite(source).all():
        return source
    return real_array(source, "X", 2)  # converts it, or says which entry is not finite


def _column(values: Any) -> Any:
    """A row or a column of numbers as a vector, as packages give them."""
    shape = np.shape(values)
    return np.asarray(values).reshape(-1) if len(shape) == 2 and 1 in shape else values


def _ratio(value: Any) -> Fraction:
    number = nonnegative_number(value, "l1_ratio")
    if number > 1.0:
        raise ProblemError("l1_ratio", value=value, must="must be between 0 and 1")
    return Fraction(number)


def _weights(value: Any, count: int) -> NDArray[np.float64] | None:
    if value is None:
        return None
    weights = real_array(value, "weights", 1)
    if weights.shape != (count,) or (weights < 0.0).any():
        raise ProblemError("weights", value=value, must=f"must be {count} numbers >= 0")
    return weights
