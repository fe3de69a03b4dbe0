"""Which loss a loop with this weight descends, how far that is from the stated one; and convexity."""

from fractions import Fraction
from typing import Any

import sympy as sp

from verification.reweighted.answers import Answer, Word
from verification.reweighted.terms.expressions import (
    R,
)
from verification.reweighted.terms.signs import listed, never_positive
from verification.reweighted.terms.tangency import loss_jump, simplified
from verification.reweighted.terms.term import Side, Term


def descends(term: Term) -> Answer:
    """Say which loss the loop descends, and how far that is from the stated one."""
    question = "descends"
    if any(loss_jump(side) is not None for side in term.sides):
        said = "It descends the integral of the weight, which has no jumps; the stated loss has one."
        return Answer(question, Word.NO, said, "limits by SymPy")
    distances = [_distance(side) for side in term.sides]
    known = [each for each in distances if each is not None]
    if all(each == (0, 0) for each in distances):
        return Answer(question, Word.YES, "It descends the stated loss.", "weight(r) square'(r) = loss'(r)")
    shown = " and ".join(dict.fromkeys(_integral(side) for side in term.sides))
    if len(known) < len(distances):
        said = f"It descends {shown}; how far that is from the stated loss was not decided."
        return Answer(question, Word.UNDECIDED, said, "integral of the weight by SymPy")
    reach = sp.Max(*(high for _, high in known)) - sp.Min(*(low for low, _ in known))
    basis = "integral of the weight by SymPy, limits at the ends of each interval"
    if reach is sp.oo:
        said = f"It descends {shown}, which is arbitrarily far from the stated loss."
        return Answer(question, Word.NO, said, basis)
    said = (
        f"It descends {shown}, which differs from the stated loss by {reach} at most, up to a constant:"
        f" a minimum of it is within {reach} of the optimum for each such term."
    )
    return Answer(question, Word.NO, said, basis, {"distance": str(reach)})


def _integral(side: Side) -> str:
    parts, before = [], sp.S.Zero
    for lower, upper, _, weight in side.both:
        inner = sp.integrate(sp.simplify(side.slope(weight)), R)
        if inner.has(sp.Integral):
            return "the integral of weight(r) square'(r)"
        start = sp.limit(inner, R, lower, "+")
        shown = inner if not start.is_finite else sp.simplify(inner - start + before)
        before = before if upper is sp.oo or not start.is_finite else sp.limit(shown, R, upper, "-")
        parts.append((shown, "" if len(side.both) == 1 else f" for {lower} < {side.sign}r < {upper}"))
    return ", ".join(f"{str(shown).replace('oo', 'infinity')}{where}" for shown, where in parts)


def _distance(side: Side) -> tuple[Any, Any] | None:
    """Least and largest value of the loss less what the weight descends, from 0 at r = 0; None: not found."""
    level, ends = sp.S.Zero, [sp.S.Zero]
    for lower, upper, loss, weight in side.both:
        slope = simplified(sp.diff(loss, R) - side.slope(weight))
        if slope == 0:
            continue
        monotone = any(never_positive(sign * slope, lower, upper).word is Word.YES for sign in (1, -1))
        inner = sp.integrate(slope, R)
        if not monotone or inner.has(sp.Integral):
            return None
        start, stop = sp.limit(inner, R, lower, "+"), sp.limit(inner, R, upper, "-")
        level = sp.simplify(level + stop - start)
        if not level.is_number and level not in (sp.oo, -sp.oo):
            return None
        ends.append(level)
    return sp.Min(*ends), sp.Max(*ends)


def convex(term: Term) -> Answer:
    """Whether the stated loss is a convex function of the residual, of either sign."""
    undecided, steps = None, []
    for side in term.sides:
        for lower, upper, loss, _ in side.both:
            decision = never_positive(-sp.simplify(sp.diff(loss, R, 2)), lower, upper)
            if decision.word is Word.NO:
                said = "The loss is not convex: a limit may be a minimum that is not the least."
                return Answer(
                    "convex", Word.NO, said, decision.basis, {"r": side.shown(decision.point or Fraction(1))}
                )
            undecided = decision if decision.word is Word.UNDECIDED else undecided
            steps.append(decision.basis)
        for (_, upper, before, _), (_, _, after, _) in zip(side.both, side.both[1:], strict=False):
            rise = sp.limit(sp.diff(after, R), R, upper, "+") - sp.limit(sp.diff(before, R), R, upper, "-")
            if not bool(sp.simplify(rise) >= 0):
                said = "The loss is not convex: its slope falls where its formula changes."
                return Answer("convex", Word.NO, said, f"at r = {side.sign}{upper}")
    start = sum(sp.limit(sp.diff(side.both[0][2], R), R, 0, "+") for side in term.sides)
    start = start * 2 if len(term.sides) == 1 else start
    if not bool(start >= 0):
        return Answer("convex", Word.NO, "The loss is not convex at r = 0.", "its slopes there")
    if undecided is not None:
        return Answer(
            "convex", Word.UNDECIDED, "Whether the loss is convex was not decided.", undecided.basis
        )
    return Answer("convex", Word.YES, "The loss is convex.", listed(steps))
