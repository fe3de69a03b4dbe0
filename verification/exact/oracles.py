"""The exact referee's arithmetic: F, D and feasibility over the rationals.

A second derivation. It reads the data of a `Problem` and nothing else of `convexperc`: floats are taken as
the rationals that they are, and square roots are enclosed by integer square roots.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import isqrt, lcm
from typing import Any

import numpy as np
from numpy.typing import NDArray

from convexperc.problem.problem import Problem

Rationals = NDArray[Any]
"""An object array of Fractions."""

Entries = Sequence[float] | NDArray[Any]
"""Floats, or an object array of Fractions."""

ROOT_BITS = 400
"""Square roots are enclosed to this many bits relative to their size."""


@dataclass(frozen=True)
class Enclosure:
    """lower <= the number <= upper, all exact."""

    lower: Fraction
    upper: Fraction

    @property
    def width(self) -> Fraction:
        """Difference of the two."""
        return self.upper - self.lower


def rationals(values: Iterable[float]) -> Rationals:
    """Take floats (finite) as the rationals that they are, shape (k,)."""
    whole, unit = _integers(np.array(list(values), dtype=np.float64)[None, :])
    return _with_unit(whole[0], unit)


def square_root(value: Fraction) -> Enclosure:
    """Enclose sqrt(value), value >= 0, by an integer square root; exact if the root is dyadic."""
    if value == 0:
        return Enclosure(Fraction(0), Fraction(0))
    size = value.denominator.bit_length() - value.numerator.bit_length()
    shift = max(0, ROOT_BITS + size // 2 + 1)
    scaled = value * Fraction(4) ** shift
    root = isqrt(scaled.numerator // scaled.denominator)
    unit = Fraction(2) ** shift
    exact = root * root * scaled.denominator == scaled.numerator
    return Enclosure(root / unit, (root if exact else root + 1) / unit)


def objective(problem: Problem, w: Entries, u: Entries) -> Enclosure:
    """Enclose F(w, u) at floats or rationals; exact unless a modality's norm is irrational."""
    data = Exact.of(problem)
    w_, u_ = rational_vector(w), rational_vector(u)
    p, q = _columns(data, w_) - data.o, _rows(data, u_) - w_
    value = _dot(p, p) + data.lambda1 * _dot(q, q) + data.lambda2 * sum((abs(x) for x in w_), Fraction(0))
    roots = [square_root(_dot(u_[c], u_[c])) for c in problem.modalities] if data.lambda3 else []
    low, high = (sum((getattr(r, end) for r in roots), Fraction(0)) for end in ("lower", "upper"))
    return Enclosure(value + data.lambda3 * low, value + data.lambda3 * high)


def dual_objective(problem: Problem, a: Entries, b: Entries) -> Fraction:
    """D(a, b) = -a'o - ||a||^2/4 - ||b||^2/(4 lambda1), exactly; b must be 0 where lambda1 is 0."""
    data = Exact.of(problem)
    a_, b_ = rational_vector(a), rational_vector(b)
    coupling = _dot(b_, b_)
    if coupling:
        coupling = coupling / (4 * data.lambda1)
    return -_dot(a_, data.o) - _dot(a_, a_) / 4 - coupling


def is_dual_feasible(problem: Problem, a: Entries, b: Entries) -> bool:
    """Whether |X a - b|_j <= lambda2, ||X_i' b|| <= lambda3, and b = 0 if lambda1 = 0: decided exactly."""
    data = Exact.of(problem)
    a_, b_ = rational_vector(a), rational_vector(b)
    if data.lambda1 == 0 and any(b_):
        return False
    pull = _columns(data, b_)
    return all(abs(v) <= data.lambda2 for v in _rows(data, a_) - b_) and all(
        _dot(pull[c], pull[c]) <= data.lambda3**2 for c in problem.modalities
    )


@dataclass(frozen=True, eq=False)
class Exact:
    """The data of a problem over the rationals.

    Attributes
    ----------
    X : integers (n, d)
        In units of `unit`.
    unit : Fraction
    o : Fractions (d,)
    lambda1, lambda2, lambda3 : Fraction
    """

    X: NDArray[Any]
    unit: Fraction
    o: Rationals
    lambda1: Fraction
    lambda2: Fraction
    lambda3: Fraction

    @classmethod
    def of(cls, problem: Problem) -> "Exact":
        """Read `problem`."""
        X, unit = _integers(problem.X)
        return cls(X, unit, rationals(problem.o), *(Fraction(value) for value in problem.lambdas))


@dataclass(frozen=True, eq=False)
class Reduced:
    """All that F* depends on, in n dimensions: G = X X', c = X o, ||o||^2 and K_i = X_i X_i', exactly.

    Formula: u^i may be taken in the row space of X_i, so that u enters through X_i u^i and ||u^i|| alone.
    """

    G: Rationals
    c: Rationals
    target: Fraction
    K: tuple[Rationals, ...]

    @classmethod
    def of(cls, problem: Problem) -> "Reduced":
        """Multiply out."""
        X, unit = _integers(problem.X)
        o, unit_o = _integers(problem.o[None, :])
        blocks = [X[:, columns] for columns in problem.modalities]
        K = tuple(_with_unit(B @ B.T, unit * unit) for B in blocks)
        c = _with_unit(X @ o[0], unit * unit_o)
        return cls(sum(K[1:], K[0]), c, int(o[0] @ o[0]) * unit_o * unit_o, K)


def objects(values: Iterable[Any], shape: tuple[int, ...]) -> NDArray[Any]:
    """Put `values` into an object array of `shape`, untouched."""
    result = np.empty(shape, dtype=object)
    for index, value in zip(np.ndindex(*shape), values, strict=True):
        result[index] = value
    return result


def common(values: Rationals) -> tuple[NDArray[Any], Fraction]:
    """Write rationals as integers times one unit; sums of products are then cheap."""
    denominator = lcm(*(value.denominator for value in values.flat))
    whole = [value.numerator * (denominator // value.denominator) for value in values.flat]
    return objects(whole, values.shape), Fraction(1, denominator)


def times(A: Rationals, x: Rationals) -> Rationals:
    """The exact product A x."""
    (whole, unit), (vector, unit_x) = common(A), common(x)
    return _with_unit(whole @ vector, unit * unit_x)


def dot(x: Rationals, y: Rationals) -> Fraction:
    """The exact inner product x'y."""
    return _dot(x, y)


def _dot(x: Rationals, y: Rationals) -> Fraction:
    (first, unit), (second, unit_y) = common(x), common(y)
    return Fraction(int(first @ second)) * unit * unit_y


def _columns(data: Exact, w: Rationals) -> Rationals:
    whole, unit = common(w)
    return _with_unit(data.X.T @ whole, data.unit * unit)


def _rows(data: Exact, u: Rationals) -> Rationals:
    whole, unit = common(u)
    return _with_unit(data.X @ whole, data.unit * unit)


def rational_vector(values: Entries) -> Rationals:
    """Floats, or an object array of Fractions, as the latter."""
    if isinstance(values, np.ndarray) and values.dtype == object:
        return values
    return rationals(values)


def _integers(values: NDArray[np.float64]) -> tuple[NDArray[Any], Fraction]:
    """Write floats as integers times one power of two."""
    ratios = [float(value).as_integer_ratio() for value in values.flat]
    denominator = max(ratio[1] for ratio in ratios)
    whole = [top * (denominator // bottom) for top, bottom in ratios]
    return objects(whole, values.shape), Fraction(1, denominator)


def _with_unit(whole: NDArray[Any], unit: Fraction) -> Rationals:
    return objects([int(value) * unit for value in whole.flat], whole.shape)
