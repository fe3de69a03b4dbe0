"""Certify an answer to a lasso, group lasso, sparse group lasso, elastic net or ridge fit, from anywhere."""

import math
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from convexperc.certificate.tolerances import ABSOLUTE, RELATIVE, Tolerances
from convexperc.errors import ProblemError
from convexperc.lasso.certificate import LassoCertificate, certificate
from convexperc.lasso.conventions import Convention, Given, check_taken, convention_of, formula_of
from convexperc.lasso.design import Design, design_of
from convexperc.lasso.objective import SMALLEST, LeastSquares, Penalty, column_groups
from convexperc.problem.arrays import nonnegative_number, point_entries, real_array


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
    X : array_like or sparse matrix of SciPy (n, p)
        A row for each sample, a column for each feature. A sparse matrix is never made dense, but for the
        columns that nothing penalises.
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
        One for each group, in the order of the sorted labels, or without groups for each column; >= 0. What
        has the weight 0 is not penalised.
    positive : bool
        Whether b >= 0 is asked for.
    **more
        ``l1_ratio`` (1 by default), ``l1_reg`` (0 by default) and ``sample_weight`` (array_like (n,), >= 0:
        the loss is the weighted mean where it is a mean, else the weighted sum), where the convention has
        them; and ``relative_tolerance``, ``absolute_tolerance``: see `LassoCertificate.certified`.

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
    Columns that nothing penalises are treated as the intercept is: the dual point is made orthogonal to them.
    Where float64 does not tell that they are independent of one another and of the intercept, the lower bound
    is 0 and `LassoCertificate.method` says so. See `convexperc.lasso.certificate` for the bounds.
    """
    options = _options(more)
    tolerances = Tolerances(options.pop("relative_tolerance"), options.pop("absolute_tolerance"))
    chosen = convention_of(convention)
    check_taken(
        chosen,
        groups=groups is not None,
        weights=weights is not None,
        **{name: more.get(name) is not None for name in options},
    )
    design = design_of(X)
    n, p = design.shape
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
    samples = _sample_weights(options["sample_weight"], n)
    if samples is not None:
        design, target = _without(samples == 0.0, design, target)
    fit = LeastSquares(
        design, target, _loss(chosen, samples, n), l1, group, ridge, None if group.zero else parts,
        intercept is not None, positive,
    )  # fmt: skip
    answer = point_entries(_column(coef), p, "coef", finite=True)
    b0 = (
        0.0
        if intercept is None
        else float(point_entries(np.reshape(intercept, -1), 1, "intercept", finite=True)[0])
    )
    formula = formula_of(
        chosen, groups=groups is not None, sample_weight=samples is not None, intercept=intercept is not None
    )
    return certificate(fit, answer, b0, tolerances, formula + (", b >= 0" if positive else ""))


def _options(more: dict[str, Any]) -> dict[str, Any]:
    defaults = {
        "l1_ratio": 1.0,
        "l1_reg": 0.0,
        "sample_weight": None,
        "relative_tolerance": RELATIVE,
        "absolute_tolerance": ABSOLUTE,
    }
    for name in more:
        if name not in defaults:
            known = ", ".join(defaults)
            unknown = f"certify_lasso() got an unexpected keyword argument {name!r}"
            raise TypeError(f"{unknown}; further options are {known}")
    return defaults | more


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


def _sample_weights(value: Any, n: int) -> NDArray[np.float64] | None:
    if value is None:
        return None
    weights = real_array(value, "sample_weight", 1)
    if weights.shape != (n,) or (weights < 0.0).any() or not weights.any():
        must = f"must be {n} numbers >= 0, as X has {n} rows, and not all 0"
        raise ProblemError("sample_weight", value=value, must=must)
    least, most = float(weights[weights > 0.0].min()), float(weights.max())
    if least < SMALLEST * most:
        must = "must not differ by a factor of more than 2^400, but for those that are 0"
        raise ProblemError("sample_weight", value=(least, most), must=must)
    return weights


def _without(
    rows: NDArray[np.bool_], design: Design, target: NDArray[np.float64]
) -> tuple[Design, NDArray[np.float64]]:
    """Samples of the weight 0 are no part of the objective."""
    return (design.kept(~rows), target[~rows]) if rows.any() else (design, target)


def _loss(convention: Convention, samples: NDArray[np.float64] | None, n: int) -> Penalty:
    """K w_i; the sum of the weights is rounded once, and the largest is scaled to about 1."""
    if samples is None:
        return Penalty(convention.loss(Fraction(n)), np.ones(1))
    exponent = math.frexp(float(samples.max()))[1]
    scaled = np.ldexp(samples[samples > 0.0], -exponent)
    power = Fraction(2) ** exponent
    total = Fraction(math.fsum(scaled)) * power
    return Penalty(convention.loss(total) * power, scaled)
