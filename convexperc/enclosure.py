"""The rigorous interval of F*: ball arithmetic, with as many bits as it takes.

Upper end: F at an exact point. Lower end: the dual at an exact point that is feasible by proof. In float64
the certificate's width is limited by w and u; here it is limited by patience alone.
"""

import math
from contextlib import suppress
from dataclasses import dataclass, field, replace
from fractions import Fraction

import flint
import numpy as np

from convexperc.arrays import FeatureVector, Vector, point_entries
from convexperc.ball_duality import dual_value, objective_at, primal_value
from convexperc.certificate import ABSOLUTE, Certificate
from convexperc.errors import PointError, SolverError
from convexperc.exact import exact_optimum
from convexperc.interior import Central, CentralPath
from convexperc.multiprecision import (
    BallFrame,
    ExactData,
    Number,
    Numbers,
    dot,
    float_above,
    float_below,
    precision,
    times,
)
from convexperc.problem import Problem
from convexperc.refinement import Refinement, Start
from convexperc.scaling import Scaling
from convexperc.solvers.newton import Newton

BITS = (128, 256, 512, 2048, 8192)
"""Precisions that are tried in turn; entries from 1e-150 to 1e150 in one matrix need the last ones."""


@dataclass(frozen=True)
class ExactPoint:
    """The point behind an enclosure before any rounding, on the original data.

    Attributes
    ----------
    w : n Fractions
    t : m Fractions
        u^i = t_i X_i' q where lambda1, lambda3 > 0; without meaning elsewhere.
    q : n Fractions
        The dual point's b is about -2 q.
    value : Fraction
        Upper bound of F at the point.
    lower, upper : Fraction
        lower <= F* <= upper <= value.
    """

    w: tuple[Fraction, ...]
    t: tuple[Fraction, ...]
    q: tuple[Fraction, ...]
    value: Fraction
    lower: Fraction
    upper: Fraction


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


def enclose(
    problem: Problem,
    *,
    relative_tolerance: float = 1e-12,
    absolute_tolerance: float = ABSOLUTE / 10,
    bits: int = BITS[0],
    start: tuple[Vector, FeatureVector] | None = None,
) -> Enclosure:
    """Enclose F* until the interval is as narrow as asked, or `BITS` is exhausted.

    In each precision Newton's method refines a float64 answer; where that is not narrow enough, the central
    path is followed from its beginning. In the equality cases of `convexperc.exact` the interval is known
    beforehand, and the path gives the point: it prefers a short w, which survives rounding to float64.

    Parameters
    ----------
    problem : Problem
    relative_tolerance, absolute_tolerance : float
        Stop at a width of relative_tolerance F* or absolute_tolerance ||o||^2.
    bits : int
        The first precision, at least 53; the larger ones of `BITS` follow where it is not enough.
    start : pair of float64 (n,) and (d,), optional
        A point (w, u) near the optimum, such as a solution's, to be refined; it is never believed. Without,
        `convexperc.solvers.newton.Newton` gives one.

    Returns
    -------
    Enclosure
        Its widths say what was reached.

    Raises
    ------
    PointError
        A start of a wrong shape, or fewer than 53 bits.
    """
    if bits < 53:
        raise PointError("bits", value=bits, must="must be at least 53")
    known = _Known.of(problem, start)
    tolerances = relative_tolerance, absolute_tolerance
    best = _in_one_precision(known, bits, tolerances)
    for more in BITS:
        narrow = best.relative_width <= relative_tolerance or best.share_of_target <= absolute_tolerance
        if narrow and best.steps:
            break
        if more > bits:
            found = _in_one_precision(known, more, tolerances)
            best = found if not best.steps or found.share_of_target < best.share_of_target else best
    return best


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
    def of(cls, problem: Problem, start: tuple[Vector, FeatureVector] | None) -> "_Known":
        scaling = Scaling.of(problem)
        near = _float_answer(problem, scaling, start)
        return cls(problem, scaling, ExactData.of(problem), exact_optimum(problem), near)


def _in_one_precision(known: _Known, bits: int, tolerances: tuple[float, float]) -> Enclosure:
    """The best that one precision gives."""
    scaling = known.scaling
    with precision(bits):
        frame = BallFrame.of(known.problem, (scaling.x, scaling.o), known.data)
        interval = _Interval(frame, _scaled_ball(known.optimum, scaling), tolerances)
        with suppress(ZeroDivisionError):  # a matrix that is singular in this precision
            if known.optimum is None:
                _refine(interval, known.near)
            if not (interval.steps and interval.narrow):
                _follow(interval)
        return interval.enclosure(known)


def _float_answer(
    problem: Problem, scaling: Scaling, given: tuple[Vector, FeatureVector] | None
) -> Start | None:
    """The start in normalised units; None where no solver answers in finite numbers."""
    normal = scaling.normalise(problem)
    if given is not None:
        w = point_entries(given[0], problem.n, "w", finite=True)
        w, u = scaling.point(w, point_entries(given[1], problem.d, "u", finite=True))
    else:
        try:
            with np.errstate(all="ignore"):
                found = Newton().candidate(normal)
        except (SolverError, ArithmeticError, np.linalg.LinAlgError):
            return None
        w, u = found.w, found.u
    t = np.zeros(problem.m)
    if normal.lambda3 > 0.0:
        with np.errstate(over="ignore"):
            t = 2.0 * normal.modalities.norms(u) / normal.lambda3
    return Start(w, t) if np.isfinite(w).all() and np.isfinite(t).all() else None


class _Interval:
    """The narrowest interval of F* so far, normalised, in one precision; at first 0 <= F* <= ||o||^2."""

    def __init__(self, frame: BallFrame, exact: Number | None, tolerances: tuple[float, float]) -> None:
        self.frame, self.tolerances, self.steps = frame, tolerances, 0
        zero = flint.arb(0)
        self.lower, self.upper = zero, frame.target.upper()
        if exact is not None:
            self.lower, self.upper = exact.lower(), exact.upper()
        self.value = frame.target.upper()
        self.point = Central([zero] * frame.n, [zero] * len(frame.K), [zero] * frame.n, zero)

    def try_point(self, point: Central) -> bool:
        """Bound F* by what the point gives; true where the interval or F at the point is better."""
        value, low = primal_value(self.frame, point).upper(), dual_value(self.frame, point).lower()
        better = bool(value < self.value) or bool(low > self.lower)
        if value < self.value:
            self.value, self.point = value, point
        self.upper = min(self.upper, value)
        self.lower = max(self.lower, low)
        return better

    @property
    def relative(self) -> float:
        """Upper bound of (upper - lower) / F*."""
        return _quotient(self.upper - self.lower, self.lower)

    @property
    def share(self) -> float:
        """Upper bound of (upper - lower) / ||o||^2."""
        return _quotient(self.upper - self.lower, self.frame.target.lower())

    @property
    def narrow(self) -> bool:
        """Whether the interval is within the tolerances."""
        return self.relative <= self.tolerances[0] or self.share <= self.tolerances[1]

    def enclosure(self, known: _Known) -> Enclosure:
        """The interval and its point on the original data."""
        w, u = _floats(known, self.frame, self.point)
        unit = flint.arb(2) ** (2 * known.scaling.o)
        ends = _down(self.lower * unit), float_above(self.upper * unit)
        exact = _exact_point(self, known.scaling)
        return Enclosure(*ends, self.relative, self.share, w, u, flint.ctx.prec, self.steps, exact)


def _refine(interval: _Interval, near: Start | None) -> None:
    """Newton's method from the float64 answer."""
    if near is None:
        return
    refinement = Refinement(interval.frame, near)
    interval.try_point(refinement.point())
    interval.steps += refinement.steps


def _follow(interval: _Interval) -> None:
    """Follow the central path until the interval is narrow, or no more is gained."""
    path, before, stalled = CentralPath(interval.frame), interval.steps, 0
    while stalled <= 3 and path.mu >= interval.frame.target * flint.arb(2) ** (-flint.ctx.prec):
        path.advance()
        stalled = 0 if interval.try_point(path.point()) else stalled + 1
        interval.steps = before + path.steps
        if interval.narrow:
            break


def _exact_point(interval: _Interval, scaling: Scaling) -> ExactPoint:
    """Everything as rationals, in the units of the original data."""
    x, o, point = scaling.x, scaling.o, interval.point
    t = point.t or [flint.arb(0)] * len(interval.frame.K)
    ends = (_fraction(end, 2 * o) for end in (interval.value, interval.lower, interval.upper))
    return ExactPoint(
        tuple(_fraction(v, o - x) for v in point.w),
        tuple(_fraction(v, -4 * x) for v in t),
        tuple(_fraction(v, x + o) for v in point.q),
        *ends,
    )


def _fraction(value: Number, exponent: int) -> Fraction:
    """A ball without radius times 2^exponent."""
    whole, own = (int(part) for part in value.mid().man_exp())
    return whole * Fraction(2) ** (own + exponent)


def _scaled_ball(exact: Fraction | None, scaling: Scaling) -> Number | None:
    """The exact optimum of the equality case, normalised, in the precision in force."""
    if exact is None:
        return None
    value = exact / Fraction(2) ** (2 * scaling.o)
    return flint.arb(flint.fmpq(value.numerator, value.denominator))


def _floats(known: _Known, frame: BallFrame, point: Central) -> tuple[Vector, np.ndarray]:
    """The point (w, u) on the original data, rounded to nearest."""
    problem, scaling = known.problem, known.scaling
    unit = flint.arb(2) ** (scaling.o - scaling.x)
    w, u = np.array([float(v * unit) for v in point.w]), np.zeros(problem.d)
    if problem.lambda1 == 0.0:
        return w, u
    unit = unit * flint.arb(2) ** (-2 * scaling.x)
    if problem.lambda3 == 0.0:
        parts = [[v * unit for v in _least_norm(frame, point.w)]] * problem.m
    else:
        parts = [[weight * v * unit for v in point.q] for weight in point.t]
    for columns, part in zip(problem.modalities, known.data.columns(parts), strict=True):
        u[columns] = [float(v) for v in part]
    return w, u


def _least_norm(frame: BallFrame, w: Numbers) -> Numbers:
    """The y with u = X'y of least norm for which Xu is the projection of w onto the range of X."""
    inside = list(w)
    if frame.null is not None:
        gram = frame.null.transpose() * frame.null
        outside = times(frame.null, times(gram.inv(), times(frame.null.transpose(), w)))
        inside = [value - part for value, part in zip(w, outside, strict=True)]
    y, rows = [flint.arb(0)] * frame.n, frame.rows
    if rows:
        block = flint.arb_mat([[frame.G[a, b] for b in rows] for a in rows])
        found = block.mid().solve(flint.arb_mat([[inside[a].mid()] for a in rows]), algorithm="approx")
        for k, row in enumerate(rows):
            y[row] = found[k, 0].mid()
    return y


def _down(value: Number) -> float:
    return max(0.0, float_below(value))


def _quotient(width: Number, value: Number) -> float:
    if not width > 0:
        return 0.0
    return float_above(width / value) if value > 0 else math.inf


def certify_in_balls(
    problem: Problem,
    found: Enclosure,
    certificate: Certificate,
    point: tuple[Vector, FeatureVector] | None = None,
) -> Certificate:
    """Judge a point by the enclosure's interval.

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
    w, u = (found.w, found.u) if point is None else point
    lower, upper = max(found.lower, certificate.lower), min(found.upper, certificate.upper)
    with precision(2 * found.bits):
        value = objective_at(problem, w, u)
        bounds = _down(value), float_above(value)
        gap = (value - flint.arb(lower)).nonnegative_part()
        target = dot(*[[flint.arb(float(v)) for v in problem.o]] * 2)
        relative, share = _quotient(gap.upper(), flint.arb(lower)), _quotient(gap.upper(), target.lower())
        excess = float_above(gap) if gap > 0 else max(0.0, float_above(gap))
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
        method=f"ball arithmetic, {found.bits} bits",
    )
