"""How claims about experiments are judged: one rule for a configuration, one for all of them together.

The words and the numbers stand in `ledger.toml` and were fixed before any picture was looked at.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from convexperc.errors import InputError
from verification.ledger.evidence import Verdict
from verification.ledger.surveys import SurveyOutcome, Tally


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

    def decisive(self, lower: Sequence[float], upper: Sequence[float]) -> int:
        """Find the comparison that decides, by its index.

        It has the smallest upper bound if that lies below the smallest effect, else the smallest lower bound.
        """
        bounds = upper if min(upper) < self.smallest_effect else lower
        return bounds.index(min(bounds))

    def outcome(self, lower: float, upper: float) -> SurveyOutcome:
        """Judge a configuration by the bounds of the comparison that decides."""
        if upper < self.smallest_effect:
            return SurveyOutcome.REFUTED
        return SurveyOutcome.HOLDS if lower > 0.0 else SurveyOutcome.INCONCLUSIVE


@dataclass(frozen=True, slots=True)
class Protocol:
    """What all claims about experiments have in common; the words are for the report.

    Attributes
    ----------
    trials, score, unit, interval, holds, refuted, inconclusive, multiverse, configurations : str
    resamples : int
        Of the bootstrap.
    confidence : float
        Of the intervals of a part together.
    supported_share : float
        Part of the configurations in which a supported part holds, at least.
    refuted_share : float
        More than this part of the configurations refute a refuted part.
    """

    trials: str
    score: str
    unit: str
    interval: str
    holds: str
    refuted: str
    inconclusive: str
    multiverse: str
    configurations: str
    resamples: int
    confidence: float
    supported_share: float
    refuted_share: float

    def __post_init__(self) -> None:
        for name in ("confidence", "supported_share", "refuted_share"):
            if not 0.0 < getattr(self, name) < 1.0:
                raise InputError(name, value=getattr(self, name), must="must be in (0, 1)")

    def verdict(self, tally: Tally) -> Verdict:
        """Judge all configurations together.

        Supported if the part holds in at least the stated share of them and none refutes it; refuted if more
        than the stated share refute it; otherwise inconclusive.
        """
        if tally.refuted > self.refuted_share * tally.total:
            return Verdict.REFUTED
        if not tally.refuted and tally.holds >= self.supported_share * tally.total:
            return Verdict.SUPPORTED
        return Verdict.INCONCLUSIVE
