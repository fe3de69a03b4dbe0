"""The objective of a small lasso-family problem in exact numbers: what is drawn, descended and refereed."""

from dataclasses import dataclass
from fractions import Fraction


@dataclass(frozen=True, eq=False)
class Exact:
    """(1/2) sum_i k_i r_i^2 + sum_j l_j |b_j| + sum_g c_g ||b_g|| + (1/2) sum_j q_j b_j^2, r = y - X b - b0.

    Attributes
    ----------
    X : Fractions, rows
    y, k : list of Fraction, of the samples
    l1, ridge : list of Fraction, of the columns
    groups : list of (columns, c)
    intercept, positive : bool
    """

    X: list[list[Fraction]]
    y: list[Fraction]
    k: list[Fraction]
    l1: list[Fraction]
    ridge: list[Fraction]
    groups: list[tuple[list[int], Fraction]]
    intercept: bool
    positive: bool
