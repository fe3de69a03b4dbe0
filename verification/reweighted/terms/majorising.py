"""Whether the weighted square lies above what the weight descends: the weight must not rise with |r|."""

from fractions import Fraction
from itertools import product
from typing import Any

import sympy as sp
from flint import arb, fmpq

from convexperc.errors import InputError
from verification.exact.balls import UnresolvedError, precision
from verification.reweighted.answers import Answer, Word
from verification.reweighted.terms.expressions import R, at, evaluate, fraction
from verification.reweighted.terms.signs import BITS, Decision, listed, never_positive
from verification.reweighted.terms.term import Side, Term, text

_NEAR = tuple(Fraction(2) ** k * m for k in (0, 1, -1, 2, -2, 4, -4, 8, -8) for m in (1, 3))
"""Sizes of residuals that are tried in pairs."""


def majorises(term: Term) -> Answer:
    """Say whether the weighted square lies above what the weight descends, and touches it at r_i."""
    if len(term.sides) > 1:
        return _asymmetric(term)
    side, undecided, steps = term.sides[0], None, []
    for lower, upper, _, weight in side.both:
        decision = never_positive(sp.simplify(sp.diff(weight, R)), lower, upper)
        if decision.word is Word.NO:
            return _rises(side, decision)
        if decision.word is Word.UNDECIDED:
            undecided = decision
        steps.append(decision.basis)
    for (_, upper, _, before), (_, _, _, after) in zip(side.both, side.both[1:], strict=False):
        jump = sp.simplify(sp.limit(after, R, upper, "+") - sp.limit(before, R, upper, "-"))
        if not jump.is_number or not bool(jump <= 0):
            return _jumps(side, upper)
    if undecided is not None:
        said = "Whether the weight never rises with r was not decided."
        return Answer("majorises", Word.UNDECIDED, said, undecided.basis)
    said = "The weight never rises with r: its square lies above what it descends, and touches it at r_i."
    return Answer("majorises", Word.YES, said, listed(steps))


def _asymmetric(term: Term) -> Answer:
    """Loss or weight differ at r and -r: the square from one residual lies below the loss at another."""
    with precision(BITS):
        for r, t in product(_NEAR, repeat=2):
            for here, there in product(term.sides, repeat=2):
                shown = _lies_below(term, (here, r), (there, t))
                if shown is not None:
                    said = "The square from one residual lies below the loss at another: r and -r differ."
                    basis = f"ball arithmetic at r = {shown['r_i']} and {shown['r']}"
                    return Answer("majorises", Word.NO, said, basis, shown, fault=True)
    said = "The weight differs at r and -r; whether its square lies above the loss was not decided."
    return Answer("majorises", Word.UNDECIDED, said, "no pair of the points tried shows it below")


def _lies_below(
    term: Term, start: tuple["Side", Fraction], end: tuple["Side", Fraction]
) -> dict[str, str] | None:
    """Whether loss(r) > loss(r_i) + weight(r_i) (square(r) - square(r_i)), beyond doubt; None if not."""
    (here, r), (there, t) = start, end
    try:
        before, weight, after = at(here.loss, r), at(here.weight, r), at(there.loss, t)
    except (InputError, UnresolvedError, ZeroDivisionError):
        return None
    difference = (t * t - r * r) * fraction(term.factor)
    square = before + weight * fmpq(difference.numerator, difference.denominator)
    if not bool(arb(after) > arb(square)):
        return None
    return {"r_i": here.shown(r), "r": there.shown(t), "square": text(square), "loss": text(after)}


def _rises(side: Side, decision: Decision) -> Answer:
    """The weight rises next to a point: the square from there lies below what the weight descends."""
    point = decision.point or Fraction(1)
    pair = _pair(side, point)
    if pair is None:
        said = "The derivative of the weight is positive, but no pair of points shows it."
        return Answer("majorises", Word.UNDECIDED, said, decision.basis)
    low, high, before, after = pair
    return _risen(side, low, high, before, after)


def _risen(side: Side, low: Fraction, high: Fraction, before: Any, after: Any) -> Answer:
    said = (
        "The weight rises with r: its square, made at the smaller r, lies below what it descends further out."
    )
    shown = {
        "r": side.shown(low),
        "weight": text(before),
        "larger r": side.shown(high),
        "weight there": text(after),
    }
    return Answer("majorises", Word.NO, said, f"ball arithmetic at r = {low} and {high}", shown, fault=True)


def _pair(side: Side, point: Fraction) -> tuple[Fraction, Fraction, Any, Any] | None:
    """Two points next to one, inside one interval, between which the weight rises beyond doubt."""
    where = sp.Rational(point.numerator, point.denominator)
    lower, upper, weight = next(
        (low, high, each) for low, high, _, each in side.both if bool(low < where) and bool(where < high)
    )
    for shift in range(1, 200):
        step = Fraction(1, 2**shift) * point
        for low, high in ((point, point + step), (point - step, point)):
            inside = bool(sp.Rational(low.numerator, low.denominator) > lower) and bool(
                sp.Rational(high.numerator, high.denominator) < upper
            )
            if not inside:
                continue
            with precision(BITS):
                values = [evaluate(weight, fmpq(each.numerator, each.denominator)) for each in (low, high)]
                if bool(arb(values[0]) < arb(values[1])):
                    return low, high, *values
    return None


def _jumps(side: Side, end: Any) -> Answer:
    """The weight jumps up where its formula changes, if ball arithmetic shows it."""
    for shift in range(2, 60):
        near = sp.Rational(1, 2**shift)
        low, high = (sp.nsimplify(end - near, rational=True), sp.nsimplify(end + near, rational=True))
        pair = [fraction(each) for each in (low, high)]
        with precision(BITS):
            try:
                values = [at(side.weight, each) for each in pair]
            except (InputError, UnresolvedError):
                continue
            if bool(arb(values[0]) < arb(values[1])):
                return _risen(side, pair[0], pair[1], *values)
    said = "Whether the weight jumps up where its formula changes was not decided."
    return Answer("majorises", Word.UNDECIDED, said, f"at r = {end}")
