"""Whether a weight follows a change of the unit of r as its loss does."""

from fractions import Fraction
from typing import Any

import sympy as sp
from flint import arb, fmpq

from convexperc.errors import InputError
from verification.exact.balls import UnresolvedError, precision
from verification.reweighted.answers import Answer, Word
from verification.reweighted.terms.dimensions import unit_of_widths
from verification.reweighted.terms.expressions import at, exactly
from verification.reweighted.terms.signs import BITS
from verification.reweighted.terms.term import Side, Term, text


def units(term: Term) -> Answer:
    """Say whether the weight follows a change of the unit of r, as the loss does."""
    found = unit_of_widths(term.loss_expression, term.weight_expression, term.widths)
    if found is None:
        said = "The loss has numbers of its own unit, so that the question does not arise."
        return Answer("units", Word.UNDECIDED, said, "dimensional analysis of the loss")
    power, _, follows = found
    if not follows:
        return _unit_fault(term, power)
    said = unit_said(power, ", ".join(term.widths))
    return Answer("units", Word.YES, said, "dimensional analysis of both formulas")


def unit_said(power: Any, names: str) -> str:
    """The answer yes, with the unit that the widths of these names have; none: no names."""
    said = "In another unit of r the weight follows as the loss does"
    if not names:
        return f"{said}."
    known = {1: "the unit of r", 2: "the unit of r squared", 0: "no unit"}
    return f"{said}, if {names} has {known.get(power, f'the unit of r to the power {power}')}."


def _unit_fault(term: Term, power: Any) -> Answer:
    """Exact numbers: weight(t r) t^2 / loss'... must be a power of t that does not depend on r."""
    side = term.sides[0]
    for t in (Fraction(1, 1000), Fraction(10), Fraction(1, 10**6), Fraction(1000)):
        scaled = {
            name: exactly(value) * sp.Rational(t.numerator, t.denominator) ** power
            for name, value in term.widths.items()
        }
        try:
            moved = Term(term.loss, term.weight, term.square, scaled, term.signed).sides[0]
        except InputError:
            continue
        shown = _unlike(side, moved, t)
        if shown is not None:
            said = "In another unit of r the loss is the same up to a factor, and the weight is not."
            return Answer(
                "units", Word.NO, said, f"ball arithmetic at r, and in units of {1 / t}", shown, fault=True
            )
    said = "The weight is not of one unit as it is written, but no numbers show it."
    return Answer("units", Word.UNDECIDED, said, "dimensional analysis of the weight")


def _unlike(side: Side, moved: Side, t: Fraction) -> dict[str, str] | None:
    """A point at which the weight changes by another factor than the loss over r squared."""
    for point in (Fraction(1), Fraction(1, 2), Fraction(2), Fraction(1, 8), Fraction(8), Fraction(1, 64)):
        with precision(BITS):
            try:
                losses = at(side.loss, point), at(moved.loss, t * point)
                weights = at(side.weight, point), at(moved.weight, t * point)
                square = fmpq(t.numerator, t.denominator) ** 2
                if arb(losses[0]).contains(0):
                    continue
                wanted = arb(weights[0]) * losses[1] / losses[0] / square
            except (InputError, UnresolvedError, ZeroDivisionError):
                continue
            if bool(wanted < arb(weights[1])) or bool(wanted > arb(weights[1])):
                return {
                    "r": str(point),
                    "weight": text(weights[0]),
                    "r in the other unit": str(t * point),
                    "weight that follows": text(wanted),
                    "weight there": text(weights[1]),
                }
    return None
