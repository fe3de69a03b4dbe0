"""F1 by cases: F lies below its chords, and above 0; exactly, and as the library computes it."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from convexperc.problem import formulation as library
from convexperc.problem.problem import Problem
from verification.checks.interface import Check, Observation
from verification.checks.measures import LARGE, ULP, drawn_point, magnitudes, number, share, size, underflow
from verification.exact.formulation import objective
from verification.exact.numbers import Enclosure, rationals, squares, total
from verification.exact.problem import ExactProblem
from verification.ledger.evidence import Outcome
from verification.problems.sources import Source

PARTS = ("F1/convex", "F1/bounded")
PLACES = (Fraction(1, 2), Fraction(1, 4), Fraction(3, 4))
"""t of the point z + t (z' - z)."""
ROUNDING = 1
"""The library's F on a chord may lie above it by this many units, times n + d, of the magnitudes."""


@dataclass(frozen=True)
class _Known:
    """F at one point: exactly, and the library's with its allowance; that is NaN where it may overflow."""

    exact: Enclosure
    library: float
    allowance: Fraction


def observe(problem: Problem, source: Source) -> Iterator[Observation]:
    """Compare F at z + t (z' - z) with the chord."""
    ends = drawn_point(problem, source), drawn_point(problem, source)
    t = source.choice(PLACES)
    first, second = (_known(problem, w, u) for w, u in ends)
    between = tuple((1 - t) * rationals(a) + t * rationals(b) for a, b in zip(*ends, strict=True))
    inside = objective(problem, between[0], between[1])
    chord = Enclosure(
        (1 - t) * first.exact.lower + t * second.exact.lower,
        (1 - t) * first.exact.upper + t * second.exact.upper,
    )
    rounded = _known(problem, *((1.0 - float(t)) * a + float(t) * b for a, b in zip(*ends, strict=True)))
    yield _convex(inside, chord, _library_excess(first, second, rounded, t))
    values = [first.library, second.library, number(first.exact.lower), number(second.exact.lower)]
    least = min(value for value in values if not math.isnan(value))
    yield Observation.of("F1/bounded", least >= 0.0, max(0.0, -least), f"F = {least!r}")


def _convex(inside: Enclosure, chord: Enclosure, excess: float) -> Observation:
    above = share(inside.lower - chord.upper, chord.upper)
    if inside.lower > chord.upper:
        detail = f"F = {number(inside.lower)!r} on the chord, the chord is {number(chord.upper)!r}"
        return Observation("F1/convex", Outcome.FAILED, above, detail)
    if excess > 1.0:
        detail = f"the library's F lies above its chord by {excess!r} times what rounding explains"
        return Observation("F1/convex", Outcome.FAILED, excess, detail)
    decided = inside.upper <= chord.lower or inside == chord
    return Observation("F1/convex", Outcome.HELD if decided else Outcome.UNDECIDED, above)


def _known(problem: Problem, w: np.ndarray, u: np.ndarray) -> _Known:
    data, point = ExactProblem.of(problem), (rationals(w), rationals(u))
    p, q = magnitudes(data, *point)
    views, modalities = total(map(abs, point[0])), total(map(abs, point[1]))
    terms = ((1, squares(p)), (data.lambda1, squares(q)), (data.lambda2, views), (data.lambda3, modalities))
    magnitude = total(weight * plain for weight, plain in terms)
    allowance = ROUNDING * size(data) * (ULP * magnitude + underflow(data, *point))
    value = math.nan
    if max(magnitude, *(plain for _, plain in terms)) < LARGE:
        with np.errstate(all="ignore"):
            value = library.objective(problem, w, u)
    return _Known(objective(problem, w, u), value, allowance)


def _library_excess(first: _Known, second: _Known, between: _Known, t: Fraction) -> float:
    """How far the library's F lies above its own chord, as a multiple of what rounding explains."""
    if not all(math.isfinite(each.library) for each in (first, second, between)):
        return 0.0
    chord = (1 - t) * Fraction(first.library) + t * Fraction(second.library)
    allowance = first.allowance + second.allowance + between.allowance
    return share(Fraction(between.library) - chord, allowance)


CHECKS = (Check("chords", PARTS, observe),)
