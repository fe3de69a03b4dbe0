"""Algorithm 1 in exact arithmetic: its start, its iterates, F along them, and whether a rise of F is real.

`verification.exact.algorithm` has one iteration; here the bits are chosen, and the answers are Fractions.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, TypeVar

import numpy as np
from flint import arb, fmpq
from numpy.typing import NDArray

from convexperc.problem.problem import Problem
from verification.exact.algorithm import Systems, Update
from verification.exact.balls import Numbers, UnresolvedError, ball, enclosed, exact, precision
from verification.exact.formulation import objective
from verification.exact.numbers import Enclosure, Rational
from verification.exact.problem import ExactProblem
from verification.exact.reweighting import SingularStepError

T = TypeVar("T")

PRECISIONS = (256, 1024, 4096)
"""Bits to try in turn; the longest are for entries that span all of float64."""

LONGEST = 2048
"""Rational iterates double their digits every few steps; beyond this many bits balls take over."""

Given = Sequence[Fraction] | Sequence[float] | NDArray[np.float64]
Enclosures = tuple[Enclosure, ...]


@dataclass(frozen=True)
class Iterate:
    """One iterate and F at it: enclosures, each of width 0 where the number is rational and short."""

    w: Enclosures
    u: Enclosures
    F: Enclosure


@dataclass(frozen=True)
class Rise:
    """F before and after one exact update; `confirmed` if it rose beyond doubt.

    Attributes
    ----------
    confirmed : bool
    before : Enclosure
    after : Enclosure or None
        None where a matrix is singular, so that there is no update.
    """

    confirmed: bool
    before: Enclosure
    after: Enclosure | None


def start(problem: Problem | ExactProblem) -> tuple[Rational, Rational]:
    """Return the exact start: w = argmin ||X'w - o||, then u = argmin ||Xu - w||, each of least norm."""
    w, u = Systems(problem).start()
    return _fractions(w), _fractions(u)


def step(
    problem: Problem | ExactProblem, update: Update, w: Given, u: Given
) -> tuple[Enclosures, Enclosures]:
    """Return the next (w, u) from a rational point: exact where all sizes in D are rational, else balls.

    Raises
    ------
    SingularStepError
        A matrix is singular, with its rank.
    UnresolvedError
        4096 bits do not tell.
    """
    systems, point = Systems(problem), (_numbers(w), _numbers(u))

    def once() -> tuple[Enclosures, Enclosures]:
        new_w, new_u = systems.step(update, *point)
        return _enclosures(new_w), _enclosures(new_u)

    return _with_bits(once)


def iterates(
    problem: Problem | ExactProblem, update: Update, origin: tuple[Given, Given] | None, count: int
) -> tuple[Iterate, ...]:
    """Return iterates 0 .. `count` from `origin`, None for the paper's start; fewer if one is singular.

    They are rational until a size is not or the numbers grow longer than `LONGEST` bits, then balls.

    Raises
    ------
    UnresolvedError
        4096 bits do not tell.
    """
    systems = Systems(problem)
    first = systems.start() if origin is None else (_numbers(origin[0]), _numbers(origin[1]))
    return _with_bits(lambda: _run(systems, update, first, count))


def rise_confirmed(
    problem: Problem | ExactProblem, update: Update, w: Given, u: Given, *, least: Fraction = Fraction(0)
) -> Rise:
    """Make one exact update from (w, u), taken as the rationals that they are, and compare F.

    Parameters
    ----------
    problem : Problem or ExactProblem
    update : Update
    w, u : floats or Fractions (n,), (d,)
    least : Fraction
        The rise that counts.

    Returns
    -------
    Rise
        Confirmed only if F after, at least, exceeds F before, at most, by more than `least`; not where the
        two cannot be told apart.

    Raises
    ------
    UnresolvedError
        4096 bits do not tell the update itself.
    """
    systems, point = Systems(problem), (_numbers(w), _numbers(u))
    after: Enclosure | None = None
    for bits in PRECISIONS:
        with precision(bits):
            try:
                before = objective(systems.problem, *point, bits=bits)
                quick = bits == PRECISIONS[0]
                new = systems.step(update, *(_shortened(x) if quick else x for x in point))
                after = objective(systems.problem, *new, bits=bits)
            except SingularStepError:
                return Rise(False, before, None)
            except UnresolvedError:
                if bits == PRECISIONS[-1] and after is None:
                    raise
                continue
        if after.lower > before.upper + least:
            return Rise(True, before, after)
        if after.upper <= before.lower + least:
            break
    return Rise(False, before, after)


def image(
    problem: ExactProblem, update: Update, w: Sequence[Enclosure], u: Sequence[Enclosure]
) -> tuple[Enclosures, Enclosures, Enclosure]:
    """Enclose the next (w, u) of every point of a box, and F at every point of the box itself.

    Raises
    ------
    UnresolvedError
        The box is too large.
    """
    with precision(PRECISIONS[0]):
        point = [ball(x) for x in w], [ball(x) for x in u]
        new_w, new_u = Systems(problem).step(update, *point)
        return _enclosures(new_w), _enclosures(new_u), objective(problem, *point)


def _run(systems: Systems, update: Update, first: tuple[Numbers, Numbers], count: int) -> tuple[Iterate, ...]:
    w, u = first
    found = [_iterate(systems.problem, w, u)]
    for _ in range(count):
        try:
            w, u = systems.step(update, w, u)
        except SingularStepError:
            break
        if any(_bits(x) > LONGEST for x in (*w, *u)):
            w, u = _shortened(w), _shortened(u)
        found.append(_iterate(systems.problem, w, u))
    return tuple(found)


def _iterate(problem: ExactProblem, w: Numbers, u: Numbers) -> Iterate:
    return Iterate(_enclosures(w), _enclosures(u), objective(problem, w, u, bits=PRECISIONS[0]))


def _bits(x: Any) -> int:
    return int(x.height_bits()) if isinstance(x, fmpq) else 0


def _shortened(values: Numbers) -> Numbers:
    """Balls for all but the exact zeros, which an update holds."""
    return [x if isinstance(x, fmpq) and x == 0 else arb(x) for x in values]


def _with_bits(compute: Callable[[], T]) -> T:
    for bits in PRECISIONS:
        with precision(bits):
            try:
                return compute()
            except UnresolvedError:
                if bits == PRECISIONS[-1]:
                    raise
    raise AssertionError("unreachable: the last precision returns or raises")


def _numbers(values: Given) -> Numbers:
    return [exact(value) for value in values]


def _enclosures(values: Numbers) -> Enclosures:
    return tuple(enclosed(x) for x in values)


def _fractions(values: Numbers) -> Rational:
    return tuple(enclosed(x).lower for x in values)
