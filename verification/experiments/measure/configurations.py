"""Choices of all that the paper leaves open, and of the background: seven factors, and a regular fraction.

Three factors of four levels have two bits each, four of two levels one each: ten bits. Of the 1,024
combinations those are tried that `GENERATORS` accept: each is a set of bits of which an even number must be
one. Products of generators hold as well; each of the seven involves at least four factors, so that in the
128 configurations all combinations of the levels of any three factors are equally frequent (resolution IV in
factors).

Source: G. E. P. Box and J. S. Hunter, The 2^(k-p) fractional factorial designs, Technometrics 3, 1961; four
levels by two bits: S. Addelman, Technometrics 4, 1962.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

from convexperc.errors import InputError
from convexperc.features.configuration import BY_CHANNEL, JOINT, NORMALISATIONS, FeatureConfiguration

COLORS = {
    "by channel, 8 bins": (BY_CHANNEL, 8),
    "by channel, 32 bins": (BY_CHANNEL, 32),
    "joint, 4 bins a channel": (JOINT, 4),
    "joint, 8 bins a channel": (JOINT, 8),
}
CELLS = {"16-pixel cells": 16, "8-pixel cells": 8}
CIRCLES = {"P = 24, R = 3": (24, 3.0), "P = 8, R = 1": (8, 1.0)}
SIZES = {"128 x 128": 128, "64 x 64": 64}
BACKGROUNDS = {"kept": True, "cut away": False}

FACTORS: Mapping[str, tuple[Any, ...]] = {
    "lambda1": (0.1, 0.01, 1.0, 10.0),
    "normalisation": NORMALISATIONS,
    "color": tuple(COLORS),
    "hog": tuple(CELLS),
    "lbp": tuple(CIRCLES),
    "size": tuple(SIZES),
    "background": tuple(BACKGROUNDS),
}
"""Levels of each factor; the first is what the library does without being asked."""
GENERATORS = (0b0001010111, 0b0110011001, 0b1010101111)
"""Bit 0 is the first one of lambda1; the others follow in the order of `FACTORS`."""


@dataclass(frozen=True, slots=True)
class Configuration:
    """One level of each factor.

    Attributes
    ----------
    id : str
        "r000" is the default.
    levels : tuple
        In the order of `FACTORS`.
    """

    id: str
    levels: tuple[Any, ...]

    def __getitem__(self, factor: str) -> Any:
        return dict(zip(FACTORS, self.levels, strict=True))[factor]

    @property
    def lambda1(self) -> float:
        """The weight of the coupling of u and w."""
        return float(self["lambda1"])

    @property
    def background(self) -> bool:
        """Whether pixels are kept that do not show the object."""
        return BACKGROUNDS[self["background"]]

    @property
    def features(self) -> FeatureConfiguration:
        """How pictures are described."""
        kind, bins = COLORS[self["color"]]
        cell, size = CELLS[self["hog"]], SIZES[self["size"]]
        points, radius = CIRCLES[self["lbp"]]
        return FeatureConfiguration(
            working_size=(size, size),
            color_histogram=kind,
            color_bins=bins,
            hog_pixels_per_cell=(cell, cell),
            lbp_points=points,
            lbp_radius=radius,
            lbp_bins=points + 2,
            normalisation=self["normalisation"],
        )

    def as_json(self) -> dict[str, Any]:
        """Factor and level."""
        return dict(zip(FACTORS, self.levels, strict=True))


def owners() -> tuple[int, ...]:
    """The factor that each bit belongs to."""
    return tuple(k for k, levels in enumerate(FACTORS.values()) for _ in range(len(levels).bit_length() - 1))


@cache
def fraction() -> tuple[Configuration, ...]:
    """All of them, in an order of which every beginning is as balanced as it can be; the default first."""
    basis = _basis()
    words = [0]
    for vector in basis:
        words += [word ^ vector for word in words]
    return tuple(Configuration(f"r{k:03d}", _levels(word)) for k, word in enumerate(words))


def first(count: int) -> tuple[Configuration, ...]:
    """The first `count` configurations.

    Raises
    ------
    InputError
        `count` is less than 1 or more than there are.
    """
    everything = fraction()
    if not 1 <= count <= len(everything):
        raise InputError("readings", value=count, must=f"must be from 1 to {len(everything)}")
    return everything[:count]


def _levels(word: int) -> tuple[Any, ...]:
    """The level of each factor; two bits count as a number with the first one lowest."""
    chosen, shift = [], 0
    for levels in FACTORS.values():
        chosen.append(levels[word >> shift & (len(levels) - 1)])
        shift += len(levels).bit_length() - 1
    return tuple(chosen)


def _basis() -> list[int]:
    """Seven words that span the fraction, each next one chosen so that the span is the most balanced."""
    accepted = [w for w in range(1 << len(owners())) if all(_even(w & g) for g in GENERATORS)]
    basis: list[int] = []
    span = {0}
    while len(span) < len(accepted):
        best = min((w for w in accepted if w not in span), key=lambda w: (_aliases([*basis, w]), w))
        basis.append(best)
        span |= {word ^ best for word in span}
    return basis


def _aliases(basis: list[int]) -> tuple[int, ...]:
    """How many effects of one factor, of two, of three ... are constant on the span: fewest are wanted."""
    counts = [0] * (len(FACTORS) + 1)
    for word in range(1, 1 << len(owners())):
        if all(_even(word & vector) for vector in basis):
            counts[involved(word)] += 1
    return tuple(counts)


@cache
def involved(word: int) -> int:
    """Count the factors that a set of bits belongs to."""
    return len({owner for bit, owner in enumerate(owners()) if word >> bit & 1})


def _even(word: int) -> bool:
    return word.bit_count() % 2 == 0
