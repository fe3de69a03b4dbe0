"""Whether an expression keeps one sign on an interval: proved, or a rational point at which it does not.

A NO is a rational point at which ball arithmetic excludes the sign. A YES follows factor by factor:
polynomials, with each root and each exponential replaced by a variable of which only its equation and its
sign are used, by z3 and cvc5; what is left by the sign of the derivative and the limit at the lower end.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from typing import Any

import sympy as sp
from flint import arb, fmpq

from convexperc.errors import InputError
from verification.exact.balls import UnresolvedError, precision
from verification.proofs.checkers.formulas import names
from verification.proofs.checkers.reals import real
from verification.reweighted.answers import Word
from verification.reweighted.terms.expressions import VARIABLE, R, evaluate, fraction, simplest

BITS = 256
DEPTH = 3
"""Derivatives to try in turn."""

STEPS = 24
"""Points by which a bounded interval is divided, and octaves in which an unbounded one is searched."""


@dataclass(frozen=True)
class Decision:
    """Whether expression <= 0 throughout an interval.

    Attributes
    ----------
    word : Word
    basis : str
    point : Fraction or None
        For NO, where it is positive.
    """

    word: Word
    basis: str
    point: Fraction | None = None


def never_positive(expression: Any, lower: Any, upper: Any) -> Decision:
    """Decide whether a smooth expression in R is <= 0 on the open interval (lower, upper)."""
    point = positive_at(expression, lower, upper)
    if point is not None:
        return Decision(Word.NO, f"ball arithmetic at {VARIABLE} = {point}", point)
    steps = _below(expression, lower, upper, DEPTH)
    if steps is None:
        return Decision(Word.UNDECIDED, "neither proved nor contradicted")
    return Decision(Word.YES, "; ".join(dict.fromkeys(steps)))


def positive_at(expression: Any, lower: Any, upper: Any) -> Fraction | None:
    """The simplest of the points tried at which the expression is > 0 beyond doubt; None if there is none."""
    found = [point for point in points(lower, upper) if _is_positive(expression, point)]
    return min(found, key=lambda point: point.denominator + abs(point.numerator), default=None)


def points(lower: Any, upper: Any) -> Iterator[Fraction]:
    """Rational points inside an interval, from end to end."""
    low = _inside(lower, 1)
    if upper is sp.oo:
        ends = [low + Fraction(2) ** k for k in range(-STEPS, STEPS + 1)]
        yield from (simplest(left, right) for left, right in pairwise([low, *ends]))
        yield from ends
        return
    width = _inside(upper, -1) - low
    shares = [Fraction(1, 2**k) for k in range(STEPS, 4, -4)]
    shares += [Fraction(k, STEPS) for k in range(1, STEPS)] + [1 - share for share in reversed(shares)]
    ends = [low, *(low + width * share for share in shares), low + width]
    yield from (simplest(left, right) for left, right in pairwise(ends))


def _inside(end: Any, side: int) -> Fraction:
    """An end, or a rational point next to it, inside the interval."""
    found = _rational(end, side)
    return fraction(found)


def _is_positive(expression: Any, point: Fraction) -> bool:
    with precision(BITS):
        try:
            value = evaluate(expression, fmpq(point.numerator, point.denominator))
        except UnresolvedError:
            return False
        return bool(arb(value) > 0)


@dataclass(frozen=True)
class _Plain:
    """An expression with a variable for each root and each exponential, and what is known of them.

    Attributes
    ----------
    expression : sympy expression
    meanings : dict of sympy symbol to sympy expression
    facts : tuple of str
        One positive variable and its equation each, as the checkers read them.
    """

    expression: Any
    meanings: dict[Any, Any]
    facts: tuple[str, ...]


def _below(expression: Any, lower: Any, upper: Any, depth: int) -> list[str] | None:
    """Steps that prove expression <= 0; None if they are not found."""
    if expression.is_number:
        return [] if bool(expression <= 0) else None
    plain = _plain(expression)
    top, bottom = sp.fraction(sp.together(plain.expression))
    sign, steps = 1, []
    for factor in (*sp.Mul.make_args(sp.factor(top)), *sp.Mul.make_args(sp.factor(bottom))):
        known = _sign(factor, plain, (lower, upper), depth)
        if known is None:
            return None
        sign, more = sign * known[0], known[1]
        steps += more
    return steps if sign < 0 else None


def _plain(expression: Any) -> _Plain:
    """Replace each root of a polynomial and each exponential."""
    known: dict[Any, Any] = {}
    facts: list[str] = []
    replaced = {}
    for each in sorted(expression.atoms(sp.Pow, sp.exp), key=sp.default_sort_key):
        if isinstance(each, sp.exp):
            name = known.setdefault(each, sp.Symbol(f"e{len(known)}", positive=True))
            facts.append(f"{name} > 0")
            replaced[each] = name
        elif each.exp.is_Rational and not each.exp.is_Integer and each.base.is_polynomial(R):
            root = each.base ** sp.Rational(1, each.exp.q)
            if root not in known:
                known[root] = sp.Symbol(f"y{len(known)}", positive=True)
                facts += [f"{known[root]} > 0", f"{_text(known[root] ** each.exp.q - each.base)} == 0"]
            replaced[each] = known[root] ** each.exp.p
    return _Plain(expression.xreplace(replaced), {name: each for each, name in known.items()}, tuple(facts))


def _sign(factor: Any, plain: _Plain, where: tuple[Any, Any], depth: int) -> tuple[int, list[str]] | None:
    """1 if factor >= 0 on the interval, -1 if <= 0, with the steps; None if that is not found."""
    if factor.is_number:
        return (1 if bool(factor > 0) else -1), []
    if factor == R or factor in plain.meanings:
        return 1, []
    if factor.is_Pow:
        base = _sign(factor.base, plain, where, depth)
        even = factor.exp.is_Integer and factor.exp % 2 == 0
        if base is None or even:
            return (1, []) if even else None
        return base if factor.exp.is_Integer or base[0] > 0 else None
    meant = factor.xreplace(plain.meanings)
    guess = -1 if positive_at(-meant, *where) is not None else 1
    steps = _polynomial(-guess * factor, plain, where)
    if steps is None:
        steps = _known(-guess * meant, *where)
    if steps is None and depth > 0:
        steps = _by_derivative(-guess * meant, *where, depth)
    return None if steps is None else (guess, steps)


def _polynomial(expression: Any, plain: _Plain, where: tuple[Any, Any]) -> list[str] | None:
    """Prove a polynomial in R and the variables of roots and exponentials <= 0 by z3 and cvc5."""
    if not expression.is_polynomial():
        return None
    hypotheses = [*plain.facts, *_ends(*where)]
    try:
        conclusion = f"{_text(expression)} <= 0"
        meanings = {VARIABLE: "the residual"} | {
            str(name): str(each) for name, each in plain.meanings.items()
        }
        used = set(names(conclusion, *hypotheses))
        given = {name: meaning for name, meaning in meanings.items() if name in used}
        step = real("sign", "the sign on an interval", hypotheses, conclusion, **given)
    except (sp.PolynomialError, InputError):
        return None
    return [f"z3 and cvc5: {step.source}"] if step.passed else None


def _ends(lower: Any, upper: Any) -> list[str]:
    """The interval, or a larger one of rational ends."""
    found = [_text(_rational(lower, -1) - R) + " < 0"]
    return found if upper is sp.oo else [*found, _text(R - _rational(upper, 1)) + " < 0"]


def _rational(end: Any, side: int) -> Any:
    if end.is_Rational:
        return end
    unit = sp.Integer(2) ** 40
    return (sp.floor(end * unit) if side < 0 else sp.ceiling(end * unit)) / unit


def _text(polynomial: Any) -> str:
    """A polynomial with integer coefficients, as the checkers read it."""
    symbols = sorted(polynomial.free_symbols, key=str)
    if not symbols:
        return str(sp.Integer(sp.numer(polynomial)))
    terms = sp.Poly(polynomial, *symbols, domain="QQ").clear_denoms()[1].terms()
    return " + ".join(_monomial(coefficient, symbols, powers) for powers, coefficient in terms)


def _monomial(coefficient: Any, symbols: list[Any], powers: tuple[int, ...]) -> str:
    parts = [f"{symbol}**{power}" for symbol, power in zip(symbols, powers, strict=True) if power]
    return "*".join([f"({int(coefficient)})", *parts])


def _known(expression: Any, lower: Any, upper: Any) -> list[str] | None:
    """Signs of sines and cosines whose argument is R times a number."""
    sign = -1 if expression.could_extract_minus_sign() else 1
    inner = expression * sign
    if sign > 0 or upper is sp.oo or not isinstance(inner, sp.sin | sp.cos):
        return None
    reach = inner.args[0].subs(R, upper)
    within = sp.pi if isinstance(inner, sp.sin) else sp.pi / 2
    proper = inner.args[0].is_polynomial(R) and sp.degree(inner.args[0], R) == 1
    if proper and bool(inner.args[0].subs(R, lower) >= 0) and bool(reach <= within):
        return [f"{inner} >= 0 up to {VARIABLE} = {upper}"]
    return None


def _by_derivative(expression: Any, lower: Any, upper: Any, depth: int) -> list[str] | None:
    """Prove it <= 0 because it is so in the limit at the lower end, and never rises."""
    start = sp.limit(expression, R, lower, "+")
    if not start.is_number or start.has(sp.nan, sp.zoo) or not bool(start <= 0):
        return None
    steps = _below(sp.simplify(sp.diff(expression, R)), lower, upper, depth - 1)
    return None if steps is None else [f"{expression} tends to {start} and never rises", *steps]


def listed(steps: list[str]) -> str:
    """The reasons of several decisions, each once."""
    return "; ".join(dict.fromkeys(filter(None, steps))) or "the sign of each factor can be read off"
