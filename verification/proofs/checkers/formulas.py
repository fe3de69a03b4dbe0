"""The small language of the checkers: arithmetic, comparisons, `abs`, `and`, `or`, `not`, `.T`.

A formula is text, so that the machine checks exactly what the report prints. Each checker evaluates it over
values of its own (`Domain`). The words beside a formula are a gloss, which may state nothing that the formula
does not (`legend`).
"""

import ast
import operator
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import reduce
from typing import Any, Protocol

from convexperc.errors import InputError


class Domain(Protocol):
    """What the names, the numbers and the few operations without a Python operator mean."""

    def name(self, name: str) -> Any:
        """Value of a name."""

    def number(self, value: int) -> Any:
        """Value of an integer literal."""

    def divide(self, left: Any, right: Any) -> Any:
        """Quotient; refused by `InputError` where it might not exist."""

    def absolute(self, value: Any) -> Any:
        """|value|."""

    def every(self, values: list[Any]) -> Any:
        """Conjunction."""

    def some(self, values: list[Any]) -> Any:
        """Disjunction."""

    def negation(self, value: Any) -> Any:
        """Negation of a statement."""


COMPARISONS: dict[type[ast.cmpop], Callable[[Any, Any], Any]] = {
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
}


STATED = re.compile(r"[<>=]|\b(?:for (?:all|any|each|every)|always|everywhere|never)\b")
"""What states a relation or a range: left to the formula, so that a gloss claims no more than was checked."""


def legend(gloss: str, where: Mapping[str, str], used: Iterable[str]) -> str:
    """Check the words beside a formula, and write down what its names stand for.

    Parameters
    ----------
    gloss : str
        What the step is for, in words.
    where : mapping of str to str
        The meaning of names, in the notation of the paper.
    used : iterable of str
        The names to be explained: all in the formula but those that mean the same everywhere.

    Returns
    -------
    str
        "r: ||x||; s: ||y||".

    Raises
    ------
    InputError
        A gloss or a meaning states a relation, a name has no meaning, or a meaning no name.
    """
    for text in (gloss, *where.values()):
        if STATED.search(text):
            raise refused(text, "must leave relations and ranges to the formula that is checked")
    if odd := set(used) ^ set(where):
        raise refused(", ".join(sorted(odd)), "must be in the formula and have a meaning")
    return "; ".join(f"{name}: {meaning}" for name, meaning in where.items())


def refused(text: str, why: str) -> InputError:
    """Build the error for a formula that a checker cannot take."""
    return InputError("formula", value=text, must=why)


def names(*texts: str) -> tuple[str, ...]:
    """All names in the formulas, sorted; `abs` is not one."""
    found = {node.id for text in texts for node in ast.walk(_tree(text)) if isinstance(node, ast.Name)}
    return tuple(sorted(found - {"abs"}))


def evaluate(text: str, domain: Domain) -> Any:
    """Evaluate a formula.

    Parameters
    ----------
    text : str
    domain : Domain

    Returns
    -------
    object
        Of the domain's kind.

    Raises
    ------
    InputError
        The text is not a formula, or holds what the domain refuses.
    """
    return _Reader(text, domain).value(_tree(text))


@dataclass(frozen=True)
class _Reader:
    """A formula being evaluated."""

    text: str
    domain: Domain

    def value(self, node: ast.expr) -> Any:
        match node:
            case ast.Constant(value=int(number)) if not isinstance(number, bool):
                result = self.domain.number(number)
            case ast.Name(id=name):
                result = self.domain.name(name)
            case ast.Attribute(value=inner, attr="T"):
                result = self.value(inner).T
            case ast.Call(func=ast.Name(id="abs"), args=[inner], keywords=[]):
                result = self.domain.absolute(self.value(inner))
            case ast.BinOp(left=left, op=op, right=right):
                result = self.arithmetic(op, left, right)
            case ast.Compare(left=left, ops=ops, comparators=others):
                result = self.comparison([left, *others], ops)
            case _:
                result = self.logic(node)
        return result

    def logic(self, node: ast.expr) -> Any:
        match node:
            case ast.UnaryOp(op=ast.USub(), operand=inner):
                return self.domain.number(-1) * self.value(inner)
            case ast.UnaryOp(op=ast.Not(), operand=inner):
                return self.domain.negation(self.value(inner))
            case ast.BoolOp(op=ast.And(), values=parts):
                return self.domain.every([self.value(part) for part in parts])
            case ast.BoolOp(op=ast.Or(), values=parts):
                return self.domain.some([self.value(part) for part in parts])
        raise refused(self.text, f"must not hold {ast.unparse(node)}")

    def arithmetic(self, op: ast.operator, left: ast.expr, right: ast.expr) -> Any:
        first = self.value(left)
        match op, right:
            case ast.Add(), _:
                return first + self.value(right)
            case ast.Sub(), _:
                return first + self.domain.number(-1) * self.value(right)
            case ast.Mult(), _:
                return first * self.value(right)
            case ast.Div(), _:
                return self.domain.divide(first, self.value(right))
            case ast.Pow(), ast.Constant(value=int(power)) if power >= 1:
                return reduce(operator.mul, [first] * power)
        raise refused(self.text, "must use + - * / and powers by positive integers")

    def comparison(self, terms: list[ast.expr], ops: list[ast.cmpop]) -> Any:
        if not all(type(op) in COMPARISONS for op in ops):
            raise refused(self.text, "must compare by < <= > >= == !=")
        values = [self.value(term) for term in terms]
        pairs = zip(ops, values, values[1:], strict=False)
        return self.domain.every([COMPARISONS[type(op)](a, b) for op, a, b in pairs])


def _tree(text: str) -> ast.expr:
    try:
        return ast.parse(text, mode="eval").body
    except SyntaxError:
        raise refused(text, "must be a formula") from None
