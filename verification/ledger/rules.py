"""How claims about experiments are judged: one rule for a configuration, one for all of them together.

The words and the numbers stand in `ledger.toml`, which also says what had been seen when they were fixed.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from convexperc.errors import InputError
from verification.ledger.evidence import Verdict
from verification.ledger.surveys import Levels, Spread, SurveyOutcome, Tally

NO_FACTOR = "the configuration; no single factor decides"
"""What a part depends on where the levels of no factor differ by enough."""


class Bounds(NamedTuple):
    """Lower and upper bounds of several means."""

    lower: Sequence[float]
    upper: Sequence[float]


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
        How many statistics there are; the part says that all are above 0.
    smallest_effect : float
        In the unit of the statistic: an interval within it on either side of 0 shows no effect.
    figure : bool
        Whether the part states a figure: to miss it is not the opposite of anything.
    """

    scenes: str
    statistic: str
    comparisons: int
    smallest_effect: float
    figure: bool = False

    def __post_init__(self) -> None:
        if self.comparisons < 1:
            raise InputError("comparisons", value=self.comparisons, must="must be at least 1")
        if not 0.0 <= self.smallest_effect < 1.0:
            raise InputError("smallest_effect", value=self.smallest_effect, must="must be in [0, 1)")

    def outcome(self, lower: float, upper: float) -> SurveyOutcome:
        """What an interval says of the claim that its mean is above 0."""
        if lower > 0.0:
            return SurveyOutcome.REPRODUCED
        if upper < 0.0:
            return SurveyOutcome.OPPOSITE
        if -self.smallest_effect <= lower and upper <= self.smallest_effect and self.smallest_effect > 0.0:
            return SurveyOutcome.NO_EFFECT
        return SurveyOutcome.OPEN

    def decide(self, each: Bounds, joint: Bounds) -> tuple[int, Bounds]:
        """Find the comparison that decides a configuration, and the bounds by which it does.

        The part is a conjunction. It is reproduced if every interval by itself lies above 0 (an
        intersection-union test, which needs no correction); then the lowest decides. It fails as soon as one
        comparison fails: the joint intervals show which, the one that is lowest for the opposite, the
        narrowest that shows no effect. Else the lowest leaves it open.

        Parameters
        ----------
        each : Bounds
            Of every comparison by itself.
        joint : Bounds
            Of all together; each contains the one by itself.

        Returns
        -------
        (int, Bounds)
            `outcome` of the bounds, which have one entry each, is that of the configuration.

        Notes
        -----
        R. L. Berger, Multiparameter hypothesis testing and acceptance sampling, Technometrics 24 (1982).
        """
        lowest = each.lower.index(min(each.lower))
        if each.lower[lowest] > 0.0:
            return lowest, Bounds([each.lower[lowest]], [each.upper[lowest]])
        below = joint.upper.index(min(joint.upper))
        outcomes = [self.outcome(*bounds) for bounds in zip(*joint, strict=True)]
        flat = [k for k, outcome in enumerate(outcomes) if outcome is SurveyOutcome.NO_EFFECT]
        if outcomes[below] is SurveyOutcome.OPPOSITE:
            chosen = below
        elif flat:
            chosen = min(flat, key=lambda k: joint.upper[k] - joint.lower[k])
        else:
            chosen = lowest
        return chosen, Bounds([joint.lower[chosen]], [joint.upper[chosen]])


@dataclass(frozen=True, slots=True)
class Protocol:
    """What all claims about experiments have in common; the words are for the report.

    Attributes
    ----------
    seen, trials, score, unit, interval : str
    reproduced, opposite, no_effect, open : str
    sensitivity, configurations : str
    stated : mapping of str to str
        Level of a factor that the paper states: configurations with another level do not count.
    factors : mapping of str to str
        What a factor is called in a sentence, unless by its own name.
    resamples : int
        Of the bootstrap.
    confidence : float
        Of an interval by itself, and of the joint intervals of a part together.
    deciding_share : float
        Part of the configurations that must agree, at least; the same for every outcome.
    contradicted_share : float
        Part of the configurations with the opposite or no effect above which a part that is not reproduced is
        called so; with fewer it is inconclusive.
    deciding_spread : float
        Least difference between the levels of a factor that is said to decide.
    """

    seen: str
    trials: str
    score: str
    unit: str
    interval: str
    reproduced: str
    opposite: str
    no_effect: str
    open: str
    sensitivity: str
    configurations: str
    stated: Mapping[str, str]
    factors: Mapping[str, str]
    resamples: int
    confidence: float
    deciding_share: float
    contradicted_share: float
    deciding_spread: float

    def __post_init__(self) -> None:
        for name in ("confidence", "deciding_share", "contradicted_share", "deciding_spread"):
            if not 0.0 < getattr(self, name) < 1.0:
                raise InputError(name, value=getattr(self, name), must="must be in (0, 1)")

    def verdict(self, tally: Tally, *, figure: bool = False) -> Verdict:
        """Judge all configurations together.

        Parameters
        ----------
        tally : Tally
        figure : bool
            Whether the part states a figure.
        """
        if not tally.total:
            return Verdict.NOT_TESTABLE
        needed = self.deciding_share * tally.total
        if tally.reproduced >= needed:
            return Verdict.REPRODUCED
        if tally.opposite >= needed:
            return Verdict.NOT_REPRODUCED if figure else Verdict.OPPOSITE
        contradicted = tally.opposite + tally.no_effect
        if tally.total - tally.reproduced < needed:
            return Verdict.DEPENDS if tally.total - contradicted < needed else Verdict.WHERE_DECIDED
        decided = contradicted > self.contradicted_share * tally.total
        return Verdict.NOT_REPRODUCED if decided else Verdict.INCONCLUSIVE

    def widest(self, levels: Levels) -> Spread | None:
        """Of the factors that the paper leaves open, the one whose levels differ most."""
        return Spread.widest({name: each for name, each in levels.items() if name not in self.stated})

    def deciding_factor(self, levels: Levels) -> str:
        """Name what an outcome depends on: a factor with its extreme levels, or that there is no such one."""
        spread = self.widest(levels)
        if spread is None or spread.size < self.deciding_spread:
            return NO_FACTOR
        return f"{self.factors.get(spread.factor, spread.factor)}: {spread.told}"
