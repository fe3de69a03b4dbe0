"""Random losses with their true weights, to be acquitted, and with weights of a known fault.

A loss is psi(r**2) with psi concave and increasing: positive multiples of known functions, sums of them,
increasing concave functions of them, and pieces that continue another one with at most its slope. Its
weight of r**2 is psi', by the rules of differentiation here, and by SymPy in `Drawn.term`: the tests
compare the two.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

import numpy as np
import sympy as sp

from verification.reweighted.terms.expressions import R, exactly
from verification.reweighted.terms.term import SQUARES, Term

WIDTH = "w"
"""The width of a term that has one: it is psi((r/w)**2)."""

Numbers = Any
"""A float, or an array of floats."""


@dataclass(frozen=True)
class Concave:
    """A concave increasing function of s = r**2 > 0.

    Attributes
    ----------
    value, slope : callable
        Of an array of s, in float64.
    formula : callable
        Of a SymPy expression for r > 0 (not s), with rational numbers.
    kind : str
    """

    value: Callable[[Numbers], Numbers]
    slope: Callable[[Numbers], Numbers]
    formula: Callable[[Any], Any]
    kind: str


def _log(c: Fraction) -> Concave:
    a = float(c)
    return Concave(
        lambda s: np.log(1 + s / a), lambda s: 1 / (a + s), lambda r: sp.log(1 + r**2 / _exact(c)), "log"
    )


def _geman(c: Fraction) -> Concave:
    a = float(c)
    return Concave(
        lambda s: s / (s + a), lambda s: a / (s + a) ** 2, lambda r: r**2 / (r**2 + _exact(c)), "geman"
    )


def _welsch(c: Fraction) -> Concave:
    a = float(c)
    return Concave(
        lambda s: 1 - np.exp(-s / a),
        lambda s: np.exp(-s / a) / a,
        lambda r: 1 - sp.exp(-(r**2) / _exact(c)),
        "welsch",
    )


def _root(c: Fraction) -> Concave:
    a = float(c)
    return Concave(
        lambda s: np.sqrt(s + a) - np.sqrt(a),
        lambda s: 0.5 / np.sqrt(s + a),
        lambda r: sp.sqrt(r**2 + _exact(c)) - sp.sqrt(_exact(c)),
        "root",
    )


def _power(c: Fraction) -> Concave:
    half = Fraction(1 + (3 * c.numerator + c.denominator) % 8, 8)  # s**half with half <= 1: r**p with p <= 2
    h = float(half)
    return Concave(
        lambda s: s**h, lambda s: h * s ** (h - 1), lambda r: r ** (2 * _exact(half)), f"power {2 * half}"
    )


def _huber(c: Fraction) -> Concave:
    a = float(c)
    return Concave(
        lambda s: np.where(s <= a * a, s, 2 * a * np.sqrt(s) - a * a),
        lambda s: np.where(s <= a * a, 1.0, a / np.sqrt(s)),
        lambda r: sp.Piecewise((r**2, r <= _exact(c)), (2 * _exact(c) * r - _exact(c) ** 2, True)),
        "huber",
    )


def _truncated(c: Fraction) -> Concave:
    a = float(c)
    return Concave(
        lambda s: np.minimum(s, a * a),
        lambda s: np.where(s <= a * a, 1.0, 0.0),
        lambda r: sp.Piecewise((r**2, r <= _exact(c)), (_exact(c) ** 2, True)),
        "truncated",
    )


def _tukey(c: Fraction) -> Concave:
    a = float(c)
    return Concave(
        lambda s: a * a / 3 * (1 - np.where(s <= a * a, 1 - s / a**2, 0.0) ** 3),
        lambda s: np.where(s <= a * a, 1 - s / a**2, 0.0) ** 2,
        lambda r: sp.Piecewise(
            (_exact(c) ** 2 / 3 * (1 - (1 - r**2 / _exact(c) ** 2) ** 3), r <= _exact(c)),
            (_exact(c) ** 2 / 3, True),
        ),
        "tukey",
    )


def _arctan(c: Fraction) -> Concave:
    a = float(c)
    return Concave(
        lambda s: np.arctan(s / a),
        lambda s: a / (a * a + s * s),
        lambda r: sp.atan(r**2 / _exact(c)),
        "arctan",
    )


def _fair(c: Fraction) -> Concave:
    a = float(c)
    return Concave(
        lambda s: np.sqrt(s) / a - np.log(1 + np.sqrt(s) / a),
        lambda s: 0.5 / (a * (a + np.sqrt(s))),
        lambda r: r / _exact(c) - sp.log(1 + r / _exact(c)),
        "fair",
    )


def _log_sum(c: Fraction) -> Concave:
    a = float(c)
    return Concave(
        lambda s: np.log(1 + np.sqrt(s) / a),
        lambda s: 0.5 / (np.sqrt(s) * (a + np.sqrt(s))),
        lambda r: sp.log(1 + r / _exact(c)),
        "log-sum",
    )


KINDS = (
    _log, _geman, _welsch, _root, _power, _huber, _truncated, _tukey, _arctan, _fair, _log_sum,
)  # fmt: skip

OUTER: dict[str, tuple[Callable[[Any, Any], Any], Callable[[Any, Any], Any], Callable[[Any, Any], Any]]] = {
    "log": (lambda y, c: np.log(1 + y / c), lambda y, c: 1 / (c + y), lambda y, c: sp.log(1 + y / c)),
    "geman": (lambda y, c: y / (y + c), lambda y, c: c / (y + c) ** 2, lambda y, c: y / (y + c)),
    "welsch": (
        lambda y, c: 1 - np.exp(-y / c),
        lambda y, c: np.exp(-y / c) / c,
        lambda y, c: 1 - sp.exp(-y / c),
    ),
    "root": (lambda y, c: np.sqrt(y + c), lambda y, c: 0.5 / np.sqrt(y + c), lambda y, c: sp.sqrt(y + c)),
}
"""Increasing concave functions of y >= 0: in float64, their slope, and the formula."""


def _exact(value: Fraction) -> Any:
    return exactly(value)


def _sum(parts: list[tuple[Fraction, Concave]]) -> Concave:
    numbers = [(float(k), part) for k, part in parts]
    return Concave(
        lambda s: sum(k * part.value(s) for k, part in numbers),
        lambda s: sum(k * part.slope(s) for k, part in numbers),
        lambda r: sum((_exact(k) * part.formula(r) for k, part in parts), sp.S.Zero),
        " + ".join(part.kind for _, part in parts),
    )


def _of(name: str, c: Fraction, inner: Concave) -> Concave:
    value, slope, formula = OUTER[name]
    a = float(c)
    return Concave(
        lambda s: value(inner.value(s), a),
        lambda s: slope(inner.value(s), a) * inner.slope(s),
        lambda r: formula(inner.formula(r), _exact(c)),
        f"{name}({inner.kind})",
    )


def _glued(first: Concave, second: Concave, end: Fraction, share: Fraction) -> Concave:
    """The first up to r = end, then the second with `share` of the first's slope at the start."""
    s0 = float(end) ** 2
    scale = float(share) * float(first.slope(np.array(s0))) / float(second.slope(np.array(s0)))
    level = float(first.value(np.array(s0))) - scale * float(second.value(np.array(s0)))

    def formula(r: Any) -> Any:
        inside, outside, at = first.formula(r), second.formula(r), _exact(end)
        factor = (
            _exact(share) * _at(sp.diff(first.formula(R), R), at) / _at(sp.diff(second.formula(R), R), at)
        )
        level = _at(first.formula(R), at) - factor * _at(second.formula(R), at)
        return sp.Piecewise((inside, r <= at), (level + factor * outside, True))

    return Concave(
        lambda s: np.where(s <= s0, first.value(s), level + scale * second.value(s)),
        lambda s: np.where(s <= s0, first.slope(s), scale * second.slope(s)),
        formula,
        f"{first.kind} then {second.kind}",
    )


def _at(expression: Any, point: Any) -> Any:
    return sp.simplify(expression.subs(R, point))


@dataclass(frozen=True)
class Drawn:
    """A loss and a weight.

    Attributes
    ----------
    number : int
    psi : Concave
    square : {"r**2", "r**2/2"}
    width : Fraction
    fault : str
        Empty, or the planted one.
    expected : str
        The question that is to name the fault.
    change : callable
        From (r, weight as a function of r) to the faulty weight.
    """

    number: int
    psi: Concave
    square: str
    width: Fraction
    fault: str = ""
    expected: str = ""
    change: Callable[[Any, Callable[[Any], Any], Any], Any] = field(default=lambda r, weight, xp: weight(r))

    @property
    def name(self) -> str:
        """Number, kind and fault."""
        return f"{self.number}: {self.psi.kind}{f' ({self.fault})' if self.fault else ''}"

    def make(self, width: float) -> tuple[Callable[[Any], Any], Callable[[Any], Any]]:
        """Loss and weight in float64."""
        factor = float(SQUARES[self.square])

        def loss(r: Any) -> Any:
            return self.psi.value((r / width) ** 2)

        def right(r: Any) -> Any:
            return self.psi.slope((r / width) ** 2) / (factor * width**2)

        return loss, lambda r: self.change(r, right, np)

    def functions(self) -> tuple[Callable[[Any], Any], Callable[[Any], Any]]:
        """Loss and weight of its own width, in float64."""
        return self.make(float(self.width))

    def term(self) -> Term:
        """The same in formulas; the weight is differentiated by SymPy."""
        width = sp.Symbol(WIDTH, positive=True)
        loss = self.psi.formula(R)
        factor = SQUARES[self.square]
        right = sp.diff(loss, R) / (2 * factor * R)

        def weight(r: Any) -> Any:
            return right.subs(R, r / width, simultaneous=True) / width**2

        return Term(
            loss.subs(R, R / width),
            self.change(R, weight, sp),
            self.square,
            {WIDTH: self.width},
            name=self.name,
        )


def draw(seed: int, number: int, *, mutant: bool = False, depth: int = 2) -> Drawn:
    """The pair of this number: sound, or with a planted fault; of depth 0 its loss is one known function."""
    rng = np.random.default_rng([seed, number, int(mutant)])
    psi = _function(rng, depth)
    square = str(rng.choice(list(SQUARES)))
    width = Fraction(int(rng.integers(1, 40)), int(rng.integers(1, 40))) * Fraction(10) ** int(
        rng.integers(-3, 4)
    )
    sound = Drawn(number, psi, square, width)
    if not mutant:
        return sound
    names = list(FAULTS)
    start = int(rng.integers(len(names)))
    for shift in range(len(names)):
        found = FAULTS[names[(start + shift) % len(names)]](sound, rng)
        if found is not None:
            return found
    raise AssertionError("a factor is a fault of every pair")


def _function(rng: np.random.Generator, depth: int) -> Concave:
    shape = int(rng.integers(6)) if depth else 0
    if shape <= 1:
        kind = KINDS[int(rng.integers(len(KINDS)))]
        return _sum([(_number(rng), kind(_number(rng)))])
    if shape <= 3:
        return _sum([(_number(rng), _function(rng, depth - 1)) for _ in range(int(rng.integers(2, 4)))])
    if shape == 4:
        return _of(str(rng.choice(list(OUTER))), _number(rng), _function(rng, depth - 1))
    first, second = _function(rng, 0), _function(rng, 0)
    end = _number(rng)
    with np.errstate(all="ignore"):
        slopes = [float(each.slope(np.array(float(end) ** 2))) for each in (first, second)]
    if min(slopes) < 1e-9:  # a slope of 0 cannot be continued
        return first
    return _glued(
        first, second, end, Fraction(1) if rng.random() < 0.7 else Fraction(1, int(rng.integers(2, 5)))
    )


def _number(rng: np.random.Generator) -> Fraction:
    """A positive rational of small numbers."""
    return Fraction(int(rng.integers(1, 21)), int(rng.integers(1, 21)))


Fault = Callable[[Drawn, np.random.Generator], Drawn | None]


def _planted(sound: Drawn, fault: str, expected: str, change: Any) -> Drawn:
    return Drawn(sound.number, sound.psi, sound.square, sound.width, fault, expected, change)


def _factor(sound: Drawn, rng: np.random.Generator) -> Drawn:
    k = int(rng.choice([2, 3, 4]))
    return _planted(sound, f"factor {k}", "tangent", lambda r, weight, xp: k * weight(r))


def _fraction(sound: Drawn, rng: np.random.Generator) -> Drawn:
    k = int(rng.choice([2, 3, 4]))
    return _planted(sound, f"factor 1/{k}", "tangent", lambda r, weight, xp: weight(r) / k)


def _negative(sound: Drawn, rng: np.random.Generator) -> Drawn:
    return _planted(sound, "sign", "sign", lambda r, weight, xp: -weight(r))


def _other_width(sound: Drawn, rng: np.random.Generator) -> Drawn | None:
    if not _varies(sound, 2.0):
        return None
    return _planted(sound, "twice the residual", "tangent", lambda r, weight, xp: weight(2 * r))


def _floor(sound: Drawn, rng: np.random.Generator) -> Drawn | None:
    """The weight at the larger of r and an absolute number, where it varies."""
    least = Fraction(sound.width)
    _, weight = sound.functions()
    with np.errstate(all="ignore"):
        values = weight(np.array([float(least), float(least) / 4]))
    if not abs(values[1] - values[0]) > 0.05 * abs(values[0]):
        return None
    number = {np: float(least), sp: exactly(least)}
    larger = {np: np.maximum, sp: sp.Max}
    return _planted(
        sound, "absolute floor", "tangent", lambda r, weight, xp: weight(larger[xp](r, number[xp]))
    )


def _not_squared(sound: Drawn, rng: np.random.Generator) -> Drawn | None:
    """The width where its square belongs: the unit of the weight is wrong."""
    if abs(float(sound.width) - 1) < 0.05:
        return None
    number = {np: float(sound.width), sp: exactly(sound.width)}
    return _planted(sound, "width not squared", "tangent", lambda r, weight, xp: weight(r) * number[xp])


def _rising(sound: Drawn, rng: np.random.Generator) -> Drawn:
    """A loss with r**4 in it: tangent, and its weight rises in the end."""
    k = _number(rng)
    convex = Concave(lambda s: s * s, lambda s: 2 * s, lambda r: r**4, "r**4")
    loss = _sum([(Fraction(1), sound.psi), (k, convex)])
    return Drawn(sound.number, loss, sound.square, sound.width, "rising weight", "majorises")


def _varies(sound: Drawn, by: float) -> bool:
    """Whether the weight at r and at `by` times r differ by a hundredth at some of a few residuals."""
    _, weight = sound.functions()
    r = float(sound.width) * np.exp2(np.arange(-6.0, 7.0))
    with np.errstate(all="ignore"):
        here, there = weight(r), weight(by * r)
        return bool(np.any(np.abs(there - here) > 0.01 * np.abs(here)))


FAULTS: dict[str, Fault] = {
    "factor": _factor,
    "fraction": _fraction,
    "sign": _negative,
    "twice the residual": _other_width,
    "floor": _floor,
    "width not squared": _not_squared,
    "rising": _rising,
}
