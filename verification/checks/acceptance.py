"""What may be called certified, enclosed or 0: the documented tolerances and the definitions, exactly.

The tolerances are written out here as the ledger has them: a certificate's own are a claim like any other.
"""

from collections.abc import Iterable
from dataclasses import replace
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from convexperc.problem.problem import Problem
from verification.checks.measures import SMALLEST, number
from verification.exact import referee
from verification.exact.numbers import Enclosure, rationals, squares
from verification.exact.reduced import Reduced

RELATIVE, ABSOLUTE = Fraction(1e-9), Fraction(1e-14)
"""A certified gap is at most this share of F*, or this share of ||o||^2: as documented."""
UNPROVED = Fraction(1, 10**15)
"""A weight is proved to be 0 by |v_j| < lambda2; within this share of lambda2 float64 proves nothing."""

Flags = NDArray[np.bool_]


def is_within(gap: Fraction, optimum: Fraction, problem: Problem) -> bool:
    """Whether a gap above an optimum is one that may be called certified."""
    return gap <= max(RELATIVE * optimum, ABSOLUTE * squares(rationals(problem.o)))


def wrongly_certified(gap: float, problem: Problem, truth: referee.Optimum) -> list[str]:
    """What contradicts that a point whose gap is proved to be at most `gap` is certified."""
    if np.isfinite(gap) and is_within(Fraction(gap) - SMALLEST, truth.value.upper, problem):
        return []
    return [f"certified with a gap of {gap!r} where F* = {number(truth.value.upper)!r}"]


def wrongly_enclosed(lower: float, upper: float, problem: Problem, truth: referee.Optimum) -> list[str]:
    """What contradicts that [lower, upper] encloses F* within the tolerances."""
    if is_within(Fraction(upper) - Fraction(lower), truth.value.upper, problem):
        return []
    return [f"enclosed, but [{lower!r}, {upper!r}] is wider than the tolerances"]


def false_zeros(problem: Problem, views: Flags, modalities: Flags, truth: referee.Optimum) -> list[str]:
    """What contradicts that no optimum uses these views and modalities.

    Without them F* must be the same. And any optimum that uses one costs its weight times the slack of its
    constraint at the referee's dual point, which can be no more than the width of the referee's interval:
    without slack the weight is not excluded.
    """
    without = [(f"w*_{j}", without_view(problem, j)) for j in np.flatnonzero(views).tolist()]
    without += [(f"u*^{i}", without_modality(problem, i)) for i in np.flatnonzero(modalities).tolist()]
    found = [
        f"{name} = 0 is not so: without it F* is {number(value.lower)!r}, not {number(truth.value.upper)!r}"
        for name, value in without
        if value.lower > truth.value.upper
    ]
    if not truth.tight:
        return found
    slack = [Fraction(problem.lambda2) - v for v in truth.views]
    found += _not_excluded("w*_{}", np.flatnonzero(views), slack, problem.lambda2)
    slack = [Fraction(problem.lambda3) - norm.lower for norm in truth.modalities]
    chosen = np.flatnonzero(modalities) if truth.modalities else ()
    return found + _not_excluded("u*^{}", chosen, slack, problem.lambda3)


def _not_excluded(name: str, chosen: Iterable[int], slack: list[Fraction], weight: float) -> list[str]:
    return [
        f"{name.format(k)} = 0 is not so: an optimum may use it"
        for k in chosen
        if slack[k] <= UNPROVED * Fraction(weight)
    ]


def without_view(problem: Problem, j: int) -> Enclosure:
    """The optimum where w_j costs (G_jj + lambda1) w_j^2 more: F* if an optimum has w_j = 0, else above it.

    The loss gets one column more, with o = 0 there, of which u knows nothing.
    """
    reduced = Reduced.of(problem)
    G = reduced.G.copy()
    G[j, j] += (G[j, j] + Fraction(problem.lambda1)) or Fraction(1)
    return referee.optimum(replace(reduced, G=G)).value


def without_modality(problem: Problem, i: int) -> Enclosure:
    """The optimum with u^i = 0: the coupling does without X_i, the loss does not."""
    reduced = Reduced.of(problem)
    K = tuple(gram * Fraction(0) if k == i else gram for k, gram in enumerate(reduced.K))
    return referee.optimum(replace(reduced, K=K)).value
