"""Functions of one variable, exactly: read from text or from Python, cut into pieces, evaluated in balls."""

import ast
import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import floor
from typing import Any, TypeAlias

import sympy as sp
from flint import arb, fmpq

from convexperc.errors import InputError
from verification.exact.balls import UnresolvedError

VARIABLE = "r"
"""The residual, or its norm."""

R = sp.Symbol(VARIABLE, positive=True)
"""A positive residual; a negative one is -R."""

FUNCTIONS: dict[str, Callable[..., Any]] = {
    "abs": sp.Abs,
    "atan": sp.atan,
    "cos": sp.cos,
    "exp": sp.exp,
    "log": sp.log,
    "max": sp.Max,
    "min": sp.Min,
    "sin": sp.sin,
    "sqrt": sp.sqrt,
    "tanh": sp.tanh,
}
CONSTANTS = {"pi": sp.pi}
CONSTANT_BALLS: dict[Any, Callable[[], Any]] = {sp.pi: arb.pi, sp.E: lambda: arb(1).exp()}
BALL_FUNCTIONS: dict[Any, Callable[[Any], Any]] = {
    sp.exp: arb.exp,
    sp.log: arb.log,
    sp.sin: arb.sin,
    sp.cos: arb.cos,
    sp.atan: arb.atan,
    sp.tanh: arb.tanh,
    sp.sinh: arb.sinh,
    sp.cosh: arb.cosh,
    sp.coth: arb.coth,
    sp.tan: arb.tan,
}
RELATIONS: dict[type[ast.cmpop], Callable[..., Any]] = {
    ast.Lt: sp.StrictLessThan,
    ast.LtE: sp.LessThan,
    ast.Gt: sp.StrictGreaterThan,
    ast.GtE: sp.GreaterThan,
}
OPERATIONS: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: lambda a, b: a + b,
    ast.Sub: lambda a, b: a - b,
    ast.Mult: lambda a, b: a * b,
    ast.Div: lambda a, b: a / b,
    ast.Pow: lambda a, b: a**b,
}

LARGEST_POWER = 20

Given: TypeAlias = Any
"""A function of r: text, a SymPy expression, or a Python function that takes one."""


@dataclass(frozen=True)
class Piece:
    """A smooth expression of R on an open interval.

    Attributes
    ----------
    lower, upper : sympy number
        0 <= lower < upper <= oo.
    expression : sympy expression
    """

    lower: Any
    upper: Any
    expression: Any


Pieces = tuple[Piece, ...]
"""A function on (0, oo), in order; at a common end either value may hold."""


def symbol(name: str) -> sp.Symbol:
    """The symbol of a width or another positive number."""
    return sp.Symbol(name, positive=True)


def signed_variable() -> sp.Symbol:
    """The symbol r of a residual that may be negative."""
    return sp.Symbol(VARIABLE, real=True)


def read(given: Given, names: Sequence[str] = ()) -> sp.Expr:
    """A function of r, as an expression in `signed_variable` and the symbols of `names`.

    Parameters
    ----------
    given : str, sympy expression or Python function
        Text has numbers, r, `names`, pi, + - * / **, `a if r <= c else b`, and the functions abs, atan, cos,
        exp, log, max, min, sin, sqrt, tanh. Decimal numbers are taken as the decimal fractions that they are.
    names : sequence of str
        Of other positive numbers in it.

    Raises
    ------
    InputError
        It is something else.
    """
    if isinstance(given, str):
        try:
            tree = ast.parse(str(given).strip(), mode="eval").body
        except (SyntaxError, ValueError):
            raise _refused(given, "must be a formula") from None
        return sp.sympify(_Reader(given, tuple(names)).value(tree))
    if isinstance(given, sp.Basic):
        known = {VARIABLE: signed_variable(), **{name: symbol(name) for name in names}}
        odd = sorted({each.name for each in given.free_symbols} - set(known))
        if odd:
            raise _refused(str(given), f"must have no symbols but {', '.join(known)}, not {', '.join(odd)}")
        return given.subs({each: known[each.name] for each in given.free_symbols})
    if callable(given):
        try:
            found = given(signed_variable())
        except Exception as fault:
            raised = type(fault).__name__
            must = f"must take a SymPy symbol (it raised {raised}); `judge_functions` measures others"
            raise _refused(repr(given), must) from None
        if not isinstance(found, sp.Expr | int | float | Fraction):
            raise _refused(repr(found), "must be an expression of r")
        return sp.sympify(found)
    raise _refused(repr(given), "must be text, a SymPy expression or a Python function")


def _refused(text: str, must: str) -> InputError:
    return InputError("function of r", value=text, must=must)


@dataclass(frozen=True)
class _Reader:
    """Text being read; no text is ever run."""

    text: str
    names: tuple[str, ...]

    def value(self, node: ast.expr) -> Any:
        match node:
            case ast.Constant(value=int() | float() as number) if not isinstance(number, bool):
                return sp.Rational(repr(number))
            case ast.Name(id=name):
                return self.name(name)
            case ast.UnaryOp(op=ast.USub(), operand=inner):
                return -self.value(inner)
            case ast.BinOp(left=left, op=op, right=right) if type(op) in OPERATIONS:
                first, second = self.value(left), self.value(right)
                if isinstance(op, ast.Pow) and second.is_number and abs(second) > LARGEST_POWER:
                    raise _refused(self.text, f"must have powers up to {LARGEST_POWER}")
                return OPERATIONS[type(op)](first, second)
            case ast.Call(func=ast.Name(id=name), args=args, keywords=[]) if name in FUNCTIONS:
                return FUNCTIONS[name](*(self.value(arg) for arg in args))
            case ast.IfExp(test=test, body=body, orelse=other):
                return sp.Piecewise((self.value(body), self.condition(test)), (self.value(other), True))
        raise _refused(self.text, f"must not hold {ast.unparse(node)}")

    def name(self, name: str) -> Any:
        if name == VARIABLE:
            return signed_variable()
        if name in self.names:
            return symbol(name)
        if name in CONSTANTS:
            return CONSTANTS[name]
        known = ", ".join((VARIABLE, *self.names, *CONSTANTS))
        raise _refused(self.text, f"must have no names but {known}, not {name}")

    def condition(self, node: ast.expr) -> Any:
        match node:
            case ast.Compare(left=left, ops=[op], comparators=[right]) if type(op) in RELATIONS:
                return RELATIONS[type(op)](self.value(left), self.value(right))
            case ast.BoolOp(op=op, values=values):
                parts = [self.condition(value) for value in values]
                return sp.And(*parts) if isinstance(op, ast.And) else sp.Or(*parts)
        raise _refused(self.text, f"must compare by < <= > >=, not {ast.unparse(node)}")


def half(expression: Any, *, negative: bool = False) -> Any:
    """The function on one side of 0, as an expression in R > 0: f(R), or f(-R)."""
    return expression.subs(dict.fromkeys(_variables(expression), -R if negative else R))


def _variables(expression: Any) -> list[Any]:
    return [each for each in expression.free_symbols if each.name == VARIABLE]


def pieces(expression: Any) -> Pieces:
    """Cut an expression in R, without other symbols, into smooth pieces on (0, oo).

    Raises
    ------
    InputError
        Where it changes its formula is not the root of a polynomial.
    """
    odd = sorted(str(each) for each in expression.free_symbols - {R})
    if odd:
        raise _refused(str(expression), f"must have a value for {', '.join(odd)}")
    return _joined(_cut(sp.sympify(expression), Piece(sp.S.Zero, sp.oo, R)))


def _cut(expression: Any, where: Piece) -> list[Piece]:
    """The pieces of an expression on one interval."""
    switch = next(iter(_switches(expression)), None)
    if switch is None:
        return [Piece(where.lower, where.upper, expression)]
    found = []
    for part, chosen in _choices(switch, where):
        found += _cut(expression.xreplace({switch: chosen}), part)
    return found


def _switches(expression: Any) -> list[Any]:
    """What chooses a formula by R, innermost first."""
    kinds = (sp.Piecewise, sp.Max, sp.Min, sp.Abs, sp.sign, sp.Heaviside)
    found = [each for each in sp.postorder_traversal(expression) if isinstance(each, kinds)]
    for each in found:
        if isinstance(each, sp.sign | sp.Heaviside):
            raise _refused(str(expression), "must say `a if r <= c else b` where it chooses")
    return found


def _choices(switch: Any, where: Piece) -> list[tuple[Piece, Any]]:
    """The intervals in `where` on which a switch has one formula, and that formula."""
    compared = _compared(switch)
    ends = [where.lower, *_changes(compared, where), where.upper]
    found = []
    for lower, upper in itertools.pairwise(ends):
        middle = _between(lower, upper)
        found.append((Piece(lower, upper, R), _chosen(switch, middle)))
    return found


def _compared(switch: Any) -> list[Any]:
    """The expressions whose zeros are the points where a switch may change."""
    if isinstance(switch, sp.Abs):
        return [switch.args[0]]
    if isinstance(switch, sp.Max | sp.Min):
        args = switch.args
        return [a - b for i, a in enumerate(args) for b in args[i + 1 :]]
    relations = [
        each for _, condition in switch.args for each in condition.atoms(sp.core.relational.Relational)
    ]
    return [relation.lhs - relation.rhs for relation in relations]


def _changes(compared: Sequence[Any], where: Piece) -> list[Any]:
    """Zeros inside an interval, sorted."""
    found = set()
    for expression in compared:
        top = sp.numer(sp.together(expression))
        try:
            polynomial = sp.Poly(top, R, extension=True)
        except sp.PolynomialError:
            raise _refused(str(expression), "must compare polynomials of r") from None
        if polynomial.degree() > 0:
            found |= (
                set(sp.real_roots(polynomial))
                if polynomial.domain.is_QQ or polynomial.domain.is_ZZ
                else ({root for root in sp.roots(polynomial) if root.is_real})
            )
    inside = [root for root in found if bool(root > where.lower) and bool(root < where.upper)]
    return sorted(inside, key=lambda root: sp.N(root, 50))


def _between(lower: Any, upper: Any) -> Any:
    """A rational point strictly inside an interval."""
    if upper is sp.oo:
        return sp.ceiling(lower) + 1
    low, high = (end if end.is_Rational else sp.Rational(str(sp.N(end, 50))) for end in (lower, upper))
    middle = simplest(*(fraction(end) for end in (low, high)))
    return sp.Rational(middle.numerator, middle.denominator)


def simplest(lower: Fraction, upper: Fraction) -> Fraction:
    """A rational of small denominator strictly between two."""
    denominator = 1
    while True:
        found = Fraction(floor(lower * denominator) + 1, denominator)
        if found < upper:
            return found
        denominator *= 2


def _chosen(switch: Any, point: Any) -> Any:
    """The formula that a switch has at a point that is no change."""
    if isinstance(switch, sp.Abs):
        inner = switch.args[0]
        return inner if bool(inner.subs(R, point) >= 0) else -inner
    if isinstance(switch, sp.Max | sp.Min):
        choose = max if isinstance(switch, sp.Max) else min
        return choose(switch.args, key=lambda each: sp.N(each.subs(R, point), 50))
    for formula, condition in switch.args:
        if condition is sp.true or bool(condition.subs(R, point)):
            return formula
    raise _refused(str(switch), "must say what it is for every r")


def _joined(found: list[Piece]) -> Pieces:
    """Neighbours of one formula made one."""
    joined: list[Piece] = []
    for piece in found:
        if joined and joined[-1].expression == piece.expression:
            joined[-1] = Piece(joined[-1].lower, piece.upper, piece.expression)
        else:
            joined.append(piece)
    return tuple(joined)


def common(first: Pieces, second: Pieces) -> list[tuple[Piece, Piece]]:
    """Both functions cut at the changes of either."""
    ends = {piece.lower for piece in (*first, *second)} | {sp.oo}
    order = sorted(ends, key=lambda end: sp.N(end, 50))
    return [
        (_on(first, lower, upper), _on(second, lower, upper)) for lower, upper in itertools.pairwise(order)
    ]


def _on(function: Pieces, lower: Any, upper: Any) -> Piece:
    middle = _between(lower, upper)
    piece = next(each for each in function if bool(each.lower < middle) and bool(middle < each.upper))
    return Piece(lower, upper, piece.expression)


def at(function: Pieces, point: Fraction) -> Any:
    """The value at a positive rational that is no change, as a ball or a rational; see `evaluate`."""
    where = sp.Rational(point.numerator, point.denominator)
    for piece in function:
        if bool(piece.lower < where) and bool(where < piece.upper):
            return evaluate(piece.expression, fmpq(point.numerator, point.denominator))
    raise InputError("r", value=str(point), must="must be inside a piece of the function")


def evaluate(expression: Any, value: Any) -> Any:
    """Evaluate a smooth expression in R at a rational or a ball: a ball that contains the true value.

    Raises
    ------
    UnresolvedError
        It divides by a ball that contains 0, or takes the root or the logarithm of one that is not positive.
    """
    if expression.is_Rational:
        return fmpq(int(expression.p), int(expression.q))
    if expression.is_Symbol or expression in CONSTANT_BALLS:
        return value if expression.is_Symbol else CONSTANT_BALLS[expression]()
    if expression.is_Add or expression.is_Mul:
        return _folded(expression.is_Add, [evaluate(part, value) for part in expression.args])
    if expression.is_Pow:
        return _power(evaluate(expression.base, value), expression.exp, value)
    if expression.func in BALL_FUNCTIONS:
        inner = arb(evaluate(expression.args[0], value))
        if expression.func is sp.log and not inner > 0:
            raise UnresolvedError("a logarithm", value=str(inner), must="must be of a positive number")
        return BALL_FUNCTIONS[expression.func](inner)
    raise _refused(str(expression), "must be made of + - * / ** and known functions")


def _folded(adding: bool, parts: list[Any]) -> Any:
    result = parts[0]
    for part in parts[1:]:
        result = result + part if adding else result * part
    return result


def _power(base: Any, exponent: Any, value: Any) -> Any:
    if exponent.is_Integer:
        if exponent < 0 and (base == 0 or (isinstance(base, arb) and base.contains(0))):
            raise UnresolvedError("a divisor", value=str(base), must="must exclude 0")
        power = int(exponent)
        return base**power if power >= 0 else 1 / base ** (-power)
    if not arb(base) > 0:
        if base == 0 and exponent.is_Rational and exponent > 0:
            return fmpq(0)
        raise UnresolvedError("a root", value=str(base), must="must be of a positive number")
    if exponent == sp.Rational(1, 2):
        return arb(base).sqrt()
    return arb(base) ** arb(evaluate(exponent, value))


def substituted(expression: Any, values: Mapping[str, Any]) -> Any:
    """Put numbers for the symbols of the widths, decimals as the decimal fractions that they are."""
    return expression.subs({symbol(name): exactly(value) for name, value in values.items()})


def exactly(value: Any) -> sp.Rational:
    """A number as a rational: floats by their shortest decimal; text, p/q or decimal; Fractions as they are.

    Raises
    ------
    InputError
        It is no finite number.
    """
    if isinstance(value, sp.Rational) and value.is_finite:
        return value
    try:
        found = Fraction(repr(float(value)) if isinstance(value, float) else str(value).strip())
    except (ValueError, ZeroDivisionError):
        raise InputError(
            "number", value=value, must="must be a finite number, or text such as 1.345 or 1/3"
        ) from None
    return sp.Rational(found.numerator, found.denominator)


def fraction(value: Any) -> Fraction:
    """A rational of SymPy or of FLINT."""
    return Fraction(int(value.p), int(value.q))
