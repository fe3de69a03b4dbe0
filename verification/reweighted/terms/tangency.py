"""Whether a weight is the tangent one: weight(r) square'(r) = loss'(r) on each interval of one formula."""

from fractions import Fraction
from itertools import pairwise
from typing import Any

import sympy as sp
from flint import arb, fmpq

from verification.exact.balls import UnresolvedError, precision
from verification.reweighted.answers import Answer, Word
from verification.reweighted.terms.expressions import (
    R,
    evaluate,
)
from verification.reweighted.terms.signs import BITS, points
from verification.reweighted.terms.term import Side, Term, text


def tangent(term: Term) -> Answer:
    """Say whether weight(r) square'(r) = loss'(r)."""
    question, undecided = "tangent", False
    for side in term.sides:
        jump = loss_jump(side)
        if jump is not None:
            return jump
        for lower, upper, loss, weight in side.both:
            difference = simplified(side.slope(weight) - sp.diff(loss, R))
            if difference == 0:
                continue
            point = _differs_at(difference, lower, upper)
            if point is not None:
                return _not_tangent(term, side, point)
            undecided = True
    if undecided:
        return Answer(
            question,
            Word.UNDECIDED,
            "The difference was not simplified to 0.",
            "SymPy; no point shows a difference",
        )
    given = "weight(r) square'(r) - loss'(r) = 0 on each interval, simplified by SymPy"
    return Answer(question, Word.YES, "The weighted square has the slope of the loss at every r_i.", given)


def simplified(difference: Any) -> Any:
    """The difference, 0 where SymPy finds that, also in exponentials for hyperbolic functions."""
    found = sp.simplify(difference)
    hyperbolic = found != 0 and found.has(sp.tanh, sp.sinh, sp.cosh, sp.coth)
    return sp.S.Zero if hyperbolic and sp.simplify(difference.rewrite(sp.exp)) == 0 else found


def loss_jump(side: Side) -> Answer | None:
    """What is said where the loss jumps as its formula changes; None where it does not."""
    for before, after in pairwise(side.loss):
        low, high = (
            sp.limit(each.expression, R, before.upper, way) for each, way in ((before, "-"), (after, "+"))
        )
        difference = sp.simplify(high - low)
        if difference == 0:
            continue
        said = f"The loss jumps at r = {side.sign}{before.upper}, and what a weight descends does not."
        shown = {"r": f"{side.sign}{before.upper}", "loss before": str(low), "loss after": str(high)}
        with precision(BITS):
            if difference.is_number and not arb(evaluate(difference, fmpq(0))).contains(0):
                return Answer("tangent", Word.NO, said, "limits by SymPy", shown, fault=True)
        return Answer("tangent", Word.UNDECIDED, "Whether the loss jumps was not decided.", "limits by SymPy")
    return None


def _differs_at(difference: Any, lower: Any, upper: Any) -> Fraction | None:
    """The simplest point tried at which it is not 0, beyond doubt."""
    found = []
    for point in points(lower, upper):
        with precision(BITS):
            try:
                value = arb(evaluate(difference, fmpq(point.numerator, point.denominator)))
            except UnresolvedError:
                continue
            if not value.contains(0):
                found.append(point)
    return min(found, key=lambda point: point.denominator + point.numerator, default=None)


def _not_tangent(term: Term, side: Side, point: Fraction) -> Answer:
    factor = _factor(term)
    if factor is None:
        said = "The weighted square has another slope than the loss at r_i."
    elif factor.is_number:
        said = f"The weight is {factor} times the tangent one: it is that of {factor} times the stated loss."
    else:
        said = f"The weight is {factor} times the tangent one, a factor that depends on r."
    where = sp.Rational(point.numerator, point.denominator)
    loss, weight = next(
        (a, b) for lower, upper, a, b in side.both if bool(lower < where) and bool(where < upper)
    )
    with precision(BITS):
        at_point = fmpq(point.numerator, point.denominator)
        wanted, got = (evaluate(each, at_point) for each in (sp.diff(loss, R), side.slope(weight)))
    shown = {"r": side.shown(point), "slope of the loss": text(wanted), "slope of the square": text(got)}
    if factor is not None and factor.is_number:
        shown["factor"] = str(factor)
    if side.sign:
        shown |= {"slope of the loss": f"-({text(wanted)})", "slope of the square": f"-({text(got)})"}
    return Answer("tangent", Word.NO, said, f"ball arithmetic at r = {shown['r']}", shown, fault=True)


def _factor(term: Term) -> Any:
    """weight(r) square'(r) / loss'(r) where it is one formula for all r; else None."""
    found = set()
    for side in term.sides:
        for _, _, loss, weight in side.both:
            slope = sp.diff(loss, R)
            if slope != 0:
                found.add(sp.simplify(side.slope(weight) / slope))
            elif weight != 0:
                return None
    return found.pop() if len(found) == 1 else None


def is_smoothing(term: Term) -> bool:
    """Whether the weight is the tangent one of a kink at 0, smoothed: bounded there, the same far away."""
    return all(_smooths(side) for side in term.sides)


def _smooths(side: Side) -> bool:
    first, last = side.both[0], side.both[-1]
    kink = sp.limit(sp.diff(first[2], R) / R, R, 0, "+") is sp.oo
    bounded = sp.limit(first[3], R, 0, "+")
    far = sp.limit(side.slope(last[3]) / sp.diff(last[2], R), R, sp.oo) if sp.diff(last[2], R) != 0 else None
    unbounded = sp.limit(last[2], R, sp.oo) is sp.oo
    return bool(kink and unbounded and bounded.is_number and bounded.is_finite and far == 1)
