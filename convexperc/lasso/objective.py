"""The objective of a penalised least-squares fit, in one form for the whole family.

    P(b, b0) = (K/2) sum_i w_i (y - X b - b0)_i^2
               + sum_j l_j |b_j| + sum_g c_g ||b_g||_2 + (1/2) sum_j r_j b_j^2

X has a row for each sample and a column for each feature, as in scikit-learn. Lasso, group lasso, sparse
group lasso, ridge and elastic net are choices of l, c and r. With K = 2, X' in the place of X and o in that
of y it is the paper's objective for lambda1 = 0 or lambda3 = 0.
"""

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from jaxtyping import Float

from convexperc.certificate.rounding import Groups, U
from convexperc.errors import ProblemError
from convexperc.lasso.design import Design
from convexperc.problem.arrays import Vector

SMALLEST, LARGEST = 2.0**-400, 2.0**400
"""Coefficients that are not 0 lie between these, in units in which X and y are about 1."""


@dataclass(frozen=True)
class Coefficients:
    """Numbers >= 0 that may be no floats, as bounds.

    Attributes
    ----------
    lower, upper : float64 (k,)
    """

    lower: Float[np.ndarray, " k"]
    upper: Float[np.ndarray, " k"]

    @classmethod
    def of(
        cls, factor: Fraction, weights: Float[np.ndarray, " k"], exponent: int, name: str
    ) -> "Coefficients":
        """`factor` times each weight, which may be off by 2 ulp, times a power of two."""
        if factor == 0:
            return cls(np.zeros_like(weights), np.zeros_like(weights))
        base = factor * Fraction(2) ** exponent
        inside = Fraction(SMALLEST) <= base <= Fraction(LARGEST)
        products = float(base) * weights if inside else np.full_like(weights, np.inf)
        found = products[weights != 0.0]
        if found.size and not (found.min() >= SMALLEST and found.max() <= LARGEST):
            must = "must be 0, or not so far from the squares of X and y, by a factor of more than 2^400"
            raise ProblemError(name, value=float(factor), must=must, remedy="Rescale the data.")
        return cls(products * (1.0 - 8 * U), products * (1.0 + 8 * U))


@dataclass(frozen=True, eq=False)
class Penalty:
    """A coefficient of the objective: a number times a weight for each column or group.

    Attributes
    ----------
    factor : Fraction
        The number, exactly.
    weights : float64 (k,)
        At least 0; each within 2 ulp of what is meant.
    """

    factor: Fraction
    weights: Vector

    @property
    def zero(self) -> bool:
        """Whether nothing is penalised by it."""
        return self.factor == 0 or not self.weights.any()


@dataclass(frozen=True, eq=False)
class LeastSquares:
    """One fit's objective: the data, and what is multiplied with each part; see the module.

    Attributes
    ----------
    design : Design
        X, of shape (n, p).
    y : float64 (n,)
    loss : Penalty
        K, and the weights w > 0 of the n samples; one weight of 1 where they are equal.
    l1 : Penalty
        l, of the p columns.
    group : Penalty
        c, of the m groups.
    ridge : Penalty
        r, of the p columns.
    groups : Groups or None
        Of the p columns; None where c is 0.
    intercept : bool
        Whether b0 is free; it is 0 otherwise.
    positive : bool
        Whether b >= 0 is asked for.
    """

    design: Design
    y: Vector
    loss: Penalty
    l1: Penalty
    group: Penalty
    ridge: Penalty
    groups: Groups | None
    intercept: bool
    positive: bool


def column_groups(labels: Any, p: int) -> Groups:
    """Groups of columns with the same label, in the order of the labels.

    Parameters
    ----------
    labels : sequence of p labels
        Integers or strings.

    Raises
    ------
    ProblemError
        Another number of labels than columns.
    """
    given = np.asarray(labels)
    if given.shape != (p,) or given.dtype.kind not in "iuUS":
        must = f"must hold an integer or a string for each of the {p} columns of X"
        raise ProblemError("groups", value=labels, must=must)
    _, inverse, sizes = np.unique(given, return_inverse=True, return_counts=True)
    order = np.argsort(inverse, kind="stable")
    starts = np.cumsum(sizes) - sizes
    return Groups(order, starts, sizes.astype(np.float64))
