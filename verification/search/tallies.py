"""What a campaign found: counts by family, and every failure and every contradiction in full.

Plain data, as in the journal and in the JSON file; infinities are the string "inf":

``families``        by family, the fields of `Tally`;
``clarabel``        by family, the fields of `verification.checks.clarabel.Tally`;
``failures``        one object each, the fields of `Failure`;
``contradictions``  one object each, the fields of `Contradiction`;
``lost``            by the name of a shard, how its worker process ended.
"""

import math
from collections import Counter
from dataclasses import asdict, dataclass, field
from enum import StrEnum
from typing import Any

from convexperc.problem.problem import Problem
from verification.checks.clarabel import Tally as ClarabelTally
from verification.checks.measures import add_fields
from verification.problems.families import FAMILIES, seeded


class Reason(StrEnum):
    """Why an answer is not certified, as far as the exact referee finds out."""

    CRASH = "the library raised an exception"
    REFEREE = "the referee raised an exception"
    NO_ANSWER = "the solver gave no point"
    POINT = "the point is not within the tolerance"
    PROOF = "the point is within the tolerance, the proof is not"
    OPEN = "the referee cannot tell"


@dataclass(frozen=True)
class Case:
    """One problem, repeated from its name alone: number `index` of the stream `seed` of a family."""

    family: str
    seed: int
    index: int

    def problem(self) -> Problem:
        """Draw it."""
        return seeded(self.family, self.seed, self.index)

    @property
    def order(self) -> tuple[int, int]:
        """By family, as these are listed, and index."""
        return list(FAMILIES).index(self.family), self.index


@dataclass(frozen=True)
class Failure:
    """One problem that was not certified, with all that is needed to repeat it.

    Attributes
    ----------
    case : Case
    reason : Reason
    status : str
        The solver's own status, or the exception.
    n, d, m : int
        0 where the problem could not even be drawn.
    lambdas : (float, float, float)
    relative_gap, share_of_target : float
        What the certificate proves; infinite without an answer.
    true_gap : float
        The referee's upper bound of (F(w, u) - F*) / F*, infinite if F* may be 0.
    method : str
        How the gap was proved.
    """

    case: Case
    reason: Reason
    status: str
    n: int = 0
    d: int = 0
    m: int = 0
    lambdas: tuple[float, float, float] = (0.0, 0.0, 0.0)
    relative_gap: float = math.inf
    share_of_target: float = math.inf
    true_gap: float = math.inf
    method: str = ""

    @classmethod
    def from_json(cls, data: dict[str, Any]) -> "Failure":
        """Read back what `Report.as_json` wrote."""
        gaps = {name: float(data[name]) for name in ("relative_gap", "share_of_target", "true_gap")}
        one, two, three = data["lambdas"]
        read = {"case": Case(**data["case"]), "reason": Reason(data["reason"]), "lambdas": (one, two, three)}
        return cls(**data | gaps | read)


@dataclass(frozen=True)
class Contradiction:
    """Statements of one certificate that are disproved."""

    case: Case
    statements: tuple[str, ...]


@dataclass
class Tally:
    """Counts of one family.

    Attributes
    ----------
    total, certified, enclosed : int
        Problems; those with a certified answer; those with an enclosed optimum that no float64 point attains.
    failed : int
        Neither of the two, crashes among them.
    crashed : int
        An exception where there must be none.
    escalated : int
        Answered by ball arithmetic.
    refereed, loose : int
        Compared with the exact referee; those of them where its own interval is wider than it should be.
    contradicted : int
        Certificates that say something false.
    seconds : float
        Spent on drawing, solving and refereeing; no part of a comparison.
    """

    total: int = 0
    certified: int = 0
    enclosed: int = 0
    failed: int = 0
    crashed: int = 0
    escalated: int = 0
    refereed: int = 0
    loose: int = 0
    contradicted: int = 0
    seconds: float = field(default=0.0, compare=False)

    def add(self, other: "Tally") -> None:
        """Add the counts of other problems."""
        add_fields(self, other)


@dataclass
class Report:
    """Counts by family, every failure, every contradiction, and the shards that were lost."""

    families: dict[str, Tally] = field(default_factory=dict)
    clarabel: dict[str, ClarabelTally] = field(default_factory=dict)
    failures: list[Failure] = field(default_factory=list)
    contradictions: list[Contradiction] = field(default_factory=list)
    lost: dict[str, str] = field(default_factory=dict)

    @property
    def clean(self) -> bool:
        """All certified or enclosed, none contradicted, nothing lost, and at least one problem looked at."""
        return self.total > 0 and not (self.failures or self.contradictions or self.lost)

    @property
    def total(self) -> int:
        """Problems looked at."""
        return sum(tally.total for tally in self.families.values())

    @property
    def reasons(self) -> dict[str, int]:
        """How many failures have which reason."""
        return dict(Counter(failure.reason.value for failure in self.failures))

    def tally(self, family: str) -> Tally:
        """The counts of one family, to be added to."""
        return self.families.setdefault(family, Tally())

    def clarabel_tally(self, family: str) -> ClarabelTally:
        """The counts of one family, to be added to."""
        return self.clarabel.setdefault(family, ClarabelTally())

    def add(self, other: "Report") -> None:
        """Add what another shard found."""
        for name, tally in other.families.items():
            self.tally(name).add(tally)
        for name, answers in other.clarabel.items():
            self.clarabel_tally(name).add(answers)
        self.failures += other.failures
        self.contradictions += other.contradictions
        self.lost |= other.lost

    def ordered(self) -> "Report":
        """The same by family and index, in whatever order the shards ended."""
        return Report(
            {name: self.families[name] for name in FAMILIES if name in self.families},
            {name: self.clarabel[name] for name in FAMILIES if name in self.clarabel},
            sorted(self.failures, key=lambda each: each.case.order),
            sorted(self.contradictions, key=lambda each: each.case.order),
            dict(sorted(self.lost.items())),
        )

    def as_json(self) -> dict[str, Any]:
        """Plain data."""
        plain: dict[str, Any] = _finite(asdict(self))
        return plain

    @classmethod
    def from_json(cls, data: dict[str, Any]) -> "Report":
        """Read back what `as_json` wrote."""
        return cls(
            {name: Tally(**each) for name, each in data["families"].items()},
            {
                name: ClarabelTally(**each | {"worst": float(each["worst"])})
                for name, each in data["clarabel"].items()
            },
            [Failure.from_json(each) for each in data["failures"]],
            [
                Contradiction(Case(**each["case"]), tuple(each["statements"]))
                for each in data["contradictions"]
            ],
            dict(data["lost"]),
        )


def _finite(value: Any) -> Any:
    """Plain data that JSON can hold."""
    if isinstance(value, dict):
        return {key: _finite(part) for key, part in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(part) for part in value]
    return str(value) if isinstance(value, float) and not math.isfinite(value) else value
