"""Everything that the report says, as dataclasses: the pages are rendered from them, report.json holds them.

Schema of report.json: `report.schema.json` beside this file, made from these classes by
`verification.report.schema`.
"""

import hashlib
import json
import math
import re
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields, is_dataclass
from typing import Annotated, Any, Final, Literal

from convexperc.errors import InputError
from verification.ledger.baseline import Assessment, Judged
from verification.ledger.claims import CLAIMS, Claim, Part, Subject
from verification.ledger.evidence import Argument, Count, Refutation, Verdict
from verification.ledger.surveys import DECIDING, Comparison, Survey
from verification.ledger.verdicts import corrected_statements, survey_verdict
from verification.provenance import record_digest

SCHEMA: Final = "convexperc/report/2"
UNPRINTABLE = re.compile(r"[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""What XML 1.0 cannot hold, and HTML should not."""
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
    holds: Whole
    refuted: Whole
    inconclusive: Whole
    default: Comparison
    readings: Whole
    verdict: Verdict

    @classmethod
    def of(cls, survey: Survey) -> "SurveyCounts":
        """Leave out the levels of each factor and the origin, which the section on the experiments shows."""
        counts = survey.pictures, survey.holds, survey.refuted, survey.inconclusive, survey.default
        return cls(*counts, survey.readings, survey_verdict(survey))


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
class SubjectCounts:
    """How many of the judged claims about a subject have which verdict."""

    subject: Subject
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
    summary : tuple of SubjectCounts
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

    schema: Literal["convexperc/report/2"] = SCHEMA
    outcome: Assessment
    settings: Annotated[dict[str, Any], SETTINGS]
    summary: tuple[SubjectCounts, ...]
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


def contents(run: Judged, records: Mapping[str, bytes], experiments: dict[str, Any] | None = None) -> Report:
    """Gather what the report says.

    Parameters
    ----------
    run : Judged
    records : mapping of str to bytes
        Counterexamples by file name.
    experiments : dict or None
        What is shown of the record of the experiments, see `verification.report.experiments.summary.summary`.

    Raises
    ------
    InputError
        The settings lack one of `NEEDED`.
    """
    evidence = run.evidence
    if missing := [name for name in NEEDED if name not in evidence.settings]:
        raise InputError("settings", value=missing, must=f"must have {', '.join(NEEDED)}; these are missing")
    judged = [claim for claim in CLAIMS.values() if claim.id in run.judgements]
    return Report(
        outcome=run.assessment,
        settings=evidence.settings,
        summary=tuple(_summary(subject, judged, run) for subject in dict.fromkeys(c.subject for c in judged)),
        claims=tuple(_claim(claim, run) for claim in judged),
        unjudged=tuple(key for key in CLAIMS if key not in run.judgements),
        missing=tuple(evidence.missing),
        series=evidence.series,
        experiments=experiments,
        counterexamples={name: hashlib.sha256(data).hexdigest() for name, data in sorted(records.items())},
        volatile=evidence.volatile,
    )


def report_file(report: Report) -> bytes:
    """The bytes of report.json; the volatile block comes last."""
    return (json.dumps(plain(report), indent=1, allow_nan=False) + "\n").encode()


def plain(value: Any) -> Any:
    """JSON data; "inf", "-inf" and "nan" where JSON has no number, "?" for what no file can hold."""
    if is_dataclass(value):
        return {each.name: plain(getattr(value, each.name)) for each in fields(value)}
    if isinstance(value, Mapping):
        return {plain(str(key)): plain(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(entry) for entry in value]
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    return printable(str(value)) if isinstance(value, str) else value


def printable(text: str) -> str:
    """The text with "?" for what no file can hold."""
    return UNPRINTABLE.sub("?", text)


def _summary(subject: Subject, judged: list[Claim], run: Judged) -> SubjectCounts:
    found = Counter(run.judgements[claim.id].verdict for claim in judged if claim.subject is subject)
    return SubjectCounts(subject, found.total(), {verdict: found[verdict] for verdict in Verdict})


def _claim(claim: Claim, run: Judged) -> JudgedClaim:
    stated = vars(claim) | {"parts": tuple(_part(part, run) for part in claim.parts)}
    corrected = tuple(part.key for part in corrected_statements(claim))
    judgement = vars(run.judgements[claim.id])
    return JudgedClaim(**stated, **judgement, baseline=run.baseline.get(claim.id), corrected=corrected)


def _part(part: Part, run: Judged) -> JudgedPart:
    evidence, counts = run.evidence, run.evidence.of_part(part.key)
    names = dict.fromkeys(count.family for count in counts)
    families = {name: Cases.of(count for count in counts if count.family == name) for name in names}
    return JudgedPart(
        **vars(part),
        **vars(run.judgements[part.key]),
        baseline=run.baseline.get(part.key),
        cases=Cases.of(counts),
        families=families,
        worst_family=max(families, key=lambda name: families[name].worst, default=""),
        arguments=tuple(each for each in evidence.arguments if each.part == part.key),
        surveys=tuple(SurveyCounts.of(each) for each in evidence.surveys if each.part == part.key),
        counterexamples=tuple(each for each in evidence.refutations if each.part == part.key),
    )
