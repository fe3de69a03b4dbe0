"""The objectives of packages by name: what each divides by, and what its strengths stand for.

A lasso's strength means nothing without them: packages divide the loss by 2 n, by n, by 2 or by nothing,
multiply groups by the square roots of their sizes or not, and share one strength between two penalties in
their own ways. Each is stated here as the package documents it.
"""

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from convexperc.certificate.rounding import Groups
from convexperc.errors import InputError, ProblemError
from convexperc.lasso.objective import Penalty
from convexperc.problem.arrays import Vector

_NONE = Fraction(0)


@dataclass(frozen=True, eq=False)
class Given:
    """What a user says of the penalties.

    Attributes
    ----------
    p : int
        Number of columns.
    alpha, l1_ratio : Fraction
        The strength, and how much of it the first of two penalties gets.
    l1_reg : Fraction
        A second strength, of ||b||_1.
    groups : Groups or None
    weights : float64 or None
        One for each group, or without groups for each column.
    """

    p: int
    alpha: Fraction
    l1_ratio: Fraction
    l1_reg: Fraction
    groups: Groups | None
    weights: Vector | None

    @property
    def m(self) -> int:
        """Number of groups."""
        return 0 if self.groups is None else self.groups.starts.size

    @property
    def own(self) -> Vector:
        """The weights; ones where none are given."""
        return np.ones(self.m or self.p) if self.weights is None else self.weights

    @property
    def rooted(self) -> Vector:
        """The weights; the square roots of the sizes of the groups where none are given."""
        if self.weights is not None or self.groups is None:
            return self.own
        return np.sqrt(self.groups.sizes)

    def by_column(self, weights: NDArray[np.float64]) -> NDArray[np.float64]:
        """A weight of each group for each of its columns."""
        if self.groups is None:
            return weights
        found = np.empty(self.p)
        order = np.arange(self.p) if self.groups.order is None else self.groups.order
        found[order] = np.repeat(weights, self.groups.sizes.astype(np.int64))
        return found


Penalties = tuple[Penalty, Penalty, Penalty]
"""Of ||b||_1, of the groups, and of ||b||^2 / 2."""


@dataclass(frozen=True)
class Convention:
    """An objective by name.

    Attributes
    ----------
    name : str
    loss : function of the number of samples, or of the sum of their weights w
        K, where the loss is (K/2) sum_i w_i (y - X b - b0)_i^2, w = 1 without weights.
    penalties : function of Given
    formula, grouped : str
        The objective without and with groups; empty where there is none.
    takes : frozenset of str
        What may be given beside alpha: l1_ratio, l1_reg, weights, groups, sample_weight.
    """

    name: str
    loss: Callable[[Fraction], Fraction]
    penalties: Callable[[Given], Penalties]
    formula: str
    grouped: str
    takes: frozenset[str]


def _penalties(given: Given, l1: Any = None, group: Any = None, ridge: Any = None) -> Penalties:
    """Pairs of a factor and weights; what is left out is 0."""
    sizes = given.p, given.m, given.p
    pairs = (part or (_NONE, np.ones(size)) for part, size in zip((l1, group, ridge), sizes, strict=True))
    first, second, third = (Penalty(factor, weights) for factor, weights in pairs)
    return first, second, third


def _elastic_net(given: Given) -> Penalties:
    one, other = given.alpha * given.l1_ratio, given.alpha * (1 - given.l1_ratio)
    return _penalties(given, l1=(one, given.own), ridge=(other, given.own))


def _glmnet(given: Given) -> Penalties:
    """As the elastic net, with penalty factors that are scaled to add up to p."""
    total = sum((Fraction(float(w)) for w in given.own), _NONE)
    share = Fraction(given.p) / total if total else _NONE
    one, other = given.alpha * given.l1_ratio * share, given.alpha * (1 - given.l1_ratio) * share
    return _penalties(given, l1=(one, given.own), ridge=(other, given.own))


def _lasso_or_groups(given: Given) -> Penalties:
    if given.groups is None:
        return _elastic_net(given)
    return _penalties(given, group=(given.alpha, given.own))


def _adelie(given: Given) -> Penalties:
    one, other = given.alpha * given.l1_ratio, given.alpha * (1 - given.l1_ratio)
    weights = given.rooted
    ridge = (other, given.by_column(weights))
    if given.groups is None:
        return _penalties(given, l1=(one, weights), ridge=ridge)
    return _penalties(given, group=(one, weights), ridge=ridge)


def _sparse_group(given: Given) -> Penalties:
    if given.groups is None:
        return _penalties(given, l1=(given.alpha, given.own))
    one, other = given.alpha * given.l1_ratio, given.alpha * (1 - given.l1_ratio)
    return _penalties(given, l1=(one, np.ones(given.p)), group=(other, given.rooted))


def _group_and_l1(given: Given) -> Penalties:
    l1 = (given.l1_reg, np.ones(given.p))
    if given.groups is None:
        if given.weights is not None:
            must, remedy = "must be left out where there are no groups", "Pass groups=range(p)."
            raise ProblemError("weights", value=given.weights, must=must, remedy=remedy)
        return _penalties(given, l1=(given.alpha + given.l1_reg, np.ones(given.p)))
    return _penalties(given, l1=l1, group=(given.alpha, given.rooted))


def _ridge(given: Given) -> Penalties:
    return _penalties(given, ridge=(2 * given.alpha, given.own))


def _over_n(n: Fraction) -> Fraction:
    return 1 / n


_HALF_MEAN = "||y - Xb - b0||^2 / (2n)"
_ELASTIC = f"{_HALF_MEAN} + alpha * l1_ratio * ||b||_1 + alpha * (1 - l1_ratio) / 2 * ||b||^2"
_WEIGHTED = f"{_HALF_MEAN} + alpha * sum_j weights_j (l1_ratio |b_j| + (1 - l1_ratio) / 2 * b_j^2)"
_ADELIE = (
    f"{_HALF_MEAN} + alpha * sum_g weights_g (l1_ratio ||b_g|| + (1 - l1_ratio) / 2 * ||b_g||^2), "
    "weights_g = sqrt(d_g) unless given"
)
_ROOTS = "weights_g = sqrt(d_g) unless given"
_RESIDUALS = "||y - Xb - b0||^2"
_GROUPS = f"{_HALF_MEAN} + alpha * sum_g weights_g ||b_g||"
CONVENTIONS = {
    each.name: each
    for each in (
        Convention("scikit-learn", _over_n, _elastic_net, _ELASTIC, "",
                   frozenset({"l1_ratio", "sample_weight"})),
        Convention("scikit-learn ridge", lambda n: Fraction(2), _ridge, f"{_RESIDUALS} + alpha * ||b||^2", "",
                   frozenset({"sample_weight"})),
        Convention("glmnet", _over_n, _glmnet, f"{_WEIGHTED}, weights scaled to add up to p", "",
                   frozenset({"l1_ratio", "weights", "sample_weight"})),
        Convention("celer", _over_n, _lasso_or_groups, _WEIGHTED, _GROUPS,
                   frozenset({"l1_ratio", "weights", "groups"})),
        Convention("skglm", _over_n, _lasso_or_groups, _WEIGHTED, _GROUPS,
                   frozenset({"l1_ratio", "weights", "groups", "sample_weight"})),
        Convention("adelie", _over_n, _adelie, _WEIGHTED,
                   _ADELIE,
                   frozenset({"l1_ratio", "weights", "groups", "sample_weight"})),
        Convention("asgl", lambda n: 2 / n, _sparse_group, f"{_RESIDUALS} / n + alpha * ||b||_1",
                   f"{_RESIDUALS} / n + alpha * (l1_ratio ||b||_1 + (1 - l1_ratio) sum_g sqrt(d_g) ||b_g||)",
                   frozenset({"l1_ratio", "groups"})),
        Convention("group-lasso", _over_n, _group_and_l1, f"{_HALF_MEAN} + (alpha + l1_reg) * ||b||_1",
                   f"{_GROUPS} + l1_reg * ||b||_1, {_ROOTS}",
                   frozenset({"l1_reg", "weights", "groups"})),
        Convention("residual sum of squares", lambda n: Fraction(2), _lasso_or_groups,
                   f"{_RESIDUALS} + alpha * sum_j weights_j (l1_ratio |b_j| + (1 - l1_ratio) / 2 * b_j^2)",
                   f"{_RESIDUALS} + alpha * sum_g weights_g ||b_g||",
                   frozenset({"l1_ratio", "weights", "groups", "sample_weight"})),
    )
}  # fmt: skip
"""By name; alpha is the strength that the package calls alpha, lambda, lambda1 or group_reg."""


def convention_of(name: object) -> Convention:
    """Return a convention by its name.

    Raises
    ------
    InputError
        There is none of that name.
    """
    if isinstance(name, str) and name in CONVENTIONS:
        return CONVENTIONS[name]
    known = ", ".join(repr(each) for each in CONVENTIONS)
    raise InputError("convention", value=name, must=f"must be one of {known}")


def formula_of(convention: Convention, *, groups: bool, sample_weight: bool, intercept: bool) -> str:
    """The objective as it is judged."""
    formula = convention.grouped if groups else convention.formula
    if sample_weight:
        formula = formula.replace("(2n)", "(2 sum_i w_i)")
        formula = formula.replace(_RESIDUALS, "sum_i w_i (y - Xb - b0)_i^2")
    return formula if intercept else formula.replace(" - b0", "")


def check_taken(convention: Convention, **given: bool) -> None:
    """Refuse what an objective does not have.

    Raises
    ------
    ProblemError
        Something is given that the convention does not take.
    """
    for name, is_given in given.items():
        if is_given and name not in convention.takes:
            must = f"must be left out: the objective of {convention.name!r} has none"
            raise ProblemError(name, value="given", must=must, remedy="Choose another convention.")
