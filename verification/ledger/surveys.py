"""What the stored experiments say of a part of a claim: how many readings hold, refute, leave open."""

from dataclasses import asdict, dataclass
from typing import Any

from convexperc.errors import InputError

DECIDING = "simulation"
"""The set of pictures whose readings decide; others stand beside it."""
COMMAND = "python -m verification experiments"
"""What makes a record of the experiments."""


@dataclass(frozen=True, slots=True)
class Comparison:
    """The comparison that decides one reading.

    Attributes
    ----------
    outcome : str
        A value of `verification.ledger.rules.Reading`.
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
    """All readings of one part on one set of pictures, as a record of the experiments has them.

    Attributes
    ----------
    part : str
        A key of `verification.ledger.claims.PARTS`.
    pictures : str
        The name of the set, "simulation" or "photographs".
    holds, refuted, inconclusive : int
        Readings by what they say.
    default : Comparison
        The deciding comparison of the library's default reading.
    levels : dict of str to dict of str to (int, int, int)
        Readings that hold, refute and leave open, by factor and level.
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
    levels: dict[str, dict[str, tuple[int, int, int]]]
    record: str
    data: str
    command: str

    def __post_init__(self) -> None:
        if min(self.holds, self.refuted, self.inconclusive) < 0 or self.readings == 0:
            counts = (self.holds, self.refuted, self.inconclusive)
            must = "must be counts of readings, and at least one reading"
            raise InputError(f"readings of {self.part}", value=counts, must=must)

    @property
    def readings(self) -> int:
        """How many readings there are."""
        return self.holds + self.refuted + self.inconclusive

    @property
    def told(self) -> str:
        """The counts in words."""
        counts = f"refuted in {self.refuted}, open in {self.inconclusive}"
        return f"holds in {self.holds} of {self.readings} readings, {counts}"

    def as_json(self) -> dict[str, Any]:
        """Plain data."""
        return asdict(self)

    @classmethod
    def from_json(cls, data: dict[str, Any]) -> "Survey":
        """Read back what `as_json` wrote."""
        levels = {
            factor: {level: (counts[0], counts[1], counts[2]) for level, counts in by_level.items()}
            for factor, by_level in data["levels"].items()
        }
        return cls(**data | {"default": Comparison(**data["default"]), "levels": levels})
