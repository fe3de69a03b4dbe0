"""Starts on a line from which the next iterate is exactly at a residual of 0: found, or proved to exist.

On a line, between two neighbouring zeros of the residuals, the update is continuous. Where the next
iterates of two starts lie on two sides of a zero, some start between them leads to it (intermediate value
theorem).
"""

from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise

from flint import fmpq

from convexperc.errors import SolverError
from verification.exact.balls import UnresolvedError
from verification.reweighted.loops.loop import Loop
from verification.reweighted.terms.expressions import fraction, simplest

REACH = 8
"""Starts are sought up to this many times the spread of the zeros outside of it."""

STARTS = 8
"""Starts that are tried between two zeros."""


@dataclass(frozen=True)
class Meeting:
    """A zero that is met by the next iterate of a start.

    Attributes
    ----------
    name : str
        The variable.
    zero : Fraction
    lower, upper : Fraction
        A start strictly between them meets it; equal: this start does, exactly.
    """

    name: str
    zero: Fraction
    lower: Fraction
    upper: Fraction

    def shown(self) -> str:
        """The start, as text."""
        if self.lower == self.upper:
            return f"{self.name} = {self.lower}"
        return f"some {self.name} between {self.lower} and {self.upper}"


def meetings(loop: Loop) -> list[Meeting]:
    """The zeros that are met in one step from a start that is none of them, once each; of a single number."""
    sizes = loop.objective.sizes
    if list(sizes.values()) != [1]:
        return []
    name = next(iter(sizes))
    zeros = _zeros(loop, name)
    if not zeros:
        return []
    spread = zeros[-1] - zeros[0] or Fraction(1)
    ends = [zeros[0] - REACH * spread, *zeros, zeros[-1] + REACH * spread]
    found: dict[Fraction, Meeting] = {}
    for low, high in pairwise(ends):
        starts = [low + (high - low) * Fraction(k, STARTS) for k in range(1, STARTS)]
        images = [(start, _image(loop, name, start)) for start in starts]
        for zero in zeros:
            if zero not in found and (met := _met(loop, name, zero, images)) is not None:
                found[zero] = met
    return list(found.values())


def _zeros(loop: Loop, name: str) -> list[Fraction]:
    """Where a residual whose weight grows without bound is 0."""
    found = set()
    for part in loop.objective.parts:
        if part.term is not None and part.coefficient and part.affine.size == 1 and name in part.affine.parts:
            slope = part.affine.parts[name][0, 0]
            if slope:
                found.add(-part.affine.constant[0] / slope)
    return sorted(found)


def _image(loop: Loop, name: str, start: Fraction) -> Fraction | None:
    """The next iterate, if it is rational."""
    try:
        value = loop.step({name: [fmpq(start.numerator, start.denominator)]})[name][0]
    except (SolverError, UnresolvedError, ZeroDivisionError):
        return None
    return fraction(value) if isinstance(value, fmpq) else None


def _met(
    loop: Loop, name: str, zero: Fraction, images: list[tuple[Fraction, Fraction | None]]
) -> Meeting | None:
    """A start that meets a zero: one of those tried, a simple one between two, or proved between two."""
    for start, image in images:
        if image == zero:
            return Meeting(name, zero, start, start)
    if not _is_continuous(loop):
        return None
    for (low, first), (high, second) in pairwise(images):
        if first is None or second is None:
            continue
        if (first < zero) != (second < zero):
            return _narrowed(loop, name, zero, (low, first), (high, second))
    return None


def _is_continuous(loop: Loop) -> bool:
    """Whether no weight changes its formula, where it might jump."""
    return all(len(side.weight) == 1 for term in loop.objective.terms for side in term.sides)


def _narrowed(
    loop: Loop, name: str, zero: Fraction, low: tuple[Fraction, Fraction], high: tuple[Fraction, Fraction]
) -> Meeting:
    """Halve the bracket at its simplest rational, which meets the zero if a simple one does."""
    for _ in range(20):
        start = simplest(low[0], high[0])
        image = _image(loop, name, start)
        if image is None:
            break
        if image == zero:
            return Meeting(name, zero, start, start)
        if (image < zero) == (low[1] < zero):
            low = start, image
        else:
            high = start, image
    return Meeting(name, zero, low[0], high[0])
