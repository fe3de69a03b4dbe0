"""Numbers for exact runs: rationals while they last, then balls that contain the true number."""

from collections.abc import Iterator
from contextlib import contextmanager
from fractions import Fraction
from typing import Any

import flint
from flint import arb, fmpq

from convexperc.errors import SolverError
from verification.exact.numbers import Enclosure

Numbers = list[Any]
"""fmpq, or arb where a number is not rational or is too long."""


class UnresolvedError(SolverError):
    """Balls of this many bits do not tell, for example whether a matrix is singular."""


@contextmanager
def precision(bits: int) -> Iterator[None]:
    """Set the bits of every ball operation inside."""
    before = flint.ctx.prec
    flint.ctx.prec = bits
    try:
        yield
    finally:
        flint.ctx.prec = before


def exact(value: Fraction | float) -> Any:
    """Return a finite float or a Fraction as FLINT's rational of the same value."""
    return fmpq(*(value if isinstance(value, Fraction) else float(value)).as_integer_ratio())


def root(square: Any) -> Any:
    """Return the square root: rational if it is one, else a ball."""
    if isinstance(square, fmpq):
        above, below = square.numer(), square.denom()
        if above.is_square() and below.is_square():
            return fmpq(above.isqrt(), below.isqrt())
        return arb(square).sqrt()
    return square.sqrt()


def inner(x: Numbers, y: Numbers) -> Any:
    """Return x'y; a number times itself is a product of two equal balls, never a power."""
    return sum((a * b for a, b in zip(x, y, strict=True)), fmpq(0))


def enclosed(value: Any) -> Enclosure:
    """Enclose a rational by itself, a ball by its two ends, exactly.

    Raises
    ------
    UnresolvedError
        The ball is not finite.
    """
    if isinstance(value, fmpq):
        same = Fraction(int(value.numer()), int(value.denom()))
        return Enclosure(same, same)
    if not value.is_finite():
        raise UnresolvedError("a ball", value=str(value), must="must be finite", remedy="Use more bits.")
    low, high = (end.man_exp() for end in (value.lower(), value.upper()))
    return Enclosure(*(int(man) * Fraction(2) ** int(power) for man, power in (low, high)))


def ball(x: Enclosure) -> Any:
    """Return a ball that contains the enclosed number; a rational where the width is 0."""
    if x.width == 0:
        return exact(x.lower)
    return arb(exact((x.lower + x.upper) / 2), exact(x.width / 2))
