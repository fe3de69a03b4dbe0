"""What the stored experiments say of a part of a claim, configuration by configuration.

A configuration is one choice of all that the paper leaves open.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, NamedTuple

from convexperc.errors import InputError

DECIDING = "simulation"
"""The set of pictures that decides; others stand beside it."""
COMMAND = "python -m verification experiments"
"""What makes a record of the experiments."""


class SurveyOutcome(StrEnum):
    """What one configuration says of a part of a claim; see `verification.ledger.rules.Rule`."""

    REPRODUCED = "reproduced"
    NO_EFFECT = "no effect"
    OPPOSITE = "opposite"
    OPEN = "open"


class Tally(NamedTuple):
    """Configurations by their outcome, in the order of `SurveyOutcome`."""

    reproduced: int
    no_effect: int
    opposite: int
    open: int

    @classmethod
    def of(cls, outcomes: Iterable[SurveyOutcome]) -> "Tally":
        """Count outcomes."""
        found = list(outcomes)
        return cls(*(found.count(kind) for kind in SurveyOutcome))

    @property
    def total(self) -> int:
        """How many configurations were counted."""
        return sum(self)

    @property
    def told(self) -> str:
        """The counts in words."""
        rest = ", ".join(
            f"{kind.value} in {count}" for kind, count in zip(SurveyOutcome, self, strict=True) if count
        )
        return f"of {self.total} configurations: {rest}"


def told_counts(tally: Tally, undefined: int) -> str:
    """Configurations by their outcome, in words, and those in which the statistic is undefined."""
    return tally.told + (f", and undefined in {undefined} more" if undefined else "")


Levels = Mapping[str, Mapping[str, Tally]]
"""Configurations by factor and level."""


@dataclass(frozen=True, slots=True)
class Comparison:
    """The comparison that decides one configuration.

    Attributes
    ----------
    outcome : str
        A value of `SurveyOutcome`.
    statistic, lower, upper : float or None
        The statistic and its interval; None where no scene defines it.
    name : str
        Which comparison it is.
    above : int
        Comparisons of the part whose mean is above 0, whatever their intervals.
    units : int
        Scenes that it is a mean of.
    left_out : int
        Scenes where the statistic is undefined.
    """

    outcome: str
    statistic: float | None
    lower: float | None
    upper: float | None
    name: str
    above: int
    units: int
    left_out: int

    @property
    def figures(self) -> str:
        """The statistic and its interval, in three digits; "-" where there is none."""
        if self.statistic is None or self.lower is None or self.upper is None:
            return "-"
        return f"{self.statistic:.3g} [{self.lower:.3g}, {self.upper:.3g}]"


@dataclass(frozen=True, slots=True)
class Spread:
    """The factor whose levels differ most in the share of configurations that reproduce a part.

    Attributes
    ----------
    factor : str
    most, least : str
        Its levels with the largest and the smallest share.
    size : float
        The difference of the two shares.
    told : str
        Both levels with their counts, in words.
    """

    factor: str
    most: str
    least: str
    size: float
    told: str

    @classmethod
    def widest(cls, levels: Levels) -> "Spread | None":
        """Find the factor; of equal ones the first. None where no factor has two levels that were tried."""
        found = [cls._of(factor, by_level) for factor, by_level in levels.items()]
        return max((each for each in found if each is not None), key=lambda each: each.size, default=None)

    @classmethod
    def _of(cls, factor: str, by_level: Mapping[str, Tally]) -> "Spread | None":
        shares = {name: each.reproduced / each.total for name, each in by_level.items() if each.total}
        if len(shares) < 2:
            return None
        most, least = max(shares, key=lambda each: shares[each]), min(shares, key=lambda each: shares[each])
        told = "; ".join(
            f"reproduced in {by_level[name].reproduced} of {by_level[name].total} with {name}"
            for name in (most, least)
        )
        return cls(factor, most, least, shares[most] - shares[least], told)


@dataclass(frozen=True, slots=True)
class Survey:
    """All configurations for one part and one set of pictures, as a record of the experiments has them.

    Attributes
    ----------
    part : str
        A key of `verification.ledger.claims.PARTS`.
    pictures : str
        The name of the set, "simulation" or "photographs".
    tally : Tally
        Configurations by their outcome.
    undefined : int
        Further configurations, in which no scene defines the statistic.
    agreeing : int
        Configurations in which the mean of every comparison is above 0, whatever its interval.
    default : Comparison
        The deciding comparison of the library's default configuration.
    levels : dict of str to dict of str to Tally
        By factor and level.
    record, data : str
        SHA-256 of the record and of the pictures.
    command : str
        What makes the record again.
    """

    part: str
    pictures: str
    tally: Tally
    undefined: int
    agreeing: int
    default: Comparison
    levels: dict[str, dict[str, Tally]]
    record: str
    data: str
    command: str

    def __post_init__(self) -> None:
        counts = (*self.tally, self.undefined, self.agreeing)
        if min(counts) < 0 or self.agreeing > self.tally.total or self.tally.total + self.undefined == 0:
            must = "must be counts of configurations, and at least one configuration"
            raise InputError(f"configurations of {self.part}", value=counts, must=must)

    @property
    def told(self) -> str:
        """The counts in words."""
        return told_counts(self.tally, self.undefined)

    @classmethod
    def from_json(cls, data: dict[str, Any]) -> "Survey":
        """Read back what `dataclasses.asdict` gave."""
        levels = {
            factor: {level: Tally(*counts) for level, counts in by_level.items()}
            for factor, by_level in data["levels"].items()
        }
        told = {"tally": Tally(*data["tally"]), "default": Comparison(**data["default"]), "levels": levels}
        return cls(**data | told)
