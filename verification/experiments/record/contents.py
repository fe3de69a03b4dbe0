"""The plain data of a record of the experiments, as experiments.json has it.

Floats have six significant digits. The digest is the SHA-256 of the canonical text (sorted keys, no spaces)
of everything but ``digest`` and ``volatile``.
"""

from typing import Annotated, Any, Literal, TypedDict

from verification.experiments.record.entries import (
    OF_CLAIMS,
    OF_FACTORS,
    OF_GRID,
    OF_SETTINGS,
    Count,
    Counts,
    Detail,
    Entry,
    Level,
    Limits,
    Number,
    Positive,
    Ranking,
)
from verification.ledger.surveys import DECIDING

PHOTOGRAPHS = "photographs"
"""The set that stands beside the simulation."""
Digest = Annotated[str, {"pattern": "^[0-9a-f]{64}$"}]
Pair = Annotated[list[Number], {"minItems": 2, "maxItems": 2}]


class Plan(TypedDict):
    """The design, and the levels of each factor."""

    seed: Count
    repetitions: Positive
    counts: list[int]
    settings: Annotated[list[Pair], OF_SETTINGS]
    grid: Annotated[list[Number], OF_GRID]
    resamples: Positive
    confidence: Number
    factors: Annotated[dict[str, list[Level]], OF_FACTORS]


class Study(TypedDict):
    """The pictures of the case study."""

    objects: list[str]
    scenes: Count
    views: Count
    source: dict[str, Any]


class Head(TypedDict):
    """What a set of pictures is."""

    name: Annotated[str, {"enum": [DECIDING, PHOTOGRAPHS]}]
    digest: Digest
    source: dict[str, Any]
    objects: Annotated[list[str], {"minItems": 2}]
    scenes: Count
    views: Count
    levels: dict[str, Count]
    case_study: Study


class SetData(Head):
    """A set of pictures, and what was found on it."""

    claims: Annotated[dict[str, Counts], OF_CLAIMS]
    readings: Annotated[list[Entry], {"minItems": 1}]
    default: Detail
    rankings: list[Ranking]
    limits: Limits


class ExperimentsData(TypedDict):
    """The whole file."""

    format: Literal[2]
    design: Plan
    sets: Annotated[list[SetData], {"minItems": 1}]
    digest: Digest
    volatile: dict[str, Any]
