"""What a campaign found: counts by family, and every failure and every contradiction in full.

Schema of the JSON form; infinities are the string "inf":

``families``        one object a family, the fields of `Tally`;
``raw``             one object a family, the fields of `RawTally`, and ``family``;
``reasons``         failures by reason;
``failures``        one object each, the fields of `Failure`;
``contradictions``  one object each: ``case`` and ``statements`` that are disproved.
"""

import math
from collections import Counter
from dataclasses import asdict, dataclass, field, fields
from enum import StrEnum
from typing import Any

from verification.checks.raw import Raw
from verification.search.campaign.cases import Case


class Reason(StrEnum):
    """Why an answer is not certified, as far as the exact referee finds out."""

    CRASH = "the library raised an exception"
    REFEREE = "the referee raised an exception"
    NO_ANSWER = "the solver gave no point"
    POINT = "the point is not within the tolerance"
    PROOF = "the point is within the tolerance, the proof is not"
    OPEN = "the referee cannot tell"


@dataclass(frozen=True)
class Failure:
    """One problem that was not certified, with all that is needed to repeat it.

    Attributes
    ----------
    case : Case
    reason : Reason
    claim : str
        The solver's own word, or the exception.
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
    claim: str
    n: int = 0
    d: int = 0
    m: int = 0
    lambdas: tuple[float, float, float] = (0.0, 0.0, 0.0)
    relative_gap: float = math.inf
    share_of_target: float = math.inf
    true_gap: float = math.inf
    method: str = ""


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
    family : str
    total, certified, enclosed : int
        Problems; those with a certified answer; those with an enclosed optimum that no float64 point attains.
    failed : int
        Neither of the two, crashes among them.
    crashed : int
        An exception where there must be none.
    escalated : int
        Answered by ball arithmetic.
    refereed, loose : int
        Judged by the exact referee; those of them where its own interval is not as narrow as it should be.
    contradicted : int
        Certificates that say something false.
    seconds : float
        Spent on drawing, solving and judging; no part of a comparison.
    """

    family: str
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
        """Add the counts of the same family."""
        for each in fields(self)[1:]:
            setattr(self, each.name, getattr(self, each.name) + getattr(other, each.name))


LEVELS = {"above_1e_8": 1e-8, "above_1e_6": 1e-6, "above_1e_3": 1e-3}


@dataclass
class RawTally:
    """How raw CVXPY + Clarabel did on some problems of one family.

    Attributes
    ----------
    total, optimal, inaccurate, failed : int
        Problems; those with status "optimal"; "optimal_inaccurate"; anything else.
    outside : int
        Status "optimal", but a value outside the proved interval [lower, upper] of F*.
    above_1e_8, above_1e_6, above_1e_3 : int
        Those of them outside by more than this share of F*.
    worst : float
        Largest such share; infinite where F* = 0.
    """

    total: int = 0
    optimal: int = 0
    inaccurate: int = 0
    failed: int = 0
    outside: int = 0
    above_1e_8: int = 0
    above_1e_6: int = 0
    above_1e_3: int = 0
    worst: float = 0.0

    def count(self, raw: Raw, lower: float, upper: float) -> None:
        """Count one answer against the proved interval."""
        self.total += 1
        self.optimal += raw.optimal
        self.inaccurate += raw.inaccurate
        self.failed += not (raw.optimal or raw.inaccurate)
        distance = raw.distance(lower, upper) if raw.optimal else 0.0
        self.outside += distance > 0.0
        for name, level in LEVELS.items():
            setattr(self, name, getattr(self, name) + (distance > level))
        self.worst = max(self.worst, distance)

    def add(self, other: "RawTally") -> None:
        """Add the counts of the same family."""
        worst = max(self.worst, other.worst)
        for each in fields(self):
            setattr(self, each.name, getattr(self, each.name) + getattr(other, each.name))
        self.worst = worst


@dataclass
class Report:
    """Counts by family in the order of their first case, every failure, every contradiction."""

    families: dict[str, Tally] = field(default_factory=dict)
    raw: dict[str, RawTally] = field(default_factory=dict)
    failures: list[Failure] = field(default_factory=list)
    contradictions: list[Contradiction] = field(default_factory=list)

    @property
    def clean(self) -> bool:
        """All certified or enclosed, none contradicted, and at least one case looked at."""
        return self.total > 0 and not self.failures and not self.contradictions

    @property
    def total(self) -> int:
        """Cases looked at."""
        return sum(tally.total for tally in self.families.values())

    def tally(self, family: str) -> Tally:
        """The counts of one family, to be added to."""
        return self.families.setdefault(family, Tally(family))

    def raw_tally(self, family: str) -> RawTally:
        """The counts of one family, to be added to."""
        return self.raw.setdefault(family, RawTally())

    def reasons(self) -> dict[str, int]:
        """How many failures have which reason."""
        return dict(Counter(failure.reason.value for failure in self.failures))

    def add(self, other: "Report") -> None:
        """Add what another part of the campaign found."""
        for name, tally in other.families.items():
            self.tally(name).add(tally)
        for name, raw in other.raw.items():
            self.raw_tally(name).add(raw)
        self.failures += other.failures
        self.contradictions += other.contradictions

    def as_json(self) -> dict[str, Any]:
        """Plain data, for a JSON file."""
        plain: dict[str, Any] = _without_infinities(
            {
                "families": [asdict(tally) for tally in self.families.values()],
                "raw": [{"family": name} | asdict(raw) for name, raw in self.raw.items()],
                "reasons": self.reasons(),
                "failures": [asdict(failure) for failure in self.failures],
                "contradictions": [asdict(each) for each in self.contradictions],
            }
        )
        return plain

    @classmethod
    def from_json(cls, plain: dict[str, Any]) -> "Report":
        """Read back what `as_json` wrote."""
        data = _with_infinities(plain)
        raw = {each.pop("family"): RawTally(**each) for each in data["raw"]}
        failures = [_failure(each) for each in data["failures"]]
        contradictions = [
            Contradiction(Case(**each["case"]), tuple(each["statements"])) for each in data["contradictions"]
        ]
        return cls(
            {each["family"]: Tally(**each) for each in data["families"]}, raw, failures, contradictions
        )


def _failure(data: dict[str, Any]) -> Failure:
    changed = {
        "case": Case(**data["case"]),
        "reason": Reason(data["reason"]),
        "lambdas": tuple(data["lambdas"]),
    }
    return Failure(**{**data, **changed})


def _without_infinities(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _without_infinities(part) for key, part in value.items()}
    if isinstance(value, (list, tuple)):
        return [_without_infinities(part) for part in value]
    if isinstance(value, float) and math.isinf(value):
        return "inf" if value > 0 else "-inf"
    return value


def _with_infinities(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _with_infinities(part) for key, part in value.items()}
    if isinstance(value, list):
        return [_with_infinities(part) for part in value]
    return float(value) if value in ("inf", "-inf") else value
