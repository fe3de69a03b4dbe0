"""Rational numbers: floats as the rationals that they are, exact sums and products, enclosed square roots."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import isqrt, lcm
from typing import Any

import numpy as np
from numpy.typing import NDArray

Rational = tuple[Fraction, ...]
"""A vector of Fractions that is hashable."""

Rationals = NDArray[Any]
"""An object array of Fractions."""

Entries = Sequence[float] | Sequence[Fraction] | NDArray[Any]
"""A vector of floats or of Fractions."""

ROOT_BITS = 400
"""Square roots are enclosed to this many bits relative to their size."""


@dataclass(frozen=True)
class Enclosure:
    """lower <= the number <= upper, both exact."""

    lower: Fraction
    upper: Fraction

    @property
    def width(self) -> Fraction:
        """Return upper - lower."""
        return self.upper - self.lower


def rationals(values: Iterable[float] | Iterable[Fraction]) -> Rationals:
    """Take finite floats as the rationals that they are, and Fractions as they are; shape (k,)."""
    return np.array([x if isinstance(x, Fraction) else Fraction(float(x)) for x in values], dtype=object)


def integers(values: Iterable[Any]) -> tuple[list[int], int]:
    """Write floats or Fractions as integers over their least common denominator.

    Parameters
    ----------
    values : finite floats or Fractions (k,)

    Returns
    -------
    list of int (k,), int
        The numerators, and the denominator of all.
    """
    ratios = [value.as_integer_ratio() for value in values]
    denominator = lcm(*(bottom for _, bottom in ratios))
    return [top * (denominator // bottom) for top, bottom in ratios], denominator


def total(values: Iterable[Fraction]) -> Fraction:
    """Return the exact sum."""
    whole, unit = integers(values)
    return Fraction(sum(whole), unit)


def inner(x: Iterable[Fraction], y: Iterable[Fraction]) -> Fraction:
    """Return the exact inner product x'y of two vectors (k,)."""
    (first, unit_x), (second, unit_y) = integers(x), integers(y)
    return Fraction(sum(a * b for a, b in zip(first, second, strict=True)), unit_x * unit_y)


def squares(x: Iterable[Fraction]) -> Fraction:
    """Return the exact sum of squares ||x||^2."""
    whole, unit = integers(x)
    return Fraction(sum(a * a for a in whole), unit * unit)


def times(A: Rationals, x: Rationals) -> Rationals:
    """Return the exact product A x, A (k, l) and x (l,), shape (k,)."""
    (whole, unit), (vector, unit_x) = integers(A.flat), integers(x)
    products = np.array(whole, dtype=object).reshape(A.shape) @ np.array(vector, dtype=object)
    return fractions(products, unit * unit_x)


def fractions(whole: NDArray[Any], denominator: int) -> Rationals:
    """Divide an object array of integers by one denominator."""
    return objects([Fraction(value, denominator) for value in whole.flat], whole.shape)


def objects(values: Sequence[Any], shape: tuple[int, ...]) -> NDArray[Any]:
    """Put values into an object array of `shape`, untouched."""
    return np.array(values, dtype=object).reshape(shape)


def square_root(value: Fraction, bits: int = ROOT_BITS) -> Enclosure:
    """Enclose sqrt(value), value >= 0: exactly if it is rational, else to `bits` bits of its size."""
    top, bottom = isqrt(value.numerator), isqrt(value.denominator)
    if top * top == value.numerator and bottom * bottom == value.denominator:
        return Enclosure(Fraction(top, bottom), Fraction(top, bottom))
    size = value.denominator.bit_length() - value.numerator.bit_length()
    shift = max(0, bits + size // 2 + 1)
    root = isqrt((value.numerator << 2 * shift) // value.denominator)
    return Enclosure(Fraction(root, 1 << shift), Fraction(root + 1, 1 << shift))
