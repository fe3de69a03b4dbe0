"""Everything that a report says, as dataclasses: the pages are rendered from them, report.json holds them.

Schema of report.json: `report.schema.json` beside this file, made from these classes by
`verification.report.schema`.
"""

import json
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Annotated, Any, Final, Literal

from verification.ledger.baseline import Assessment
from verification.ledger.claims import Claim, Part, Voice
from verification.ledger.evidence import Argument, Count, Refutation, Verdict
from verification.ledger.surveys import DECIDING, Comparison, Survey, Tally, told_counts
from verification.ledger.verdicts import survey_judgement
from verification.provenance import record_digest
from verification.report.plain import plain

SCHEMA: Final = "convexperc/report/3"
NEEDED = ("command", "profile", "seed", "versions")
"""Settings without which nobody could repeat the run."""
Sha256 = Annotated[str, {"pattern": "^[0-9a-f]{64}$"}]
Whole = Annotated[int, {"minimum": 0}]
PICTURES = (DECIDING, "photographs")
SETTINGS: dict[str, Any] = {
    "properties": {
        "command": {"type": "string"},
        "profile": {"type": "string"},
        "seed": {"type": "integer", "minimum": 0},
        "versions": {"type": "object", "additionalProperties": {"type": "string"}},
    },
    "required": list(NEEDED),
}
SETS: dict[str, Any] = {
    "properties": {"name": {"enum": list(PICTURES)}, "readings": {"type": "integer", "minimum": 1}},
    "required": ["name", "digest", "readings", "claims", "default", "spread", "gain"],
}
EXPERIMENTS: dict[str, Any] = {
    "properties": {"sets": {"type": "array", "minItems": 1, "items": {"type": "object"} | SETS}},
    "required": ["record", "command", "design", "sets"],
}
"""What the schema says of data that are no dataclasses."""


@dataclass(frozen=True)
class Cases:
    """Cases by outcome, of one family or of several together, and the largest measure of them."""

    held: Whole = 0
    failed: Whole = 0
    undecided: Whole = 0
    skipped: Whole = 0
    worst: float = 0.0

    @classmethod
    def of(cls, counts: "Iterable[Count | Cases]") -> "Cases":
        """Add them up."""
        every = list(counts)
        return cls(
            sum(count.held for count in every),
            sum(count.failed for count in every),
            sum(count.undecided for count in every),
            sum(count.skipped for count in every),
            max((count.worst for count in every), default=0.0),
        )

    @property
    def decided(self) -> int:
        """Those that held or failed."""
        return self.held + self.failed


@dataclass(frozen=True)
class SurveyCounts:
    """What the configurations of the experiments say of a part on one set of pictures."""

    pictures: Annotated[str, {"enum": list(PICTURES)}]
    reproduced: Whole
    no_effect: Whole
    opposite: Whole
    open: Whole
    undefined: Whole
    agreeing: Whole
    configurations: Whole
    default: Comparison
    verdict: Verdict
    condition: str

    @classmethod
    def of(cls, survey: Survey) -> "SurveyCounts":
        """Leave out the levels of each factor and the origin, which the section on the experiments shows."""
        found = survey_judgement(survey)
        counts = (*survey.tally, survey.undefined, survey.agreeing, survey.tally.total)
        return cls(survey.pictures, *counts, survey.default, found.verdict, found.condition)

    @property
    def told(self) -> str:
        """The counts in words."""
        tally = Tally(self.reproduced, self.no_effect, self.opposite, self.open)
        return told_counts(tally, self.undefined)


@dataclass(frozen=True, kw_only=True)
class JudgedPart(Part):
    """A part of the ledger with its verdict and all evidence on it.

    Attributes
    ----------
    verdict, reason, condition
        See `verification.ledger.evidence.Judgement`.
    baseline : Verdict or None
        What the baseline expects; None where it lists nothing.
    cases : Cases
        Over all families.
    formula : bool
        Whether the cases evaluate formulas of the paper alone, and no code that is judged.
    families : dict of str to Cases
    worst_family : str
        Where the largest measure was met.
    arguments : tuple of Argument
    surveys : tuple of SurveyCounts
        What a stored record says; it was not found by this run.
    counterexamples : tuple of Refutation
    """

    verdict: Verdict
    reason: str
    condition: str
    baseline: Verdict | None
    cases: Cases
    formula: bool
    families: dict[str, Cases]
    worst_family: str
    arguments: tuple[Argument, ...]
    surveys: tuple[SurveyCounts, ...]
    counterexamples: tuple[Refutation, ...]


@dataclass(frozen=True, kw_only=True)
class JudgedClaim(Claim):
    """A claim of the ledger with its verdict.

    Attributes
    ----------
    verdict, reason, condition, baseline
        As of a part.
    parts : tuple of JudgedPart
    corrected : tuple of str
        Keys of the parts that say what is true where the claim is not.
    """

    verdict: Verdict
    reason: str
    condition: str
    baseline: Verdict | None
    parts: tuple[JudgedPart, ...]
    corrected: tuple[str, ...]


@dataclass(frozen=True)
class VoiceCounts:
    """How many of the judged claims have which verdict, by who states them."""

    voice: Voice
    claims: Whole
    verdicts: dict[Verdict, Whole]


@dataclass(frozen=True, kw_only=True)
class Report:
    """All that a report says.

    Attributes
    ----------
    schema : str
    outcome : Assessment
        Exit code and the findings behind it.
    settings : dict
        All that the outcome depends on.
    summary : tuple of VoiceCounts
    claims : tuple of JudgedClaim
    unjudged : tuple of str
        Ids of the claims that the run was not about.
    missing : tuple of str
        What a run of this profile must have done and did not.
    series : dict
        Numbers of the figures, by name.
    experiments : dict or None
        What is shown of the record of the experiments; None where none was read or no claim about them was
        judged.
    counterexamples : dict of str to str
        SHA-256 of each file in counterexamples/.
    digest : str
        SHA-256 of the canonical JSON of all but itself and ``volatile``.
    volatile : dict
        The machine, the date, times: what may differ between two runs of one seed.
    """

    schema: Literal["convexperc/report/3"] = SCHEMA
    outcome: Assessment
    settings: Annotated[dict[str, Any], SETTINGS]
    summary: tuple[VoiceCounts, ...]
    claims: Annotated[tuple[JudgedClaim, ...], {"minItems": 1}]
    unjudged: tuple[str, ...]
    missing: tuple[str, ...]
    series: dict[str, Any]
    experiments: Annotated[dict[str, Any] | None, EXPERIMENTS]
    counterexamples: dict[str, Sha256]
    digest: Sha256 = field(init=False, default="")
    volatile: dict[str, Any]

    def __post_init__(self) -> None:
        object.__setattr__(self, "digest", record_digest(plain(self)))

    @property
    def parts(self) -> tuple[JudgedPart, ...]:
        """The parts of all judged claims."""
        return tuple(part for claim in self.claims for part in claim.parts)

    @property
    def file(self) -> bytes:
        """The bytes of report.json; the volatile block comes last."""
        return (json.dumps(plain(self), indent=1, allow_nan=False) + "\n").encode()
