"""A loss and the weight that a reweighted loop uses for it: what is proved of the pair.

The objective has the term loss(r) of a residual r, or of its norm. The loop replaces it by weight(r_i)
square(r), with the residual r_i of the last iterate and square(r) = r**2 or r**2/2, minimises, and computes
the weights anew. The theorem (docs/reweighted.md) says what that descends: the term whose derivative is
weight(r) square'(r).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property, lru_cache
from itertools import pairwise, product
from types import MappingProxyType
from typing import Any

import sympy as sp
from flint import arb, fmpq

from convexperc.errors import InputError
from verification.exact.balls import UnresolvedError, precision
from verification.reweighted.answers import Answer, Answers, Word
from verification.reweighted.terms.deadline import at_most
from verification.reweighted.terms.dimensions import POWERS, degree
from verification.reweighted.terms.expressions import (
    VARIABLE,
    Given,
    Pieces,
    R,
    at,
    common,
    evaluate,
    exactly,
    half,
    pieces,
    read,
    substituted,
)
from verification.reweighted.terms.signs import BITS, Decision, never_positive, points

SQUARES = {"r**2": sp.Integer(1), "r**2/2": sp.Rational(1, 2)}
"""What a weight multiplies, and its factor."""

SECONDS = 20
"""Longest that SymPy may take for one question."""

DIGITS = 12
"""Of a ball that is shown."""

_NEAR = tuple(Fraction(2) ** k * m for k in (0, 1, -1, 2, -2, 4, -4, 8, -8) for m in (1, 3))
"""Sizes of residuals that are tried in pairs."""


@dataclass(frozen=True)
class Term:
    """A loss and its weight.

    Parameters
    ----------
    loss, weight : str, sympy expression or Python function
        Functions of r; see `expressions.read`.
    square : {"r**2", "r**2/2"}
        What the weight multiplies in the loop.
    widths : mapping of str to number
        Positive numbers of loss and weight, such as ``{"c": "1.345"}``, with the values at which they are
        judged.
    signed : bool
        Whether r is a residual that may be negative; else it is a norm.
    name : str

    Raises
    ------
    InputError
        A function or a value is not of that kind.
    """

    loss: Given
    weight: Given
    square: str = "r**2"
    widths: Mapping[str, Any] = field(default_factory=dict)
    signed: bool = False
    name: str = ""

    def __post_init__(self) -> None:
        if self.square not in SQUARES:
            raise InputError("square", value=self.square, must=f"must be one of {', '.join(SQUARES)}")
        for name, value in self.widths.items():
            if not str(name).isidentifier() or name == VARIABLE:
                must = f"must be a name other than {VARIABLE}"
                raise InputError("widths", value=name, must=must)
            if not exactly(value) > 0:
                raise InputError(f"widths[{name!r}]", value=value, must="must be a positive number")
        object.__setattr__(self, "widths", MappingProxyType(dict(self.widths)))
        _ = self.sides

    def __hash__(self) -> int:
        return hash((self.loss, self.weight, self.square, tuple(self.widths.items()), self.signed, self.name))

    @property
    def title(self) -> str:
        """The name, or the formulas."""
        loss, weight = (
            given if isinstance(given, str) else str(read)
            for given, read in ((self.loss, self.loss_expression), (self.weight, self.weight_expression))
        )
        return self.name or f"loss {loss}, weight {weight} of {self.square}"

    @property
    def factor(self) -> Any:
        """Of r**2 in the square: 1 or 1/2."""
        return SQUARES[self.square]

    @cached_property
    def loss_expression(self) -> Any:
        """The loss with its widths as symbols."""
        return read(self.loss, tuple(self.widths))

    @cached_property
    def weight_expression(self) -> Any:
        """The weight with its widths as symbols."""
        return read(self.weight, tuple(self.widths))

    @cached_property
    def sides(self) -> tuple["Side", ...]:
        """Loss and weight for r > 0 and, where r may be negative and they differ there, for r < 0."""
        return _sides(self)


@lru_cache(maxsize=4096)
def _sides(term: Term) -> tuple["Side", ...]:
    values = [substituted(each, term.widths) for each in (term.loss_expression, term.weight_expression)]
    loss, weight = (pieces(half(each)) for each in values)
    positive = Side("", loss, weight, term.factor)
    if not term.signed:
        return (positive,)
    loss, weight = (pieces(half(each, negative=True)) for each in values)
    negative = Side("-", loss, weight, term.factor)
    return (positive,) if negative.same_as(positive) else (positive, negative)


@dataclass(frozen=True)
class Side:
    """Loss and weight as functions of |r| on one side of 0.

    Attributes
    ----------
    sign : {"", "-"}
    loss, weight : Pieces
    factor : sympy number
        Of r**2.
    """

    sign: str
    loss: Pieces
    weight: Pieces
    factor: Any

    @cached_property
    def both(self) -> tuple[tuple[Any, Any, Any, Any], ...]:
        """(lower, upper, loss, weight) on each interval on which both have one formula."""
        return tuple(
            (a.lower, a.upper, a.expression, b.expression) for a, b in common(self.loss, self.weight)
        )

    def slope(self, weight: Any) -> Any:
        """Derivative of what the weight descends: weight(r) square'(r)."""
        return 2 * self.factor * weight * R

    def same_as(self, other: "Side") -> bool:
        """Whether both functions have the same formulas on the same intervals."""
        return all(
            len(mine) == len(theirs)
            and all(
                a.lower == b.lower and sp.simplify(a.expression - b.expression) == 0
                for a, b in zip(mine, theirs, strict=True)
            )
            for mine, theirs in ((self.loss, other.loss), (self.weight, other.weight))
        )

    def shown(self, point: Fraction) -> str:
        """A residual of this side, as text."""
        return f"{self.sign}{point}"


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
    descends, tangent = _within(_descends, term), _within(_tangent, term)
    if tangent.accuses and _smooths(term):
        tangent = replace(tangent, fault=False)
    rest = [_within(each, term) for each in (_majorises, _sign, _at_zero, _units)]
    return Answers(term.title, (tangent, *rest, descends, _within(_convex, term)))


def _within(question: Callable[[Term], Answer], term: Term) -> Answer:
    """The answer to a question, undecided where SymPy does not end in time or finds no form."""
    name = question.__name__.removeprefix("_").replace("_", " ")
    try:
        with at_most(SECONDS):
            return question(term)
    except (TimeoutError, NotImplementedError, RecursionError) as fault:
        why = f"not decided within {SECONDS} s" if isinstance(fault, TimeoutError) else f"SymPy: {fault}"
        return Answer(name, Word.UNDECIDED, "It was not decided.", why)


def _smooths(term: Term) -> bool:
    """Whether the weight is the tangent one of a kink at 0, smoothed: bounded there, the same far away."""
    return all(_is_smoothing(side) for side in term.sides)


def _is_smoothing(side: Side) -> bool:
    first, last = side.both[0], side.both[-1]
    kink = sp.limit(sp.diff(first[2], R) / R, R, 0, "+") is sp.oo
    bounded = sp.limit(first[3], R, 0, "+")
    far = sp.limit(side.slope(last[3]) / sp.diff(last[2], R), R, sp.oo) if sp.diff(last[2], R) != 0 else None
    unbounded = sp.limit(last[2], R, sp.oo) is sp.oo
    return bool(kink and unbounded and bounded.is_number and bounded.is_finite and far == 1)


def _tangent(term: Term) -> Answer:
    question, undecided = "tangent", False
    for side in term.sides:
        jump = _jump(side)
        if jump is not None:
            return jump
        for lower, upper, loss, weight in side.both:
            difference = _simplified(side.slope(weight) - sp.diff(loss, R))
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


def _simplified(difference: Any) -> Any:
    """The difference, 0 where SymPy finds that, also in exponentials for hyperbolic functions."""
    found = sp.simplify(difference)
    hyperbolic = found != 0 and found.has(sp.tanh, sp.sinh, sp.cosh, sp.coth)
    return sp.S.Zero if hyperbolic and sp.simplify(difference.rewrite(sp.exp)) == 0 else found


def _jump(side: Side) -> Answer | None:
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
    shown = {"r": side.shown(point), "slope of the loss": _text(wanted), "slope of the square": _text(got)}
    if factor is not None and factor.is_number:
        shown["factor"] = str(factor)
    if side.sign:
        shown |= {"slope of the loss": f"-({_text(wanted)})", "slope of the square": f"-({_text(got)})"}
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


def _majorises(term: Term) -> Answer:
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
    return Answer("majorises", Word.YES, said, _listed(steps))


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
    difference = (t * t - r * r) * Fraction(int(term.factor.p), int(term.factor.q))
    square = before + weight * fmpq(difference.numerator, difference.denominator)
    if not bool(arb(after) > arb(square)):
        return None
    return {"r_i": here.shown(r), "r": there.shown(t), "square": _text(square), "loss": _text(after)}


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
        "weight": _text(before),
        "larger r": side.shown(high),
        "weight there": _text(after),
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
        pair = [Fraction(int(each.p), int(each.q)) for each in (low, high)]
        with precision(BITS):
            try:
                values = [at(side.weight, each) for each in pair]
            except (InputError, UnresolvedError):
                continue
            if bool(arb(values[0]) < arb(values[1])):
                return _risen(side, pair[0], pair[1], *values)
    said = "Whether the weight jumps up where its formula changes was not decided."
    return Answer("majorises", Word.UNDECIDED, said, f"at r = {end}")


def _sign(term: Term) -> Answer:
    undecided, steps = None, []
    for side in term.sides:
        for lower, upper, _, weight in side.both:
            decision = never_positive(-weight, lower, upper)
            if decision.word is Word.NO:
                point = decision.point or Fraction(1)
                with precision(BITS):
                    value = evaluate(weight, fmpq(point.numerator, point.denominator))
                shown = {"r": side.shown(point), "weight": _text(value)}
                said = "The weight is negative: a square with it has no minimum of its own."
                return Answer("sign", Word.NO, said, decision.basis, shown, fault=True)
            undecided = decision if decision.word is Word.UNDECIDED else undecided
            steps.append(decision.basis)
    if undecided is not None:
        return Answer(
            "sign", Word.UNDECIDED, "Whether the weight is never negative was not decided.", undecided.basis
        )
    return Answer("sign", Word.YES, "The weight is never negative.", _listed(steps))


def _at_zero(term: Term) -> Answer:
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


def _units(term: Term) -> Answer:
    loss, weight = term.loss_expression, term.weight_expression
    stated = None
    for power in POWERS:
        powers = {"r": 1} | dict.fromkeys(term.widths, power)
        of_loss, of_weight = degree(loss, powers), degree(weight, powers)
        if of_loss is None:
            continue
        stated = power if stated is None else stated
        if of_weight is not None and (of_weight == of_loss - 2 or weight == 0):
            return Answer(
                "units", Word.YES, _units_said(term, power), "dimensional analysis of both formulas"
            )
        if not term.widths:
            break
    if stated is None:
        said = "The loss has numbers of its own unit, so that the question does not arise."
        return Answer("units", Word.UNDECIDED, said, "dimensional analysis of the loss")
    return _unit_fault(term, stated)


def _units_said(term: Term, power: Any) -> str:
    if not term.widths:
        return "In another unit of r the weight follows as the loss does."
    unit = {1: "the unit of r", 2: "the unit of r squared", 0: "no unit"}.get(
        power, f"the unit of r to the power {power}"
    )
    names = ", ".join(term.widths)
    return f"In another unit of r the weight follows as the loss does, if {names} has {unit}."


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
                    "weight": _text(weights[0]),
                    "r in the other unit": str(t * point),
                    "weight that follows": _text(wanted),
                    "weight there": _text(weights[1]),
                }
    return None


def _descends(term: Term) -> Answer:
    question = "descends"
    if any(_jump(side) is not None for side in term.sides):
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
        slope = _simplified(sp.diff(loss, R) - side.slope(weight))
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


def _convex(term: Term) -> Answer:
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
    return Answer("convex", Word.YES, "The loss is convex.", _listed(steps))


def _listed(steps: list[str]) -> str:
    return "; ".join(dict.fromkeys(filter(None, steps))) or "the sign of each factor can be read off"


def _text(value: Any) -> str:
    """A rational as it is, a ball to some digits."""
    return str(value) if isinstance(value, fmpq) else arb(value).str(DIGITS, radius=False)
