"""The rigorous interval of F*: ball arithmetic, with as many bits as it takes.

Upper end: F at an exact point. Lower end: the dual at an exact point that is feasible by proof. In float64
the certificate's width is limited by w and u; here it is limited by patience alone.
"""

import math
from contextlib import suppress
from dataclasses import replace
from typing import Any

import flint
import numpy as np

from convexperc.certificate.arithmetic import broken_assumption
from convexperc.certificate.certificate import Certificate, certify
from convexperc.certificate.tolerances import ABSOLUTE, Tolerances
from convexperc.enclosure.balls import dot, float_above, float_below, precision
from convexperc.enclosure.budget import SECONDS, Budget, OutOfBudget
from convexperc.enclosure.interval import objective_at, quotient
from convexperc.enclosure.levels import BITS, Known, float_answer
from convexperc.enclosure.result import Enclosure
from convexperc.errors import PrecisionError
from convexperc.problem.arrays import FeatureVector, Vector
from convexperc.problem.problem import Problem
from convexperc.problem.scaling import Scaling

NARROW = Tolerances(1e-12, ABSOLUTE / 10)
"""How narrow an interval `enclose` is asked for, unless told otherwise."""
EXHAUSTED = f"{BITS[-1]} bits do not give a narrower one"


def enclose(
    problem: Problem,
    *,
    relative_tolerance: float = NARROW.relative,
    absolute_tolerance: float = NARROW.absolute,
    bits: int = BITS[0],
    start: tuple[Any, Any] | None = None,
    seconds: float = SECONDS,
) -> Enclosure:
    """Enclose F* until the interval is as narrow as asked, `BITS` is exhausted, or the budget is spent.

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
    seconds : float
        For ball arithmetic and exact numbers; see `convexperc.enclosure.budget.Budget`.

    Returns
    -------
    Enclosure
        What is proved so far; its `reason` says why no more is, where it is wider than asked.

    Raises
    ------
    PointError
        A start of a wrong shape or with NaN or infinity.
    PrecisionError
        Fewer than 53 bits, or no integer.
    ToleranceError
        A tolerance is no finite number >= 0.
    BudgetError
        `seconds` is no number > 0.
    """
    if not (bits >= 53 and bits % 1 == 0):
        raise PrecisionError("bits", value=bits, must="must be an integer of at least 53")
    tolerances, budget = Tolerances(relative_tolerance, absolute_tolerance), Budget(seconds)
    return enclosed(problem, tolerances, budget, bits=bits, start=start)


def enclosed(
    problem: Problem,
    tolerances: Tolerances,
    budget: Budget,
    *,
    bits: int = BITS[0],
    start: tuple[Any, Any] | None = None,
) -> Enclosure:
    """`enclose` within what is left of a budget."""
    near, broken = float_answer(problem, start), broken_assumption()
    if broken:  # floats become balls, and balls floats, by way of this arithmetic
        return Enclosure.of_nothing(problem, bits, broken)
    best = Enclosure.of_nothing(problem, bits)
    with suppress(OutOfBudget):
        for found in Known.of(problem, near, budget).levels(bits, tolerances):
            best = found
    if best.steps and tolerances.met_by_shares(best.relative_width, best.share_of_target):
        return best
    if not budget.spent:
        return replace(best, reason=EXHAUSTED)
    return replace(_with_floats(problem, best, near, tolerances), reason=budget.reason)


def _with_floats(
    problem: Problem, best: Enclosure, near: tuple[Vector, FeatureVector] | None, tolerances: Tolerances
) -> Enclosure:
    """The enclosure, cut to what float64 proves with a normalised point."""
    point = np.zeros(problem.n), np.zeros(problem.d)
    if near is not None:
        point = Scaling.of(problem).point_back(*near)
    return best.within(
        certify(
            problem, *point, relative_tolerance=tolerances.relative, absolute_tolerance=tolerances.absolute
        )
    )


def finite_start(w: Vector, u: FeatureVector) -> tuple[Vector, FeatureVector] | None:
    """The point as a start of `enclose`; None where an entry is NaN or infinite."""
    return (w, u) if bool(np.isfinite(w).all() and np.isfinite(u).all()) else None


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
        bounds = max(0.0, float_below(value)), float_above(value)
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
