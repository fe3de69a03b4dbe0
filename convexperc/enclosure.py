"""The rigorous interval of F*: ball arithmetic, with as many bits as it takes.

Upper end: F at an exact point. Lower end: the dual at an exact point that is feasible by proof. In float64
the certificate's width is limited by w and u; here it is limited by patience alone.
"""

import math
from dataclasses import dataclass, replace
from fractions import Fraction

import flint
import numpy as np

from convexperc.arrays import FeatureVector, Vector
from convexperc.ball_duality import dual_value, objective_at, primal_value
from convexperc.certificate import ABSOLUTE, Certificate
from convexperc.exact import exact_optimum
from convexperc.interior import Central, CentralPath
from convexperc.multiprecision import BallFrame, Number, Numbers, dot, exact_matrix, precision, times
from convexperc.problem import Problem
from convexperc.scaling import Scaling

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
    """

    lower: float
    upper: float
    relative_width: float
    share_of_target: float
    w: Vector
    u: np.ndarray
    bits: int
    steps: int


def enclose(
    problem: Problem, *, relative_tolerance: float = 1e-12, absolute_tolerance: float = ABSOLUTE / 10
) -> Enclosure:
    """Enclose F* until the interval is as narrow as asked, or `BITS` is exhausted.

    Parameters
    ----------
    problem : Problem
    relative_tolerance, absolute_tolerance : float
        Stop at a width of relative_tolerance F* or absolute_tolerance ||o||^2.

    Returns
    -------
    Enclosure
        Its widths say what was reached.
    """
    best = _trivial(problem)
    for bits in BITS:
        try:
            with precision(bits):
                found = _follow(problem, bits, relative_tolerance, absolute_tolerance)
        except ZeroDivisionError:  # a matrix that is singular in this precision
            continue
        if best.steps == 0 or found.share_of_target < best.share_of_target:
            best = found
        if _narrow(best.relative_width, best.share_of_target, relative_tolerance, absolute_tolerance):
            break
    return best


def _trivial(problem: Problem) -> Enclosure:
    """0 <= F* <= ||o||^2, which w = u = 0 attains."""
    with precision(BITS[0]):
        o = [flint.arb(float(v)) for v in problem.o]
        upper = _up(dot(o, o))
    zero = np.zeros(problem.n), np.zeros(problem.d)
    share = 1.0 if upper > 0.0 else 0.0
    return Enclosure(0.0, upper, math.inf if share else 0.0, share, *zero, BITS[0], 0)


def _narrow(relative: float, share: float, relative_tolerance: float, absolute_tolerance: float) -> bool:
    return relative <= relative_tolerance or share <= absolute_tolerance


def _follow(problem: Problem, bits: int, relative_tolerance: float, absolute_tolerance: float) -> Enclosure:
    """Follow the central path in one precision."""
    scaling = Scaling.of(problem)
    frame = BallFrame.of(problem, (scaling.x, scaling.o))
    path = CentralPath(frame)
    exact = _exact_ball(problem, scaling)
    upper, lower, best = frame.target.upper(), flint.arb(0), path.point()
    stalled = 0
    while True:
        path.advance()
        point = path.point()
        high, low = primal_value(frame, point).upper(), dual_value(frame, point).lower()
        if exact is not None:
            high, low = exact.upper(), exact.lower()
        narrower = high < upper or low > lower
        stalled = 0 if narrower else stalled + 1
        if high < upper:
            upper, best = high, point
        lower = low if low > lower else lower
        relative, share = _quotient(upper - lower, lower), _quotient(upper - lower, frame.target.lower())
        done = _narrow(relative, share, relative_tolerance, absolute_tolerance)
        if done or stalled > 3 or path.mu < frame.target * flint.arb(2) ** (-bits):
            break
    w, u = _floats(problem, scaling, frame, best)
    unit = flint.arb(2) ** (2 * scaling.o)
    bounds = _down(lower * unit), _up(upper * unit)
    return Enclosure(*bounds, relative, share, w, u, bits, path.steps)


def _exact_ball(problem: Problem, scaling: Scaling) -> Number | None:
    """The exact optimum of the equality case, in the precision in force."""
    exact = exact_optimum(problem)
    if exact is None:
        return None
    value = exact / Fraction(2) ** (2 * scaling.o)
    return flint.arb(flint.fmpq(value.numerator, value.denominator))


def _floats(
    problem: Problem, scaling: Scaling, frame: BallFrame, point: Central
) -> tuple[Vector, np.ndarray]:
    """The point (w, u) on the original data, rounded to nearest."""
    unit = flint.arb(2) ** (scaling.o - scaling.x)
    w = np.array([_nearest(v * unit) for v in point.w])
    u = np.zeros(problem.d)
    if problem.lambda1 == 0.0:
        return w, u
    unit = unit * flint.arb(2) ** (-2 * scaling.x)
    if problem.lambda3 == 0.0:
        y = [v * unit for v in _least_norm(frame, point.w)]
        return w, _combined(problem.X, y)
    for weight, columns in zip(point.t, problem.modalities, strict=True):
        u[columns] = _combined(problem.X[:, columns], [weight * v * unit for v in point.q])
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


def _combined(X: np.ndarray, y: Numbers) -> np.ndarray:
    """X'y, rounded to nearest."""
    return np.array([_nearest(v) for v in times(exact_matrix(X.T, 0), y)])


def _nearest(value: Number) -> float:
    return float(value.mid())


def _up(value: Number) -> float:
    """The smallest float that is not below the number."""
    near = float(value.upper())
    return near if flint.arb(near) >= value else math.nextafter(near, math.inf)


def _down(value: Number) -> float:
    near = float(value.lower())
    near = near if flint.arb(near) <= value else math.nextafter(near, -math.inf)
    return max(0.0, near)


def _quotient(width: Number, value: Number) -> float:
    if not width > 0:
        return 0.0
    return _up(width / value) if value > 0 else math.inf


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
        bounds = _down(value), _up(value)
        gap = (value - flint.arb(lower)).nonnegative_part()
        target = dot(*[[flint.arb(float(v)) for v in problem.o]] * 2)
        relative, share = _quotient(gap.upper(), flint.arb(lower)), _quotient(gap.upper(), target.lower())
        excess = _up(gap) if gap > 0 else max(0.0, _up(gap))
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
