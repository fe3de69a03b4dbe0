"""Identities in commuting variables, and statements about given rational numbers: both decided exactly."""

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from flint import Ordering, fmpq_mpoly_ctx

from verification.ledger.evidence import Checker, Step
from verification.proofs.checkers.formulas import evaluate, legend, names, refused


def identity(name: str, gloss: str, left: str, right: str, **where: str) -> Step:
    """Check that two rational functions with rational coefficients are the same.

    Formula: a/b = c/e as rational functions if and only if the polynomials a e and c b, expanded, are equal.
    The equation then holds wherever no denominator is 0.

    Parameters
    ----------
    name : str
        How the written proof refers to the step.
    gloss : str
        What the step is for, in words.
    left, right : str
        Formulas; every name is a variable.
    **where : str
        What the variables stand for.

    Returns
    -------
    Step

    Raises
    ------
    InputError
        A text is not a formula of this kind, divides by the zero polynomial, or see `legend`.
    """
    used = names(left, right)
    meaning = legend(gloss, where, used)
    domain = _Functions.of(used or ("x",))
    first, second = evaluate(left, domain), evaluate(right, domain)
    passed = bool(first.top * second.bottom == second.top * first.bottom)
    return Step(f"{name}: {gloss}", Checker.IDENTITY, passed, f"{left} = {right}", meaning)


def exact(name: str, gloss: str, formula: str, given: str) -> Step:
    """Evaluate a statement about given rational numbers, without variables, in exact arithmetic.

    Parameters
    ----------
    name, gloss : str
        As of `identity`.
    formula : str
    given : str
        The data whose numbers stand in the formula: "X = o = 1".

    Raises
    ------
    InputError
        The text is not a formula, holds a variable, or divides by 0; or see `legend`.
    """
    legend(gloss, {}, ())
    passed = evaluate(formula, _Rationals(formula)) is True
    return Step(f"{name}: {gloss}", Checker.EXACT, passed, formula, given)


@dataclass(frozen=True)
class _Quotient:
    """top / bottom, two polynomials."""

    top: Any
    bottom: Any

    def __add__(self, other: "_Quotient") -> "_Quotient":
        return _Quotient(self.top * other.bottom + other.top * self.bottom, self.bottom * other.bottom)

    def __mul__(self, other: "_Quotient") -> "_Quotient":
        return _Quotient(self.top * other.top, self.bottom * other.bottom)


class _Plain:
    """A domain without statements."""

    def absolute(self, value: Any) -> Any:
        raise refused("abs", "must not stand in an identity")

    def every(self, values: list[Any]) -> Any:
        raise refused("and", "must not stand in an identity")

    def some(self, values: list[Any]) -> Any:
        raise refused("or", "must not stand in an identity")

    def negation(self, value: Any) -> Any:
        raise refused("not", "must not stand in an identity")


@dataclass(frozen=True)
class _Functions(_Plain):
    """Rational functions of the variables."""

    one: Any
    variables: dict[str, Any]

    @classmethod
    def of(cls, variables: tuple[str, ...]) -> "_Functions":
        context = fmpq_mpoly_ctx.get(variables, Ordering.lex)
        return cls(
            context.from_dict({(0,) * len(variables): 1}), dict(zip(variables, context.gens(), strict=True))
        )

    def name(self, name: str) -> _Quotient:
        return _Quotient(self.variables[name], self.one)

    def number(self, value: int) -> _Quotient:
        return _Quotient(self.one * value, self.one)

    def divide(self, left: _Quotient, right: _Quotient) -> _Quotient:
        if right.top == 0:
            raise refused(f"division by {right.top}", "must divide by a polynomial that is not 0")
        return _Quotient(left.top * right.bottom, left.bottom * right.top)


@dataclass(frozen=True)
class _Rationals:
    """Fractions and truth values."""

    text: str

    def name(self, name: str) -> Any:
        raise refused(self.text, f"must hold numbers only, not {name}")

    def number(self, value: int) -> Fraction:
        return Fraction(value)

    def divide(self, left: Fraction, right: Fraction) -> Fraction:
        if right == 0:
            raise refused(self.text, "must not divide by 0")
        return left / right

    def absolute(self, value: Fraction) -> Fraction:
        return abs(value)

    def every(self, values: list[bool]) -> bool:
        return all(values)

    def some(self, values: list[bool]) -> bool:
        return any(values)

    def negation(self, value: bool) -> bool:
        return not value
