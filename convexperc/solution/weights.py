"""Proved intervals of the optimal weights: w*_j of every view, ||u*^i|| of every modality.

F is ||X'w - o||^2 + lambda1 ||Xu - w||^2 plus a convex function. With r = Xu - w, every optimum (w*, u*) and
every point with F(w, u) - F* <= gap satisfy

    ||X'(w - w*)||^2 + lambda1 ||r - r*||^2 <= gap.                                                       (1)

*Zeros.* With v = X a - b, a = 2(X'w - o) and b = 2 lambda1 r, (1) and Cauchy and Schwarz give

    |v_j| + 2 sqrt(gap (G_jj + lambda1)) < lambda2         proves w*_j = 0,
    ||X_i'b|| + 2 sqrt(gap lambda1 trace K_i) < lambda3    proves u*^i = 0.

*Views.* The part of w* in {b : X'b = 0} is that of -r*, so (1) bounds e'He with e = w - w* and
H = G + lambda1 N, N the projection onto that space. Over the views P that are not proved 0, Z the others,

    |w_j - w*_j| <= (sqrt(gap) + sqrt(w_Z' H_ZZ w_Z)) sqrt((H_PP^-1)_jj).

lambda1 > 0 makes H positive definite for every X. With lambda1 = 0, w*_j is unique where every b with
X_P'b = 0 has b_j = 0: adding a multiple of B B' to H_PP, B a basis of these b, then leaves the bound true.

*Modalities.* With q* = -lambda1 r* and t*_i = 2 ||u*^i|| / lambda3, the optimality of u* reads
u*^i = t*_i X_i' q*. Hence, over the modalities that are not proved 0,

    sum_i t*_i K_i q* = Xu* = w* - q* / lambda1,                                                          (2)

which is solved in ball arithmetic, q* and w* being known up to (1). Where the vectors K_i q* are independent
for all such q*, t* is unique. Everything else is called not determined.
"""

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import flint
import numpy as np
from numpy.typing import NDArray

from convexperc.certificate.arithmetic import broken_assumption
from convexperc.enclosure.balls import (
    Number,
    Numbers,
    column,
    dot,
    exact_matrix,
    float_above,
    float_below,
    matrix_cost,
    midpoint,
    precision,
    times,
)
from convexperc.enclosure.budget import SECONDS, Budget, OutOfBudget
from convexperc.enclosure.central_path import Central
from convexperc.enclosure.convexity import Curvature, RankUnknownError, principal
from convexperc.enclosure.exact_data import ExactData
from convexperc.enclosure.interval import dual_value, objective_at, primal_value
from convexperc.enclosure.reduced import ReducedBalls
from convexperc.enclosure.result import Enclosure
from convexperc.errors import PointError, check_type
from convexperc.problem.problem import Problem
from convexperc.solution.solution import Solution

BITS = (128, 256, 512, 2048)
"""Precisions that are tried in turn until the inverse of H_PP is known."""
OPEN = "more bits are needed"
RANK = "lambda1 = 0 and the rows of X are dependent, or their rank is not proved"
GAP = "no finite gap is proved"
UNCOUPLED = "lambda3 = 0, or lambda1 = 0, leaves u* free"
VIEWS = "a view is not determined"
DEPENDENT = "the vectors K_i q* are dependent, or not proved independent with this gap"


@dataclass(frozen=True, eq=False)
class Intervals:
    """lower_k <= weight_k <= upper_k at every optimum, proved and rounded outward.

    Attributes
    ----------
    lower, upper : float64 (k,)
        Infinite (for norms 0 and infinite) where the weight is not determined.
    determined : bool (k,)
        True where all optima have the same weight, by proof.
    reason : str
        Why some are not determined; empty where all are.
    """

    lower: NDArray[np.float64]
    upper: NDArray[np.float64]
    determined: NDArray[np.bool_]
    reason: str


@dataclass(frozen=True, eq=False)
class WeightIntervals:
    """What is proved of the optimal weights.

    Attributes
    ----------
    views : Intervals
        Of w*_j, shape (n,).
    modalities : Intervals
        Of ||u*^i||_2, shape (m,).
    gap : float
        Upper bound of F - F* at the point behind the intervals: their widths are about its square root.
    """

    views: Intervals
    modalities: Intervals
    gap: float


def weight_intervals(
    solution: Solution, enclosure: Enclosure | None = None, *, seconds: float = SECONDS
) -> WeightIntervals:
    """Enclose every optimal weight.

    Parameters
    ----------
    solution : Solution
        Its certificate's proved zeros are used in any case.
    enclosure : Enclosure, optional
        That of the same problem. Its point is good to some 18 digits, a float64 solution only to the square
        root of its gap.
    seconds : float
        For ball arithmetic and exact numbers; see `convexperc.enclosure.budget.Budget`. Where they do not
        suffice, nothing is determined, and the reason says so.

    Returns
    -------
    WeightIntervals

    Raises
    ------
    PointError
        The enclosure has another number of views or modalities.
    BudgetError
        `seconds` is no number > 0.
    """
    check_type(solution, Solution, "solution")
    check_type(enclosure, (Enclosure, type(None)), "enclosure", PointError)
    problem, budget = solution.problem, Budget(seconds)
    if enclosure is not None and (len(enclosure.exact.w), len(enclosure.exact.t)) != (problem.n, problem.m):
        raise PointError("enclosure", value=enclosure, must="must be that of the solution's problem")
    broken = broken_assumption()
    if broken:
        return _nothing(problem, broken)
    try:
        return _intervals(solution, enclosure, budget)
    except OutOfBudget:
        return _nothing(problem, budget.reason)


def _intervals(solution: Solution, enclosure: Enclosure | None, budget: Budget) -> WeightIntervals:
    """The intervals, within the budget."""
    problem, first = solution.problem, BITS[0] if enclosure is None else max(BITS[0], enclosure.bits)
    with budget.running():
        data = ExactData.of(problem, budget)
    for bits in (first, *(more for more in BITS if more > first)):
        with precision(bits), budget.running():
            reduced = ReducedBalls.of(problem, (0, 0), data)
            point = _solved(solution, reduced) if enclosure is None else _refined(enclosure, reduced)
            zeros = _proved_zeros(reduced, point, solution)
            views = _views(problem, reduced, point, ~zeros[0])
            if views.reason != OPEN:
                break
    with precision(bits), budget.running():
        modalities = _modalities(reduced, point, views, ~zeros[1])
        return WeightIntervals(views.outward(-math.inf), modalities.outward(0.0), float_above(point.gap))


@dataclass(frozen=True, eq=False)
class _Point:
    """A point of which (1) is known.

    Attributes
    ----------
    w, r : lists of n arb
        r = Xu - w; 0 where lambda1 = 0.
    gap : arb
        Upper bound of F - F*, without radius; infinite where none is known.
    """

    w: Numbers
    r: Numbers
    gap: Number

    @property
    def reach(self) -> Number:
        """sqrt(gap)."""
        return self.gap.sqrt().upper()


@dataclass(frozen=True, eq=False)
class _Balls:
    """Each weight in a ball, or None where it is not determined."""

    values: list[Number | None]
    reason: str

    def outward(self, least: float) -> Intervals:
        """Round to float64; `least` is a lower bound of every weight."""
        values = [v if v is not None and v.is_finite() else None for v in self.values]
        known = np.array([value is not None for value in values])
        lower = [least if v is None else max(least, float_below(v)) for v in values]
        upper = [math.inf if v is None else float_above(v) for v in values]
        return Intervals(np.array(lower), np.array(upper), known, "" if known.all() else self.reason)


def _nothing(problem: Problem, reason: str) -> WeightIntervals:
    """Nothing is determined."""
    views, modalities = _unknown(problem.n, -math.inf, reason), _unknown(problem.m, 0.0, reason)
    return WeightIntervals(views, modalities, math.inf)


def _unknown(count: int, least: float, reason: str) -> Intervals:
    """Intervals of which nothing is known."""
    undetermined = np.zeros(count, dtype=bool)
    return Intervals(np.full(count, least), np.full(count, math.inf), undetermined, reason)


def _solved(solution: Solution, reduced: ReducedBalls) -> _Point:
    """The solution's own point."""
    problem, certificate = solution.problem, solution.certificate
    gap = flint.arb(certificate.gap)
    if not (np.isfinite(solution.w).all() and np.isfinite(solution.u).all()):
        return _Point([flint.arb(0)] * reduced.n, [flint.arb(0)] * reduced.n, flint.arb(math.inf))
    value = objective_at(problem, solution.w, solution.u)
    w, u = exact_matrix(solution.w[:, None]), exact_matrix(solution.u[:, None])
    own = (value - flint.arb(certificate.lower)).nonnegative_part().upper()
    return _Point(column(w), column(exact_matrix(problem.X) * u - w), min(gap, own))


def _refined(enclosure: Enclosure, reduced: ReducedBalls) -> _Point:
    """The enclosure's point before rounding, with its gap computed anew."""
    exact = enclosure.exact
    w, t, q = ([_rational(v) for v in part] for part in (exact.w, exact.t, exact.q))
    central = Central(w, t, q, flint.arb(0))
    gap = primal_value(reduced, central) - dual_value(reduced, central)
    r = [-v for v in w]
    if reduced.lambdas[0] > 0 and reduced.lambdas[2] > 0:
        for weight, gram in zip(t, reduced.K, strict=True):
            r = [a + weight * b for a, b in zip(r, times(gram, q), strict=True)]
    elif reduced.null is not None:
        r = [-v for v in times(reduced.null, w)]
    else:
        r = [flint.arb(0)] * reduced.n
    return _Point(w, r, gap.nonnegative_part().upper())


def _rational(value: Fraction) -> Number:
    """The number, exactly where the precision in force allows it; any point near it does as well."""
    return flint.arb(flint.fmpq(value.numerator, value.denominator)).mid()


def _within(radius: Number) -> Number:
    """The ball around 0."""
    return flint.arb(0, radius.upper())


def _proved_zeros(
    reduced: ReducedBalls, point: _Point, solution: Solution
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Views and modalities that no optimum uses, by the certificate or by (1)."""
    lambda1, lambda2, lambda3 = reduced.lambdas
    views, modalities = solution.certificate.zero_views.copy(), solution.certificate.zero_modalities.copy()
    if lambda3 > 0 and lambda1 == 0:
        modalities[:] = True
    if not point.gap.is_finite():
        return views, modalities
    pull = times(reduced.G, point.w)
    for j in range(reduced.n):
        v = 2 * (pull[j] - reduced.c[j] - lambda1 * point.r[j])
        views[j] |= bool(abs(v) + 2 * (point.gap * (reduced.G[j, j] + lambda1)).sqrt() < lambda2)
    for i, gram in enumerate(reduced.K):
        norm = 2 * lambda1 * dot(point.r, times(gram, point.r)).nonnegative_part().sqrt()
        modalities[i] |= bool(norm + 2 * (point.gap * lambda1 * gram.trace()).sqrt() < lambda3)
    return views, modalities


def _views(problem: Problem, reduced: ReducedBalls, point: _Point, kept: NDArray[np.bool_]) -> _Balls:
    """Every w*_j."""
    values: list[Number | None] = [None if some else flint.arb(0) for some in kept]
    P, Z = np.flatnonzero(kept).tolist(), np.flatnonzero(~kept).tolist()
    if not P:
        return _Balls(values, "")
    if not point.gap.is_finite():
        return _Balls(values, GAP)
    try:
        curvature = Curvature.of(problem, reduced, P)
    except RankUnknownError:
        return _Balls(values, RANK)
    if curvature is None:
        return _Balls(values, OPEN)
    reach = point.reach
    if Z:
        outside = [point.w[j] for j in Z]
        reach += dot(outside, times(principal(curvature.H, Z), outside)).nonnegative_part().sqrt()
    for k, j in enumerate(P):
        if curvature.unique[k]:
            values[j] = point.w[j] + _within(reach * curvature.inverse[k, k].nonnegative_part().sqrt())
    return _Balls(values, RANK)


def _modalities(reduced: ReducedBalls, point: _Point, views: _Balls, kept: NDArray[np.bool_]) -> _Balls:
    """Every ||u*^i||."""
    values: list[Number | None] = [None if some else flint.arb(0) for some in kept]
    active, (lambda1, _, lambda3) = np.flatnonzero(kept).tolist(), reduced.lambdas
    w = [value for value in views.values if value is not None]
    if not active:
        return _Balls(values, "")
    if not (lambda1 > 0 and lambda3 > 0):
        return _Balls(values, UNCOUPLED)
    if not point.gap.is_finite() or len(w) < reduced.n:
        return _Balls(values, VIEWS if point.gap.is_finite() else GAP)
    error = lambda1.sqrt() * point.reach
    q = [_within(error) - lambda1 * v for v in point.r]
    t = _multipliers(reduced, [reduced.K[i] for i in active], w, q)
    if t is not None:
        for i, value in zip(active, t, strict=True):
            values[i] = lambda3 / 2 * value
    return _Balls(values, DEPENDENT)


def _multipliers(reduced: ReducedBalls, K: list[Any], w: Numbers, q: Numbers) -> Numbers | None:
    """Solve (2) for t*; None where the system may be singular.

    For any matrix L and any t, L M (t* - t) = L (w* - q* / lambda1 - M t) with M = [K_i q*]; L is about the
    pseudo-inverse of M and t about the solution, so that L M is about I and the right side is small.
    """
    n, k = reduced.n, len(K)
    reduced.budget.require(matrix_cost(n * k * (n + k)))
    columns = [times(gram, q) for gram in K]
    M = flint.arb_mat([[columns[i][a] for i in range(k)] for a in range(n)])
    middle = M.mid()
    try:
        L = ((middle.transpose() * middle).mid().inv() * middle.transpose()).mid()
        right = [a - b / reduced.lambdas[0] for a, b in zip(w, q, strict=True)]
        t = midpoint(times(L, right))
        S = sum((gram * weight for gram, weight in zip(K, t, strict=True)), flint.arb_mat(n, n))
        for a in range(n):
            S[a, a] += 1 / reduced.lambdas[0]
        rest = [a - b for a, b in zip(w, times(S, q), strict=True)]
        change = column((L * M).solve(flint.arb_mat(k, 1, times(L, rest))))
    except ZeroDivisionError:
        return None
    return [a + b for a, b in zip(t, change, strict=True)]
