"""Arithmetic that rounds the worst way: every result is off by up to u, as an adversary likes.

Numbers are rationals, so that what a bound misses is known exactly. The code under test runs as it is, on
these numbers in place of floats: a lemma of docs/rounding.md that rests on the model alone must hold here as
well. Underflow is left out; `test_rounding` has it.
"""

import ast
import inspect
import math
import random
import types
from collections.abc import Callable, Iterable
from fractions import Fraction
from typing import Any, ClassVar

import numpy as np
from rational import root_bounds

UNIT = Fraction(1, 2**53)
MOVES = {-1: 1 / (1 + UNIT), 0: Fraction(1), 1: 1 + UNIT / (1 + UNIT)}
"""Of an exact result to the rounded one: off by u, relative to either, at most."""
Plan = list[int]
"""Which way each operation rounds, one after the other; the rest are exact."""


class Wild:
    """A number whose operations round as the plan in force says."""

    plan: ClassVar[Plan] = []
    done: ClassVar[int] = 0
    __slots__ = ("value",)

    def __init__(self, value: Any) -> None:
        self.value = value.value if isinstance(value, Wild) else Fraction(value)

    @classmethod
    def rounded(cls, exact: Fraction) -> "Wild":
        """Off by what the plan allows."""
        move = cls.plan[cls.done] if cls.done < len(cls.plan) else 0
        cls.done += 1
        return cls(exact * MOVES[move])

    def __add__(self, other: Any) -> Any:
        if isinstance(other, np.ndarray):
            return NotImplemented
        if _infinite(other):
            return other
        other = exact(other)
        # A float plus 0 is exact, in any arithmetic.
        return Wild.rounded(self.value + other) if self.value and other else Wild(self.value + other)

    __radd__ = __add__

    def __neg__(self) -> "Wild":
        return Wild(-self.value)

    def __sub__(self, other: Any) -> Any:
        return self + -other

    def __rsub__(self, other: Any) -> Any:
        return -self + other

    def __mul__(self, other: Any) -> Any:
        if isinstance(other, np.ndarray):
            return NotImplemented
        if _infinite(other):
            return other * float(np.sign(self.value)) if self.value else math.nan
        other = exact(other)
        return Wild(self.value * other) if _is_power_of_two(other) else Wild.rounded(self.value * other)

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> "Wild":
        other = exact(other)
        return Wild(self.value / other) if _is_power_of_two(other) else Wild.rounded(self.value / other)

    def __rtruediv__(self, other: Any) -> "Wild":
        return Wild.rounded(exact(other) / self.value)

    def __pow__(self, power: int) -> Any:
        assert power == 2
        return self * self

    def sqrt(self) -> "Wild":
        """Rounded, with the square root enclosed to 400 bits."""
        low, high = root_bounds(self.value)
        return Wild.rounded(low if low * low == self.value or Wild._next() > 0 else high)

    @classmethod
    def _next(cls) -> int:
        return cls.plan[cls.done] if cls.done < len(cls.plan) else 0

    def __abs__(self) -> "Wild":
        return Wild(abs(self.value))

    def __bool__(self) -> bool:
        return bool(self.value)

    def __eq__(self, other: object) -> bool:
        return self.value == exact(other)

    def __hash__(self) -> int:
        return hash(self.value)

    def __lt__(self, other: Any) -> bool:
        return _infinite(other) > 0 or (not _infinite(other) and self.value < exact(other))

    def __le__(self, other: Any) -> bool:
        return _infinite(other) > 0 or (not _infinite(other) and self.value <= exact(other))

    def __gt__(self, other: Any) -> bool:
        return not self <= other

    def __ge__(self, other: Any) -> bool:
        return not self < other

    def __float__(self) -> float:
        return float(self.value)

    def __repr__(self) -> str:
        return f"Wild({float(self.value)!r})"


def exact(value: Any) -> Fraction:
    """The rational that a number is."""
    return value.value if isinstance(value, Wild) else Fraction(value)


def exacts(values: Iterable[Any]) -> list[Fraction]:
    """The rationals that numbers are."""
    return [exact(value) for value in values]


def wild(*values: Any) -> np.ndarray:
    """Numbers, or rows of numbers, as an array."""
    nested = [wild(*value) if isinstance(value, (list, tuple)) else Wild(value) for value in values]
    found = np.empty((len(nested), *np.shape(nested[0])), dtype=object)
    found[:] = nested
    return found


def _infinite(value: Any) -> int:
    return int(math.copysign(1, value)) if isinstance(value, float) and math.isinf(value) else 0


def _is_power_of_two(value: Fraction) -> bool:
    top, bottom = abs(value.numerator), value.denominator
    return top & (top - 1) == 0 and bottom & (bottom - 1) == 0


def _neighbour(value: Any, toward: float) -> Any:
    """What `nextafter` gives at least: it moves a float by u of its size, or more."""
    if not isinstance(value, Wild):
        return math.nextafter(value, toward)
    return Wild(value.value + abs(value.value) * UNIT * (1 if toward > 0 else -1))


class _Library:
    """A module some functions of which take wild numbers."""

    def __init__(self, module: types.ModuleType, **functions: Callable[..., Any]) -> None:
        self.__dict__.update(functions, module=module)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.module, name)


def _cholesky(G: np.ndarray) -> np.ndarray:
    """Row by row, as the textbook has it."""
    n = len(G)
    L = np.full((n, n), Wild(0), dtype=object)
    for i in range(n):
        for j in range(i + 1):
            left = G[i, j]
            for k in range(j):
                left = left - L[i, k] * L[j, k]
            if i == j and not left > 0:
                raise np.linalg.LinAlgError
            L[i, j] = left.sqrt() if i == j else left / L[j, j]
    return L


def _is_finite(values: Any) -> Any:
    return np.vectorize(lambda value: isinstance(value, Wild) or math.isfinite(value), otypes=[bool])(values)


LINALG = types.SimpleNamespace(LinAlgError=np.linalg.LinAlgError, cholesky=_cholesky, eigvalsh=None)
NUMPY = _Library(
    np, isfinite=_is_finite, linalg=LINALG, ldexp=lambda values, exponent: values * Fraction(2) ** exponent,
    nextafter=lambda values, toward: np.frompyfunc(lambda value: _neighbour(value, toward), 1, 1)(values),
)  # fmt: skip
MATH = _Library(
    math, nextafter=_neighbour, isfinite=lambda value: isinstance(value, Wild) or math.isfinite(value),
    sqrt=lambda value: value.sqrt() if isinstance(value, Wild) else math.sqrt(value),
    isnan=lambda value: not isinstance(value, Wild) and math.isnan(value),
)  # fmt: skip


def copied(
    module: types.ModuleType, *changes: tuple[str, str], below: Iterable[types.ModuleType] = ()
) -> types.ModuleType:
    """A module for wild numbers, not compiled, with pieces of its source replaced.

    What it imports from the modules of which `below` has copies is taken from the copies.
    """
    source = inspect.getsource(module)
    for old, new in changes:
        assert source.count(old) >= 1, old
        source = source.replace(old, new)
    copy = types.ModuleType(module.__name__)
    exec(compile(source, f"{module.__name__}, wild", "exec"), copy.__dict__)
    copies = {other.__name__: vars(other) for other in below}
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.ImportFrom) and node.module in copies:
            vars(copy).update({alias.name: copies[node.module][alias.name] for alias in node.names})
    vars(copy).update(
        np=NUMPY, math=MATH, float=lambda value: value if isinstance(value, Wild) else float(value)
    )
    return copy


def excess(
    attack: Callable[[], Fraction], *, tries: int = 3, enough: bool = False, climb: bool = True
) -> Fraction:
    """By how much the worst plan that is found breaks a bound; <= 0 where it holds.

    Parameters
    ----------
    attack : callable
        Runs the code on wild numbers; returns exactly by how much the bound is missed.
    tries : int
        Plans that are drawn, besides those that round in one direction.
    enough : bool
        End with the first plan that breaks the bound.
    climb : bool
        Improve each plan, one rounding after the other.
    """
    draw = random.Random(0)

    def missed(plan: Plan) -> Fraction:
        Wild.plan, Wild.done = plan, 0
        try:
            return attack()
        finally:
            Wild.plan = []

    missed([])
    length = Wild.done + 4
    plans = [[way] * length for way in (-1, 1)] + [draw.choices((-1, 1), k=length) for _ in range(tries)]
    reached = [missed(plan) for plan in plans]
    if climb and not (enough and max(reached) > 0):
        reached = [_climbed(missed, plan, value) for plan, value in zip(plans, reached, strict=True)]
    return max(reached)


def _climbed(missed: Callable[[Plan], Fraction], plan: Plan, reached: Fraction) -> Fraction:
    """Turn one rounding after the other, and keep what hurts."""
    for k in range(len(plan)):
        plan[k] = -plan[k]
        other = missed(plan)
        if other > reached:
            reached = other
        else:
            plan[k] = -plan[k]
    return reached
