"""How claims about experiments are judged: one rule for a reading, one for all readings together.

The words and the numbers stand in `ledger.toml` and were fixed before any picture was looked at.
"""

from dataclasses import dataclass
from enum import StrEnum

from convexperc.errors import InputError


class Reading(StrEnum):
    """What one reading of the experiments says of a part of a claim."""

    HOLDS = "holds"
    REFUTED = "refuted"
    INCONCLUSIVE = "inconclusive"


@dataclass(frozen=True, slots=True)
class Rule:
    """What is compared for one part of a claim.

    Attributes
    ----------
    scenes : str
        On which scenes, with which setting and views.
    statistic : str
        What is averaged over the scenes; the part says that it is above 0.
    comparisons : int
        How many statistics there are; their intervals are joint.
    smallest_effect : float
        In the unit of the statistic: a gain that is smaller is no gain.
    """

    scenes: str
    statistic: str
    comparisons: int
    smallest_effect: float

    def __post_init__(self) -> None:
        if self.comparisons < 1:
            raise InputError("comparisons", value=self.comparisons, must="must be at least 1")
        if not 0.0 <= self.smallest_effect < 1.0:
            raise InputError("smallest_effect", value=self.smallest_effect, must="must be in [0, 1)")

    def outcome(self, lower: float, upper: float) -> Reading:
        """Judge a reading by its deciding comparison.

        That is the one with the smallest upper bound where it is below the smallest effect, else the one with
        the smallest lower bound.
        """
        if upper < self.smallest_effect:
            return Reading.REFUTED
        return Reading.HOLDS if lower > 0.0 else Reading.INCONCLUSIVE


@dataclass(frozen=True, slots=True)
class Protocol:
    """What all claims about experiments have in common; the words are for the report.

    Attributes
    ----------
    trials, score, unit, interval, holds, refuted, inconclusive, multiverse, readings : str
    resamples : int
        Of the bootstrap.
    confidence : float
        Of the intervals of a part together.
    supported_share : float
        Part of the readings in which a supported part holds, at least.
    refuted_share : float
        More than this part of the readings refute a refuted part.
    """

    trials: str
    score: str
    unit: str
    interval: str
    holds: str
    refuted: str
    inconclusive: str
    multiverse: str
    readings: str
    resamples: int
    confidence: float
    supported_share: float
    refuted_share: float

    def __post_init__(self) -> None:
        for name in ("confidence", "supported_share", "refuted_share"):
            if not 0.0 < getattr(self, name) < 1.0:
                raise InputError(name, value=getattr(self, name), must="must be in (0, 1)")
