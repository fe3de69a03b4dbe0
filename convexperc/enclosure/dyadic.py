"""Exact numbers longer than float64: integers times one power of two, and square roots rounded outward."""

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from convexperc.certificate.rationals import Integers, integers
from convexperc.enclosure.balls import Numbers

SCALE_BITS = 80
"""A scale is rounded down to so many bits: it costs 2^-80 of the bound and keeps the numbers short."""
ROOT_BITS = 160
"""Square roots are rounded at this many bits."""


@dataclass(frozen=True, eq=False)
class Dyadic:
    """Integers times one power of two: whole * 2^exponent.

    Attributes
    ----------
    whole : object array of int, shape (k,)
    exponent : int
    """

    whole: Integers
    exponent: int

    @classmethod
    def zeros(cls, size: int) -> "Dyadic":
        """The vector 0."""
        return cls(np.full(size, 0, dtype=object), 0)

    def plus(self, other: "Dyadic", sign: int = 1) -> "Dyadic":
        """Self + sign * other with sign = 1 or -1."""
        low = min(self.exponent, other.exponent)
        mine, theirs = (x.whole * (1 << (x.exponent - low)) for x in (self, other))
        return Dyadic(mine + sign * theirs, low)

    def times(self, factor: Fraction) -> "Dyadic":
        """The product with a rational whose denominator is a power of two."""
        shift = factor.denominator.bit_length() - 1
        return Dyadic(self.whole * factor.numerator, self.exponent - shift)

    def clipped(self, limit: Fraction) -> "Dyadic":
        """Cut to [-limit, limit], the limit a rational whose denominator is a power of two."""
        low = min(self.exponent, 1 - limit.denominator.bit_length())
        bound = int(limit * power(-low))
        whole = self.whole * (1 << (self.exponent - low))
        return Dyadic(np.minimum(np.maximum(whole, -bound), bound), low)

    def dot(self, other: "Dyadic") -> Fraction:
        """The inner product."""
        return int(self.whole @ other.whole) * power(self.exponent + other.exponent)

    def largest(self) -> Fraction:
        """The largest absolute value."""
        return int(max(abs(self.whole))) * power(self.exponent)

    def part(self, columns: Any) -> "Dyadic":
        """Some of the entries."""
        return Dyadic(self.whole[columns], self.exponent)

    def strings(self) -> list[str]:
        """Every entry as a C99 hex float, exactly."""
        return [_hex(int(value), self.exponent) for value in self.whole]


def exact(values: np.ndarray) -> Dyadic:
    """Floats as they are."""
    return Dyadic(*integers(values))


def exact_balls(values: Numbers, shift: int) -> Dyadic:
    """Balls without radius, times 2^shift."""
    pairs = [tuple(int(part) for part in value.man_exp()) for value in values]
    low = min((exponent for whole, exponent in pairs if whole), default=0)
    result = np.full(len(pairs), 0, dtype=object)
    result[:] = [whole << (exponent - low) if whole else 0 for whole, exponent in pairs]
    return Dyadic(result, low + shift)


def power(exponent: int) -> Fraction:
    """The power of two with any exponent."""
    return Fraction(1 << exponent) if exponent >= 0 else Fraction(1, 1 << -exponent)


def shortened(value: Fraction) -> Fraction:
    """A positive number rounded down to `SCALE_BITS` bits."""
    shift = SCALE_BITS + value.denominator.bit_length() - value.numerator.bit_length()
    return math.floor(value * power(shift)) * power(-shift)


def _root_bits(square: Fraction) -> int:
    return ROOT_BITS + (square.denominator.bit_length() - square.numerator.bit_length()) // 2


def root_down(square: Fraction) -> Fraction:
    """The square root, rounded down."""
    shift = _root_bits(square)
    return math.isqrt(math.floor(square * power(2 * shift))) * power(-shift)


def root_up(square: Fraction) -> Fraction:
    """The square root, rounded up unless it is exact."""
    low = root_down(square)
    return low if low * low == square else low + power(-_root_bits(square))


def _hex(whole: int, exponent: int) -> str:
    if not whole:
        return "0x0p+0"
    zeros = (whole & -whole).bit_length() - 1
    return f"{'-' if whole < 0 else ''}{hex(abs(whole) >> zeros)}p{exponent + zeros:+d}"
