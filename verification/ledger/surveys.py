"""What the stored experiments say of a part of a claim: in how many configurations it holds, or is refuted.

A configuration is one choice of all that the paper leaves open.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, NamedTuple

from convexperc.errors import InputError

DECIDING = "simulation"
"""The set of pictures that decides; others stand beside it."""
COMMAND = "python -m verification experiments"
"""What makes a record of the experiments."""


class SurveyOutcome(StrEnum):
    """What one configuration says of a part of a claim."""

    HOLDS = "holds"
    REFUTED = "refuted"
    INCONCLUSIVE = "inconclusive"


class Tally(NamedTuple):
    """Configurations by their outcome."""

    holds: int
    refuted: int
    inconclusive: int

    @classmethod
    def of(cls, outcomes: Iterable[SurveyOutcome]) -> "Tally":
        """Count outcomes."""
        found = list(outcomes)
        return cls(*(found.count(kind) for kind in SurveyOutcome))

    @property
    def total(self) -> int:
        """How many configurations were counted."""
        return sum(self)


@dataclass(frozen=True, slots=True)
class Comparison:
    """The comparison that decides one configuration.

    Attributes
    ----------
    outcome : str
        A value of `SurveyOutcome`.
    statistic, lower, upper : float or None
        The statistic and its joint interval; None where no scene defines it.
    name : str
        Which comparison it is.
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
    units: int
    left_out: int

    @property
    def figures(self) -> str:
        """The statistic and its interval, in three digits; "-" where there is none."""
        if self.statistic is None or self.lower is None or self.upper is None:
            return "-"
        return f"{self.statistic:.3g} [{self.lower:.3g}, {self.upper:.3g}]"


@dataclass(frozen=True, slots=True)
class Survey:
    """All configurations for one part and one set of pictures, as a record of the experiments has them.

    Attributes
    ----------
    part : str
        A key of `verification.ledger.claims.PARTS`.
    pictures : str
        The name of the set, "simulation" or "photographs".
    holds, refuted, inconclusive : int
        Configurations by their outcome.
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
    holds: int
    refuted: int
    inconclusive: int
    default: Comparison
    levels: dict[str, dict[str, Tally]]
    record: str
    data: str
    command: str

    def __post_init__(self) -> None:
        if min(self.holds, self.refuted, self.inconclusive) < 0 or self.readings == 0:
            counts = (self.holds, self.refuted, self.inconclusive)
            must = "must be counts of configurations, and at least one configuration"
            raise InputError(f"configurations of {self.part}", value=counts, must=must)

    @property
    def tally(self) -> Tally:
        """The counts."""
        return Tally(self.holds, self.refuted, self.inconclusive)

    @property
    def readings(self) -> int:
        """How many configurations there are."""
        return self.tally.total

    @property
    def told(self) -> str:
        """The counts in words."""
        counts = f"refuted in {self.refuted}, open in {self.inconclusive}"
        return f"holds in {self.holds} of {self.readings} configurations, {counts}"

    @classmethod
    def from_json(cls, data: dict[str, Any]) -> "Survey":
        """Read back what `dataclasses.asdict` gave."""
        levels = {
            factor: {level: Tally(*counts) for level, counts in by_level.items()}
            for factor, by_level in data["levels"].items()
        }
        return cls(**data | {"default": Comparison(**data["default"]), "levels": levels})
