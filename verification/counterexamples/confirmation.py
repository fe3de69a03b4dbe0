"""What confirming a counterexample gives: whether it still fails, the numbers, and a table of them."""

from dataclasses import dataclass, field
from fractions import Fraction
from math import floor
from typing import Any

from verification.exact.loop import Iterate
from verification.exact.numbers import Enclosure

LONGEST = 40
"""Longer fractions are written as an interval with `DIGITS` significant digits, rounded outwards."""

DIGITS = 20


@dataclass(frozen=True)
class Line:
    """One iteration: the iterate, F at it, and what is to be said of it."""

    iteration: int
    at: Iterate
    remark: str = ""


@dataclass(frozen=True)
class Side:
    """One number of a counterexample without iterations."""

    label: str
    value: Enclosure


@dataclass(frozen=True)
class Confirmation:
    """What a record comes to when it is evaluated again.

    Attributes
    ----------
    confirmed : bool
        It fails as it did: the claim is false here, by the numbers that the record expects.
    finding : str
        One line with the numbers; where it is not confirmed, why not.
    found : dict
        The numbers, as `Record.expect` has them.
    lines : tuple of Line
        By iteration; empty for kinds without iterations.
    sides : tuple of Side
        The numbers that are compared, for kinds without iterations.
    optimum : Enclosure or None
        Of F*, where it is compared with.
    """

    confirmed: bool
    finding: str
    found: dict[str, Any] = field(default_factory=dict)
    lines: tuple[Line, ...] = ()
    sides: tuple[Side, ...] = ()
    optimum: Enclosure | None = None


def point(value: Fraction | int) -> Enclosure:
    """A number that is known exactly."""
    return Enclosure(Fraction(value), Fraction(value))


def minus(first: Enclosure, second: Enclosure) -> Enclosure:
    """The difference of two enclosed numbers."""
    return Enclosure(first.lower - second.upper, first.upper - second.lower)


def text(value: Enclosure) -> str | list[str]:
    """Write p/q, or [lower, upper] where the number is not known exactly or is long."""
    if value.width == 0 and len(str(value.lower)) <= LONGEST:
        return str(value.lower)
    return [str(_rounded(value.lower)), str(-_rounded(-value.upper))]


def enclosure(written: Any) -> Enclosure:
    """Read what `text` wrote."""
    low, high = written if isinstance(written, list) else (written, written)
    return Enclosure(Fraction(low), Fraction(high))


def agree(expected: Any, found: Any) -> bool:
    """Whether two things written by `text`, or lists or objects of them, can be the same numbers."""
    if isinstance(expected, dict) and isinstance(found, dict):
        return expected.keys() == found.keys() and all(agree(expected[k], found[k]) for k in found)
    if _is_number(expected) and _is_number(found):
        one, other = enclosure(expected), enclosure(found)
        return one.lower <= other.upper and other.lower <= one.upper
    if isinstance(expected, list) and isinstance(found, list):
        return len(expected) == len(found) and all(map(agree, expected, found))
    return bool(expected == found)


def shown(value: Enclosure, longest: int = 15) -> str:
    """The exact number if it is short, else a decimal."""
    if value.width == 0 and len(str(value.lower)) <= longest:
        return str(value.lower)
    return f"{float(value.lower):.10g}"


def _rounded(value: Fraction) -> Fraction:
    """The next number below with `DIGITS` significant decimal digits."""
    if value == 0:
        return value
    power = len(str(abs(value.numerator))) - len(str(value.denominator))
    unit = Fraction(10) ** (power - DIGITS)
    return floor(value / unit) * unit


def _is_number(value: Any) -> bool:
    if isinstance(value, str):
        return bool(value) and value.lstrip("-").replace("/", "").isdigit()
    return (
        isinstance(value, list)
        and len(value) == 2
        and all(isinstance(v, str) and _is_number(v) for v in value)
    )
