"""A loss and the weight that a reweighted loop uses for it.

The objective has the term loss(r) of a residual r, or of its norm. The loop replaces it by weight(r_i)
square(r), with the residual r_i of the last iterate and square(r) = r**2 or r**2/2, minimises, and computes
the weights anew. The theorem (docs/reweighted.md) says what that descends: the term whose derivative is
weight(r) square'(r).
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property, lru_cache
from types import MappingProxyType
from typing import Any

import sympy as sp
from flint import arb, fmpq

from convexperc.errors import InputError
from verification.reweighted.terms.expressions import (
    VARIABLE,
    Given,
    Pieces,
    R,
    common,
    exactly,
    half,
    pieces,
    read,
    substituted,
)

SQUARES = {"r**2": sp.Integer(1), "r**2/2": sp.Rational(1, 2)}
"""What a weight multiplies, and its factor."""


DIGITS = 12
"""Of a ball that is shown."""


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


def text(value: Any) -> str:
    """A rational as it is, a ball to some digits."""
    return str(value) if isinstance(value, fmpq) else arb(value).str(DIGITS, radius=False)
