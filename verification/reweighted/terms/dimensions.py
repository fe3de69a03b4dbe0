"""Dimensional analysis: by which power of a unit an expression is multiplied when its symbols are."""

from collections.abc import Mapping
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
