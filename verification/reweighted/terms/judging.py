"""What is proved of a loss and its weight: one answer to each question."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from fractions import Fraction
from functools import lru_cache
from typing import Any

import sympy as sp
from flint import fmpq

from verification.exact.balls import precision
from verification.reweighted.answers import Answer, Answers, Word
from verification.reweighted.terms.deadline import at_most
from verification.reweighted.terms.descent import convex, descends
from verification.reweighted.terms.expressions import (
    Given,
    R,
    evaluate,
)
from verification.reweighted.terms.majorising import majorises
from verification.reweighted.terms.signs import BITS, listed, never_positive
from verification.reweighted.terms.tangency import is_smoothing, tangent
from verification.reweighted.terms.term import Term, text
from verification.reweighted.terms.units import units

SECONDS = 20
"""Longest that SymPy may take for one question."""


def judge_term(
    loss: Given | Term,
    weight: Given | None = None,
    *,
    square: str = "r**2",
    widths: Mapping[str, Any] | None = None,
    signed: bool = False,
    name: str = "",
) -> Answers:
    """Judge a loss and the weight that a loop uses for it.

    Parameters
    ----------
    loss : Term, or str, sympy expression or Python function
        A term, or the function of r that the objective has.
    weight : str, sympy expression or Python function
        Of r, at the last iterate; not with a `Term`.
    square : {"r**2", "r**2/2"}
        What the weight multiplies in the loop.
    widths : mapping of str to number
        Positive numbers of loss and weight, with the values at which they are judged.
    signed : bool
        Whether r may be negative; else it is a norm.
    name : str

    Returns
    -------
    Answers
        ``tangent``: is weight(r) square'(r) = loss'(r)? ``majorises``: is the weight non-increasing, so
        that the weighted square lies above what the weight descends, and touches it at r_i? ``sign``: is
        the weight >= 0? ``at zero``: is it finite there? ``units``: does it follow a change of the unit of
        r, as the loss does? ``descends``: which loss the loop descends, and how far that is from the stated
        one. ``convex``: is that loss convex? The first three and ``units`` may speak against the pair
        (``fault``).

    Raises
    ------
    InputError
        A formula is not of the kind that can be decided; see `expressions.read`.

    Examples
    --------
    >>> judge_term("r", "1/r")["tangent"].statement
    'The weight is 2 times the tangent one: it is that of 2 times the stated loss.'
    """
    term = loss if isinstance(loss, Term) else Term(loss, weight or "", square, widths or {}, signed, name)
    return _judged(term)


@lru_cache(maxsize=4096)
def _judged(term: Term) -> Answers:
    descent, tangency = _within(descends, term), _within(tangent, term)
    if tangency.accuses and is_smoothing(term):
        tangency = replace(tangency, fault=False)
    rest = [_within(each, term) for each in (majorises, sign, at_zero, units)]
    return Answers(term.title, (tangency, *rest, descent, _within(convex, term)))


def _within(question: Callable[[Term], Answer], term: Term) -> Answer:
    """The answer to a question, undecided where SymPy does not end in time or finds no form."""
    name = question.__name__.replace("_", " ")
    try:
        with at_most(SECONDS):
            return question(term)
    except (TimeoutError, NotImplementedError, RecursionError) as fault:
        why = f"not decided within {SECONDS} s" if isinstance(fault, TimeoutError) else f"SymPy: {fault}"
        return Answer(name, Word.UNDECIDED, "It was not decided.", why)


def sign(term: Term) -> Answer:
    """Say whether the weight is >= 0."""
    undecided, steps = None, []
    for side in term.sides:
        for lower, upper, _, weight in side.both:
            decision = never_positive(-weight, lower, upper)
            if decision.word is Word.NO:
                point = decision.point or Fraction(1)
                with precision(BITS):
                    value = evaluate(weight, fmpq(point.numerator, point.denominator))
                shown = {"r": side.shown(point), "weight": text(value)}
                said = "The weight is negative: a square with it has no minimum of its own."
                return Answer("sign", Word.NO, said, decision.basis, shown, fault=True)
            undecided = decision if decision.word is Word.UNDECIDED else undecided
            steps.append(decision.basis)
    if undecided is not None:
        return Answer(
            "sign", Word.UNDECIDED, "Whether the weight is never negative was not decided.", undecided.basis
        )
    return Answer("sign", Word.YES, "The weight is never negative.", listed(steps))


def at_zero(term: Term) -> Answer:
    """Say whether the weight is finite at 0."""
    found = {}
    for side in term.sides:
        found[side.sign] = sp.limit(side.both[0][3], R, 0, "+")
    basis = "limit by SymPy"
    if any(value in (sp.oo, -sp.oo) for value in found.values()):
        said = "The weight grows without bound as r tends to 0: at a residual of exactly 0 it does not exist."
        return Answer("at zero", Word.NO, said, basis)
    if all(value.is_number and value.is_finite for value in found.values()):
        shown = ", ".join(str(value) for value in dict.fromkeys(found.values()))
        return Answer("at zero", Word.YES, f"The weight tends to {shown} as r tends to 0.", basis)
    return Answer("at zero", Word.UNDECIDED, "The limit of the weight at 0 was not found.", basis)
