"""What is tried: numbers of views, repetitions, choices of the lambdas, resamples."""

from dataclasses import dataclass
from hashlib import sha256
from typing import Any

from convexperc.errors import InputError
from verification.ledger.claims import PROTOCOL

Pair = tuple[float, float]
"""lambda2 and lambda3."""

NOTHING, VIEWS_ALONE, FEATURES_ALONE, BOTH = (0.0, 0.0), (0.1, 0.0), (0.0, 0.1), (0.1, 0.1)
SETTINGS: tuple[Pair, ...] = (NOTHING, VIEWS_ALONE, FEATURES_ALONE, BOTH)
"""The four settings whose accuracies the paper plots against the number of views."""
GRID = (0.0, 0.01, 0.1, 1.0, 10.0)
"""Values of lambda2 and of lambda3: those that the paper's discussion names (of lambda3 not 1), and 0.01."""
GRID_COUNT = 3
"""Views of the first of the two subsets on which the grid is tried; the second has all."""
VIEWS = 6
"""Robots of a scene in which objects are recognised."""
STUDY_VIEWS, GOOD_VIEWS = 5, 3
"""Robots of a scene of the case study, and how many of them have a good view."""


@dataclass(frozen=True, slots=True)
class Design:
    """The sizes that may be chosen.

    Attributes
    ----------
    seed : int
        At least 0. Of the subsets of views, and of the resamples.
    repetitions : int
        Random subsets for each scene and number of views, at least 1.
    resamples : int
        Of the bootstrap, at least 1.

    Raises
    ------
    InputError
        A value is out of its range.
    """

    seed: int = 0
    repetitions: int = 10
    resamples: int = PROTOCOL.resamples

    def __post_init__(self) -> None:
        for name, least in (("seed", 0), ("repetitions", 1), ("resamples", 1)):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, int) or value < least:
                raise InputError(name, value=value, must=f"must be an integer of at least {least}")

    @property
    def counts(self) -> tuple[int, ...]:
        """Numbers of views, n = 1..6."""
        return tuple(range(1, VIEWS + 1))

    @property
    def pairs(self) -> tuple[Pair, ...]:
        """(lambda2, lambda3) of the grid's cells, row by row."""
        return tuple((two, three) for two in GRID for three in GRID)

    def as_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return {
            "seed": self.seed,
            "repetitions": self.repetitions,
            "counts": list(self.counts),
            "settings": [list(pair) for pair in SETTINGS],
            "grid": list(GRID),
            "resamples": self.resamples,
            "confidence": PROTOCOL.confidence,
        }


def key(name: str) -> int:
    """Return a number of 64 bits that seeds what belongs to a name."""
    return int.from_bytes(sha256(name.encode()).digest()[:8], "big")
