"""Public Hypothesis strategies: problems by family, with small numbers that shrink to readable examples.

@given(problems("rank_deficient"))
def test_something(problem): ...
"""

import random
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from convexperc.errors import InputError
from convexperc.problem.arrays import Matrix
from convexperc.problem.problem import Problem
from verification.problems.families import DEGENERATE, FAMILIES, RANDOM

T = TypeVar("T")

LARGEST = (4, 8)
"""Default largest n and d: small enough to read, large enough for every family."""

ENTRIES = st.integers(-6, 6).map(lambda k: k / 2)
"""Entries of X and o: halves, so that sums of products are exact in float64."""


NARROW = 64
"""Wider ranges are drawn in two digits: Hypothesis mixes in numbers of 100 or more that it reads in the
source of whatever modules are loaded, and a campaign must not depend on these."""


@dataclass(frozen=True)
class Drawn:
    """Numbers from Hypothesis.

    Attributes
    ----------
    draw : hypothesis.strategies.DrawFn
    largest : (int, int)
        Largest n and largest d.
    """

    draw: st.DrawFn
    largest: tuple[int, int]

    def integer(self, low: int, high: int) -> int:
        """Draw an integer that shrinks towards `low`, or towards 0 if it may be negative."""
        if high - low < NARROW:
            return self.draw(st.integers(low, high))
        size = NARROW * self.draw(st.integers(0, max(high, -low) // NARROW)) + self.draw(
            st.integers(0, NARROW - 1)
        )
        negative = low < 0 and (high < 0 or self.draw(st.booleans()))
        return max(low, min(high, -size if negative else size))

    def choice(self, options: Sequence[T]) -> T:
        """Draw one that shrinks towards the shortest fraction, or the first where they are no floats."""
        return self.draw(st.sampled_from(sorted(options, key=_length)))

    def matrix(self, rows: int, columns: int) -> Matrix:
        """Draw halves in -3 .. 3 that shrink towards 0; all zeros, which say little, are drawn again."""
        entries = arrays(np.float64, (rows, columns), elements=ENTRIES, fill=st.nothing())
        values: Matrix = self.draw(entries)
        return values if values.any() else self.draw(entries)


def _length(option: object) -> int:
    """Bits of a float as a fraction; 0 for anything else."""
    return (
        sum(abs(part).bit_length() for part in option.as_integer_ratio()) if isinstance(option, float) else 0
    )


def problems(family: str | None = None, *, largest: tuple[int, int] = LARGEST) -> st.SearchStrategy[Problem]:
    """Problems of one family, or of any.

    Parameters
    ----------
    family : str or None
        A name of `verification.problems.families.FAMILIES`; None for any of them.
    largest : (int, int)
        Largest n and largest d, at least (2, 2).

    Returns
    -------
    SearchStrategy of Problem

    Raises
    ------
    InputError
        There is no such family, or `largest` is too small for the families to make sense.
    """
    if min(largest) < 2:
        raise InputError("largest", value=largest, must="must be at least (2, 2)")
    if family is None:
        return _of(tuple(FAMILIES), largest)
    if family not in FAMILIES:
        raise InputError("family", value=family, must=f"must be one of {', '.join(FAMILIES)}")
    return _problem(family, largest)


def random_problems(*, largest: tuple[int, int] = LARGEST) -> st.SearchStrategy[Problem]:
    """Problems with nothing special about them."""
    return _of(tuple(RANDOM), largest)


def degenerate_problems(*, largest: tuple[int, int] = LARGEST) -> st.SearchStrategy[Problem]:
    """Problems of every degenerate family."""
    return _of(tuple(DEGENERATE), largest)


def _of(families: tuple[str, ...], largest: tuple[int, int]) -> st.SearchStrategy[Problem]:
    return st.sampled_from(families).flatmap(lambda family: _problem(family, largest))


@st.composite
def _problem(draw: st.DrawFn, family: str, largest: tuple[int, int]) -> Problem:
    """Draw a problem; leave `random` untouched: run-time type checkers use it, Hypothesis forbids it."""
    drafted = FAMILIES[family](Drawn(draw, largest))
    state = random.getstate()
    try:
        return drafted.problem()
    finally:
        random.setstate(state)
