"""The certificate: a proof of how far any point (w, u) is from the optimum of the ORIGINAL problem.

Knows no solver, believes no status, imports NumPy alone. Every number that it reports is a bound with its
rounding included (docs/rounding.md has the proofs, and what they assume of the machine).
"""

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from convexperc.caching import cached_property
from convexperc.certificate.arithmetic import broken_assumption
from convexperc.certificate.duality import DualPoint, GapTerms, dual_points, dual_value, gap_terms
from convexperc.certificate.evaluation import NormalizedData, PrimalPoint
from convexperc.certificate.rationals import exact_optimum
from convexperc.certificate.rounding import UNDERFLOW, down, up
from convexperc.certificate.screening import modality_weight_bound, proved_zeros, view_weight_bound
from convexperc.certificate.tolerances import ABSOLUTE, RELATIVE, Tolerances
from convexperc.problem.arrays import FeatureVector, Vector, point_entries
from convexperc.problem.problem import Problem
from convexperc.problem.scaling import Bounds, Scaling

SUFFICIENT_SHARE = 2.0**-6
"""A gap within this share of a tolerance ends the search for a better dual point."""


@dataclass(frozen=True, eq=False)
class Certificate:
    """What is proved of a point (w, u), on the original data.

    Attributes
    ----------
    lower, upper : float
        lower <= F* <= upper.
    target : float
        Lower bound of ||o||^2, which F* never exceeds by more than rounding.
    objective : (float, float)
        Bounds of F(w, u).
    gap : float
        Upper bound of F(w, u) - F*.
    relative_gap : float
        Upper bound of (F(w, u) - F*) / F*: 0 where the gap is 0, else infinite where F* may be 0.
    share_of_target : float
        Upper bound of (F(w, u) - F*) / ||o||^2.
    tolerances : Tolerances
        Certified means that relative_gap and share_of_target meet them.
    terms : GapTerms or None
        The gap as a sum of terms >= 0, in units where ||o|| is about 1; None where `gap` is no such sum.
    dual : DualPoint or None
        The dual point behind `gap`, in normalised units; None where the bound is exact or trivial.
    method : str
        How the gap was proved; or which assumption on the arithmetic fails, so that nothing is.
    zero_views : bool (n,)
        True where w*_j = 0 is proved of every optimal w*.
    zero_modalities : bool (m,)
        True where u*^i = 0 is proved of every optimal u*.
    """

    lower: float
    upper: float
    target: float
    objective: Bounds
    gap: float
    relative_gap: float
    share_of_target: float
    tolerances: Tolerances
    terms: GapTerms | None
    dual: DualPoint | None
    method: str
    zero_views: NDArray[np.bool_]
    zero_modalities: NDArray[np.bool_]

    @classmethod
    def of_nothing(cls, problem: Problem, tolerances: Tolerances, reason: str) -> "Certificate":
        """F* >= 0 alone, where the arithmetic is not what a proof assumes."""
        unknown, zeros = math.inf, (np.zeros(k, dtype=bool) for k in (problem.n, problem.m))
        return cls(
            0.0,
            unknown,
            0.0,
            (0.0, unknown),
            unknown,
            unknown,
            unknown,
            tolerances,
            None,
            None,
            reason,
            *zeros,
        )

    @property
    def certified(self) -> bool:
        """Whether the gap is within the tolerances; false for NaN."""
        return self.tolerances.met_by_shares(self.relative_gap, self.share_of_target)

    @property
    def enclosed(self) -> bool:
        """Whether [lower, upper] is as narrow as the tolerances ask, at any point (w, u) (Lemma R34)."""
        width = up(self.upper - self.lower) if self.upper > self.lower else 0.0
        return self.certified or bool(self.tolerances.met(width, self.lower, self.target))

    @property
    def relative_tolerance(self) -> float:
        """Largest share of F* that the gap of a certified answer may be."""
        return self.tolerances.relative

    @property
    def absolute_tolerance(self) -> float:
        """Largest share of ||o||^2 that the gap of a certified answer may be."""
        return self.tolerances.absolute

    def is_optimal(self, eps: float) -> bool:
        """Whether F(w, u) - F* <= eps is proved."""
        return self.gap <= eps


def certify(
    problem: Problem,
    w: Any,
    u: Any,
    *,
    dual: tuple[Any, Any] | None = None,
    relative_tolerance: float = RELATIVE,
    absolute_tolerance: float = ABSOLUTE,
    thorough: bool = False,
) -> Certificate:
    """Bound how far a point from anywhere is from the optimum.

    Parameters
    ----------
    problem : Problem
    w : array_like (n,)
    u : array_like (d,)
        NaN and infinity are not refused; nothing is proved of such a point.
    dual : pair of array_like (d,) and (n,), optional
        A dual point (a, b) to try besides 2(X'w - o) and 2 lambda1 (Xu - w). It is never believed:
        it is scaled into the feasible set, or charged for its excess.
    relative_tolerance, absolute_tolerance : float
        See `Certificate`.
    thorough : bool
        Try every dual point and report the best bounds. Without, the search ends with the first dual point
        that proves a gap within `SUFFICIENT_SHARE` of a tolerance: good bounds, not the best.

    Returns
    -------
    Certificate

    Raises
    ------
    PointError
        A wrong shape, or entries that are not real numbers.
    ToleranceError
        A tolerance that is not a finite number >= 0.
    """
    tolerances = Tolerances(relative_tolerance, absolute_tolerance)
    return Certifier.of(problem, tolerances=tolerances, thorough=thorough).certificate(w, u, dual=dual)


@dataclass(frozen=True, eq=False)
class Certifier:
    """One problem, made ready to certify any number of points.

    Attributes
    ----------
    problem : Problem
    scaling : Scaling
    data : NormalizedData
    tolerances : Tolerances
    thorough : bool
        See `certify`.
    """

    problem: Problem
    scaling: Scaling
    data: NormalizedData
    tolerances: Tolerances
    thorough: bool

    @classmethod
    def of(
        cls,
        problem: Problem,
        scaling: Scaling | None = None,
        *,
        tolerances: Tolerances | None = None,
        thorough: bool = False,
    ) -> "Certifier":
        """Normalise the problem."""
        scaling = Scaling.of(problem) if scaling is None else scaling
        tolerances = Tolerances() if tolerances is None else tolerances
        return cls(problem, scaling, NormalizedData.of(problem, scaling), tolerances, thorough)

    def certificate(self, w: Any, u: Any, *, dual: tuple[Any, Any] | None = None) -> Certificate:
        """Certify one point; arguments and errors as of `certify`."""
        n, d = self.problem.n, self.problem.d
        point = point_entries(w, n, "w", finite=False), point_entries(u, d, "u", finite=False)
        hint = None
        if dual is not None:
            hint = self.scaling.dual(
                point_entries(dual[0], d, "a", finite=False), point_entries(dual[1], n, "b", finite=False)
            )
        broken = broken_assumption(min(self.problem.X.shape))
        if broken:
            return Certificate.of_nothing(self.problem, self.tolerances, broken)
        with np.errstate(over="ignore", under="ignore", invalid="ignore"):
            proof = self._prove(PrimalPoint.of(self.data, self.scaling, *point), hint)
        lower, upper = self.scaling.value_back((proof.lower, proof.upper))
        target = self.data.target_square[0]
        return Certificate(
            lower=lower,
            upper=upper,
            target=self.scaling.value_back((target, target))[0],
            objective=self.scaling.value_back(proof.objective),
            gap=self.scaling.value_back((0.0, proof.gap))[1],
            relative_gap=_quotient(proof.gap, proof.lower),
            share_of_target=_quotient(proof.gap, target),
            tolerances=self.tolerances,
            terms=proof.terms,
            dual=proof.dual,
            method=proof.method,
            zero_views=proof.zero_views,
            zero_modalities=proof.zero_modalities,
        )

    @cached_property
    def exact(self) -> Bounds | None:
        """Bounds of the exact optimum of the equality case, normalised; None in other cases (Lemma R32)."""
        optimum = exact_optimum(self.problem)
        if optimum is None:
            return None
        value = optimum / Fraction(2) ** (2 * self.scaling.o)
        nearest = float(value)
        return (
            nearest if Fraction(nearest) <= value else max(0.0, down(nearest)),
            nearest if Fraction(nearest) >= value else up(nearest),
        )

    def _prove(self, point: PrimalPoint, hint: tuple[FeatureVector, Vector] | None) -> "_Proof":
        """The best of F >= 0, the exact bound of the equality case, and the dual points' (Lemma R34)."""
        data = self.data
        upper = min(point.objective[1], data.target_square[1])
        lower, gap, terms, dual, method = 0.0, point.objective[1], None, None, "F >= 0"
        zeros = np.zeros(point.w.mid.shape, dtype=bool), np.zeros(len(data.modalities), dtype=bool)
        if self.exact is not None:
            upper = min(upper, self.exact[1])
            lower, method = self.exact[0], "exact least squares over the rationals"
            gap = max(0.0, up(point.objective[1] - lower))
        for dual_point in dual_points(data, point, hint):
            bound, total, parts = _bounded(data, point, dual_point, upper)
            lower = max(lower, bound)
            if total < gap:
                gap, terms, dual, method = total, parts, dual_point, _method(dual_point)
            if dual_point.feasible:
                found = proved_zeros(data, dual_point, up(upper - min(bound, upper)))
                zeros = zeros[0] | found[0], zeros[1] | found[1]
            if not self.thorough and self._is_enough(_least(gap, point, lower), min(lower, upper)):
                break
        gap = _least(gap, point, lower)
        return _Proof(min(lower, upper), upper, point.objective, gap, terms, dual, method, *zeros)

    def _is_enough(self, gap: float, lower: float) -> bool:
        """Whether this gap certifies the point with room to spare."""
        if _quotient(gap, lower) <= SUFFICIENT_SHARE * self.tolerances.relative:
            return True
        return _quotient(gap, self.data.target_square[0]) <= SUFFICIENT_SHARE * self.tolerances.absolute


@dataclass(frozen=True, eq=False)
class _Proof:
    """What is proved, in normalised units."""

    lower: float
    upper: float
    objective: Bounds
    gap: float
    terms: GapTerms | None
    dual: DualPoint | None
    method: str
    zero_views: NDArray[np.bool_]
    zero_modalities: NDArray[np.bool_]


def _least(gap: float, point: PrimalPoint, lower: float) -> float:
    """The smaller of a gap and F(w, u) - lower (Lemma R34)."""
    return min(gap, max(0.0, up(point.objective[1] - lower)))


def _bounded(
    data: NormalizedData, point: PrimalPoint, dual_point: DualPoint, upper: float
) -> tuple[float, float, GapTerms | None]:
    """A lower bound of F*, an upper one of F(w, u) - F*, and its terms, by a dual point (Lemma R34)."""
    cost = 0.0 if dual_point.feasible else _cost(data, dual_point, upper)
    lower = dual_value(dual_point)[0]
    lower = down(lower - cost) if cost else lower
    if not point.finite:
        return lower, math.inf, None
    parts = gap_terms(data, point, dual_point)
    total = up(parts.total + cost) if cost else parts.total
    if not math.isfinite(total):
        return lower, math.inf, None
    return max(lower, down(point.objective[0] - total)), total, parts


def _cost(data: NormalizedData, dual_point: DualPoint, upper: float) -> float:
    """What the excess of a dual point takes off its bound (Lemma R35)."""
    cost = 0.0
    if dual_point.excess_views != 0.0:
        cost = up(dual_point.excess_views * view_weight_bound(data, upper))
    if dual_point.excess_modalities != 0.0:
        cost = up(cost + up(dual_point.excess_modalities * modality_weight_bound(data, upper)))
    return math.inf if math.isnan(cost) else up(cost) + UNDERFLOW


def _method(dual_point: DualPoint) -> str:
    treatment = "scaled" if dual_point.feasible else "charged"
    return f"dual point '{dual_point.kind}', {treatment}"


def _quotient(gap: float, value: float) -> float:
    """Upper bound of gap / value (Lemma R34)."""
    if gap == 0.0:
        return 0.0
    return up(gap / value) if value > 0.0 and math.isfinite(gap) else math.inf
