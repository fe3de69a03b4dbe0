"""The rigorous interval of F*: ball arithmetic, with as many bits as it takes.

Upper end: F at an exact point. Lower end: the dual at an exact point that is feasible by proof. In float64
the certificate's width is limited by w and u; here it is limited by patience alone.
"""

import math
from contextlib import suppress
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Any

import flint
import numpy as np

from convexperc.certificate.arithmetic import broken_assumption
from convexperc.certificate.certificate import Certificate
from convexperc.certificate.rationals import exact_optimum
from convexperc.certificate.tolerances import ABSOLUTE, Tolerances
from convexperc.enclosure.active_set import Start
from convexperc.enclosure.balls import (
    ExactData,
    Number,
    ReducedBalls,
    dot,
    float_above,
    float_below,
    precision,
)
from convexperc.enclosure.exact_point import ExactPoint, float_point
from convexperc.enclosure.interval import Interval, objective_at, quotient
from convexperc.errors import PrecisionError, SolverError
from convexperc.problem.arrays import FeatureVector, Vector, point_entries
from convexperc.problem.problem import Problem
from convexperc.problem.scaling import Scaling
from convexperc.solvers.newton.method import Newton

BITS = (128, 256, 512, 2048, 8192)
"""Precisions that are tried in turn; entries from 1e-150 to 1e150 in one matrix need the last ones."""


@dataclass(frozen=True, eq=False)
class Enclosure:
    """lower <= F* <= upper, proved, on the original data, and the point that attains the upper end.

    Attributes
    ----------
    lower, upper : float
        Rounded outward.
    relative_width : float
        Upper bound of (upper - lower) / F* before that rounding; infinite where F* may be 0.
    share_of_target : float
        Upper bound of (upper - lower) / ||o||^2.
    w : float64 (n,)
        The point's view weights, rounded to nearest.
    u : float64 (d,)
    bits : int
        Precision that was needed.
    steps : int
        Newton steps.
    exact : ExactPoint
        The point and the interval before rounding to float64.
    method : str
        How the interval was proved; or which assumption on the arithmetic fails, so that nothing is.
    """

    lower: float
    upper: float
    relative_width: float
    share_of_target: float
    w: Vector
    u: np.ndarray
    bits: int
    steps: int
    exact: ExactPoint = field(repr=False)
    method: str


def enclose(
    problem: Problem,
    *,
    relative_tolerance: float = 1e-12,
    absolute_tolerance: float = ABSOLUTE / 10,
    bits: int = BITS[0],
    start: tuple[Any, Any] | None = None,
) -> Enclosure:
    """Enclose F* until the interval is as narrow as asked, or `BITS` is exhausted.

    In each precision Newton's method refines a float64 answer; where that is not narrow enough, the central
    path is followed from its beginning. In the equality cases of `convexperc.certificate.rationals` the
    interval is known beforehand, and the path gives the point: it prefers a short w, which survives rounding
    to float64.

    Parameters
    ----------
    problem : Problem
    relative_tolerance, absolute_tolerance : float
        Stop at a width of relative_tolerance F* or absolute_tolerance ||o||^2.
    bits : int
        The first precision, at least 53; the larger ones of `BITS` follow where it is not enough.
    start : pair of array_like (n,) and (d,), optional
        A point (w, u) near the optimum, such as a solution's, to be refined; it is never believed. Without,
        `convexperc.solvers.newton.method.Newton` gives one.

    Returns
    -------
    Enclosure
        Its widths say what was reached.

    Raises
    ------
    PointError
        A start of a wrong shape or with NaN or infinity.
    PrecisionError
        Fewer than 53 bits, or no integer.
    ToleranceError
        A tolerance is no finite number >= 0.
    """
    if not (bits >= 53 and bits % 1 == 0):
        raise PrecisionError("bits", value=bits, must="must be an integer of at least 53")
    known = _Known.of(problem, start)
    tolerances = Tolerances(relative_tolerance, absolute_tolerance)
    broken = broken_assumption()
    if broken:  # floats become balls, and balls floats, by way of this arithmetic
        nothing = np.zeros(problem.n), np.zeros(problem.d)
        unknown = (math.inf,) * 3
        return Enclosure(0.0, *unknown, *nothing, bits, 0, ExactPoint.zero(problem.n, problem.m), broken)
    best = _in_one_precision(known, bits, tolerances)
    for more in BITS:
        if best.steps and tolerances.met_by_shares(best.relative_width, best.share_of_target):
            break
        if more > bits:
            found = _in_one_precision(known, more, tolerances)
            best = found if not best.steps or found.share_of_target < best.share_of_target else best
    return best


def finite_start(w: Vector, u: FeatureVector) -> tuple[Vector, FeatureVector] | None:
    """The point as a start of `enclose`; None where an entry is NaN or infinite."""
    return (w, u) if bool(np.isfinite(w).all() and np.isfinite(u).all()) else None


@dataclass(frozen=True, eq=False)
class _Known:
    """What does not depend on the precision.

    Attributes
    ----------
    optimum : Fraction or None
        The exact one of the equality case.
    near : Start or None
        A float64 answer.
    """

    problem: Problem
    scaling: Scaling
    data: ExactData
    optimum: Fraction | None
    near: Start | None

    @classmethod
    def of(cls, problem: Problem, start: tuple[Any, Any] | None) -> "_Known":
        scaling = Scaling.of(problem)
        near = _float_answer(problem, scaling, start)
        return cls(problem, scaling, ExactData.of(problem), exact_optimum(problem), near)


def _in_one_precision(known: _Known, bits: int, tolerances: Tolerances) -> Enclosure:
    """The best that one precision gives."""
    scaling = known.scaling
    with precision(bits):
        reduced = ReducedBalls.of(known.problem, (scaling.x, scaling.o), known.data)
        interval = Interval(reduced, _scaled_ball(known.optimum, scaling), tolerances)
        if known.optimum is None and known.near is not None:
            with suppress(ZeroDivisionError):  # a matrix that is singular in this precision
                interval.refine(known.near)
        if not (interval.steps and interval.narrow):
            with suppress(ZeroDivisionError):
                interval.follow()
        point = float_point(known.problem, known.data, scaling, reduced, interval.point)
        unit = flint.arb(2) ** (2 * scaling.o)
        ends = _down(interval.lower * unit), float_above(interval.upper * unit)
        exact = ExactPoint.of(interval, scaling)
        widths = interval.relative, interval.share
        return Enclosure(*ends, *widths, *point, bits, interval.steps, exact, f"ball arithmetic, {bits} bits")


def _float_answer(problem: Problem, scaling: Scaling, given: tuple[Any, Any] | None) -> Start | None:
    """The start in normalised units; None where no solver answers in finite numbers."""
    normal = scaling.normalise(problem)
    if given is not None:
        w = point_entries(given[0], problem.n, "w", finite=True)
        w, u = scaling.point(w, point_entries(given[1], problem.d, "u", finite=True))
    else:
        try:
            with np.errstate(all="ignore"):
                found = Newton().solve(normal)
        except (SolverError, ArithmeticError, np.linalg.LinAlgError):
            return None
        w, u = found.w, found.u
    t = np.zeros(problem.m)
    if normal.lambda3 > 0.0:
        with np.errstate(over="ignore"):
            t = 2.0 * normal.modalities.norms(u) / normal.lambda3
    return Start(w, t) if np.isfinite(w).all() and np.isfinite(t).all() else None


def _scaled_ball(exact: Fraction | None, scaling: Scaling) -> Number | None:
    """The exact optimum of the equality case, normalised, in the precision in force."""
    if exact is None:
        return None
    value = exact / Fraction(2) ** (2 * scaling.o)
    return flint.arb(flint.fmpq(value.numerator, value.denominator))


def _down(value: Number) -> float:
    return max(0.0, float_below(value))


def certify_in_balls(
    problem: Problem,
    found: Enclosure,
    certificate: Certificate,
    point: tuple[Vector, FeatureVector] | None = None,
) -> Certificate:
    """Certify a point by the enclosure's interval.

    Parameters
    ----------
    problem : Problem
    found : Enclosure
    certificate : Certificate
        The float64 one of some point of the same problem: it gives the tolerances and the proved zeros, and
        its interval is intersected with the enclosure's.
    point : pair of float64 (n,) and (d,), optional
        The enclosure's own point without.

    Returns
    -------
    Certificate
        Of that point.
    """
    broken = broken_assumption()
    if broken:
        return Certificate.of_nothing(problem, certificate.tolerances, broken)
    w, u = (found.w, found.u) if point is None else point
    lower, upper = max(found.lower, certificate.lower), min(found.upper, certificate.upper)
    with precision(2 * found.bits):
        value = objective_at(problem, w, u)
        bounds = _down(value), float_above(value)
        gap = (value - flint.arb(lower)).nonnegative_part()
        target = dot(*[[flint.arb(float(v)) for v in problem.o]] * 2)
        relative, share = quotient(gap.upper(), flint.arb(lower)), quotient(gap.upper(), target.lower())
        excess = max(0.0, float_above(gap))
    if not value.is_finite():  # NaN or an infinity in the point
        bounds, excess = (0.0, math.inf), math.inf
    return replace(
        certificate,
        lower=lower,
        upper=upper,
        objective=bounds,
        gap=excess,
        relative_gap=relative,
        share_of_target=share,
        terms=None,
        dual=None,
        method=found.method,
    )
