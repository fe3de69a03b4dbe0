"""Dimensional analysis: by which power of a unit an expression is multiplied when its symbols are."""

from collections.abc import Iterable, Mapping
from typing import Any

import sympy as sp

POWERS = (1, 2, sp.Rational(1, 2), -1, 0)
"""Units that a width may have, as powers of the unit of the residual."""


def degree(expression: Any, powers: Mapping[str, Any]) -> Any:
    """The power k with f(t^p x) = t^k f(x) for every t > 0; None if this analysis finds none.

    Parameters
    ----------
    expression : sympy expression
    powers : mapping of str to number
        Of each symbol, by name.

    Returns
    -------
    sympy number or None
        A number is proof: each sum has terms of one degree, each exponent, exponential, logarithm, sine and
        each condition compares or takes what is free of units. None is no proof of the contrary.
    """
    found = None
    if expression.is_number:
        found = sp.S.Zero
    elif expression.is_Symbol:
        found = sp.sympify(powers[expression.name])
    elif expression.is_Add or isinstance(expression, sp.Abs | sp.Max | sp.Min):
        found = _same(expression.args, powers)
    elif expression.is_Mul:
        parts = [degree(part, powers) for part in expression.args]
        found = None if None in parts else sum(parts)
    elif expression.is_Pow:
        inner = degree(expression.base, powers)
        found = None if inner is None or not expression.exp.is_number else inner * expression.exp
    elif isinstance(expression, sp.Piecewise):
        found = _piecewise(expression, powers)
    elif isinstance(expression, sp.Function):
        found = sp.S.Zero if all(degree(part, powers) == 0 for part in expression.args) else None
    return found


def unit_of_widths(loss: Any, weight: Any, widths: Iterable[str]) -> tuple[Any, Any, bool] | None:
    """The unit of the widths of a loss and a weight, as a power of that of r.

    Parameters
    ----------
    loss, weight : sympy expression
    widths : iterable of str

    Returns
    -------
    (power, degree, bool) or None
        The first of `POWERS` with which loss and weight are the same up to factors of one unit, the degree of
        the loss with it, and True; else the first with which the loss is, and False; None if there is none.
    """
    names, stated = list(widths), None
    for power in POWERS if names else POWERS[:1]:
        powers = {"r": 1} | dict.fromkeys(names, power)
        of_loss, of_weight = degree(loss, powers), degree(weight, powers)
        if of_loss is None:
            continue
        if of_weight is not None and (of_weight == of_loss - 2 or weight == 0):
            return power, of_loss, True
        stated = stated or (power, of_loss, False)
    return stated


def _same(parts: Any, powers: Mapping[str, Any]) -> Any:
    """The common degree of parts; 0 as a number has any degree."""
    found = {degree(part, powers) for part in parts if part != 0}
    return found.pop() if len(found) == 1 else None


def _piecewise(expression: Any, powers: Mapping[str, Any]) -> Any:
    for _, condition in expression.args:
        for relation in condition.atoms(sp.core.relational.Relational):
            if _same((relation.lhs, relation.rhs), powers) is None:
                return None
    return _same([formula for formula, _ in expression.args], powers)
