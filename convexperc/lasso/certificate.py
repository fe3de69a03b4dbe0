"""Bounds of the optimum of a penalised least-squares fit, and of how far an answer is from it.

With k_i = K w_i, l, c, r of `convexperc.lasso.objective`, v = X't, and S(v, l) = sign(v) (|v| - l)+, or
(v - l)+ where b >= 0 is asked for, the dual is

    maximise  D(t) = y't - sum_i t_i^2 / (2 k_i) - sum_g sup over b_g of (v_g'b_g - penalties of b_g)

over the t with 1't = 0 where there is an intercept, and v_j = 0 for each column that nothing penalises;

    the last part of a group is 0                     if e_g = (||S(v_g, l_g)|| - c_g)+ = 0,
                  at most e_g^2 / (2 r_g)             with r_g the least of its r_j > 0,
                  at most e_g B_g                     if every optimum has ||b_g|| <= B_g.

B_g follows from the value of the answer: the penalties of an optimum are at most that. So a dual point that
is not quite feasible gives a bound as well, and nothing is accepted within a tolerance. The answer's residual
suggests t = k (y - X b - b0); `convexperc.lasso.dual_points` says how it is made orthogonal. The gap is
bounded as a sum of terms >= 0, without subtracting the bounds:

    P(b, b0) - D(t) = sum_i (k_i (y - X b - b0)_i - t_i)^2 / (2 k_i)
                      + sum_g (penalties of b_g - v_g'b_g + its last part).

Source: Boyd and Vandenberghe, Convex Optimization, section 5.1; Ndiaye et al., Gap Safe screening rules for
sparsity enforcing penalties, JMLR 18 (2017).
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from convexperc.certificate.arithmetic import broken_assumption
from convexperc.certificate.rounding import down, up
from convexperc.certificate.tolerances import Tolerances
from convexperc.lasso.dual_points import DualPoint, Limits, dual_points, gap_at, rays, zeros_at
from convexperc.lasso.objective import LeastSquares
from convexperc.lasso.scaled import ScaledAnswer, ScaledData
from convexperc.problem.arrays import Vector
from convexperc.problem.scaling import Bounds

NO_BOUND = "P >= 0"
DEPENDENT = "the columns without a penalty depend on one another, as far as float64 tells"


@dataclass(frozen=True, eq=False)
class LassoCertificate:
    """What is proved of an answer (b, b0) to a penalised least-squares fit; rounding is included.

    Attributes
    ----------
    lower, upper : float
        lower <= P* <= upper, in the units of the objective; upper is the least known value.
    objective : (float, float)
        Bounds of P(b, b0); infinite where b >= 0 is asked for and an entry is negative.
    gap : float
        Upper bound of P(b, b0) - P*.
    relative_gap : float
        Upper bound of (P(b, b0) - P*) / P*: 0 where the gap is 0, else infinite where P* may be 0.
    share_of_target : float
        Upper bound of (P(b, b0) - P*) / (1/2 sum_i k_i y_i^2), the value without any feature.
    tolerances : Tolerances
        Certified means that relative_gap or share_of_target meets them.
    zero_features : bool (p,)
        True where b*_j = 0 is proved of every optimal b*.
    zero_groups : bool (m,)
        True where b*_g = 0 is proved; empty without groups.
    assumed : str
        The objective that was judged, as a formula.
    method : str
        How the gap was proved; or why nothing is.
    """

    lower: float
    upper: float
    objective: Bounds
    gap: float
    relative_gap: float
    share_of_target: float
    tolerances: Tolerances
    zero_features: NDArray[np.bool_]
    zero_groups: NDArray[np.bool_]
    assumed: str
    method: str

    @property
    def certified(self) -> bool:
        """Whether the gap is within the tolerances; false for NaN."""
        return self.tolerances.met_by_shares(self.relative_gap, self.share_of_target)


def certificate(
    given: LeastSquares, coefficients: Vector, intercept: float, tolerances: Tolerances, assumed: str
) -> LassoCertificate:
    """Bound how far (b, b0) is from the optimum; see `certify_lasso`."""
    p, m = given.design.shape[1], 0 if given.groups is None else given.groups.starts.size
    zeros = np.zeros(p, dtype=bool), np.zeros(m, dtype=bool)
    broken = broken_assumption(min(given.design.shape))
    if broken:
        unknown = (0.0, math.inf, (0.0, math.inf), math.inf, math.inf, math.inf)
        return LassoCertificate(*unknown, tolerances, *zeros, assumed, broken)
    with np.errstate(all="ignore"):
        data = ScaledData.of(given)
        answer = ScaledAnswer.of(data, coefficients, intercept)
        upper = min(answer.objective[1], data.target[1])
        lower, gap, method = 0.0, answer.objective[1], NO_BOUND
        best = _best(data, answer, upper)
        if best is not None:
            lower = min(max(0.0, best.lower), upper)
            proved = gap_at(data, answer, best) if math.isfinite(gap) else math.inf
            zeros = zeros_at(data, best, up(upper - min(best.lower, upper)))
            if proved < gap:
                gap, method = proved, f"dual point, {'charged' if best.charge else 'feasible'}"
        elif data.free.any():
            method = f"{method}; {DEPENDENT}"
        gap = min(gap, max(0.0, up(answer.objective[1] - lower)))
        lower = max(lower, down(answer.objective[0] - gap)) if math.isfinite(gap) else lower
        lower = min(max(lower, 0.0), upper)
        target = data.target[0]
    ends = [_back(end, data.k) for end in (lower, upper, *answer.objective, gap)]
    values = ends[0][0], ends[1][1], (ends[2][0], ends[3][1]), ends[4][1]
    return LassoCertificate(
        *values, _share(gap, lower), _share(gap, target), tolerances, *zeros, assumed, method
    )


def _best(data: ScaledData, answer: ScaledAnswer, upper: float) -> DualPoint | None:
    """The dual point of the largest value; None where no value is known to be finite."""
    limits = Limits.of(data, upper)
    found = [dual for ray in rays(data, answer) for dual in dual_points(data, ray, limits)]
    best = max(found, key=lambda dual: dual.lower, default=None)
    return best if best is not None and math.isfinite(best.lower) else None


def _back(value: float, k: int) -> Bounds:
    """Value * 2^2k as (lower, upper) (as Lemma R19)."""
    moved = float(np.ldexp(value, 2 * k))
    if k == 0 or (math.isfinite(moved) and float(np.ldexp(moved, -2 * k)) == value):
        return moved, moved
    return max(0.0, down(min(moved, 2.0**1023))), up(moved)


def _share(gap: float, of: float) -> float:
    if gap == 0.0:
        return 0.0
    return up(gap / of) if of > 0.0 and math.isfinite(gap) else math.inf
