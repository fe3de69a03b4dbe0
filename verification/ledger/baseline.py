"""The verdicts that are expected, and what a run that differs from them means for its exit code."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files
from importlib.resources.abc import Traversable
from typing import Literal

from convexperc.errors import FileFormatError
from verification.ledger.claims import CLAIMS, PARTS, Role, Voice
from verification.ledger.evidence import Evidence, Judgement, Verdict, summed
from verification.ledger.verdicts import is_selected, judge_all

SCHEMA = "convexperc/baseline/1"
BASELINE = files("verification.ledger") / "baseline.json"


@dataclass(frozen=True)
class Change:
    """A verdict that is not the baseline's.

    Attributes
    ----------
    key : str
        A claim's id or a part's key.
    before, after : str
        Verdicts; "not listed" where the baseline or the ledger lacks the key.
    """

    key: str
    before: str
    after: str

    def __str__(self) -> str:
        """One line."""
        return f"{self.key}: {self.after}, the baseline says {self.before}"


@dataclass(frozen=True)
class Assessment:
    """What a run amounts to.

    Attributes
    ----------
    code : int
        0: every verdict is the baseline's. 1: a verdict changed, a promise of the library failed, or a
        record is stale. 3: nothing of that, but something required was not run or stayed open.
    changed, failed, stale, open : tuple of str
        One line for each finding; the first three make the code 1, the last 3.
    """

    code: Literal[0, 1, 3]
    changed: tuple[str, ...]
    failed: tuple[str, ...]
    stale: tuple[str, ...]
    open: tuple[str, ...]

    @property
    def messages(self) -> tuple[str, ...]:
        """All findings, the gravest first."""
        return self.failed + self.changed + self.stale + self.open


NOT_LISTED = "not listed"


@dataclass(frozen=True)
class Judged:
    """A run with everything that is concluded from it.

    Attributes
    ----------
    evidence : Evidence
    judgements : mapping of str to Judgement
        By claim id and part key, see `verification.ledger.verdicts.judge_all`.
    baseline : mapping of str to Verdict
        What was expected of the claims that the run was about.
    assessment : Assessment
    """

    evidence: Evidence
    judgements: Mapping[str, Judgement]
    baseline: Mapping[str, Verdict]
    assessment: Assessment

    @classmethod
    def of(cls, evidence: Evidence, baseline: Mapping[str, Verdict] | None = None) -> "Judged":
        """Judge a run, by the committed baseline unless another one is given.

        Raises
        ------
        ContradictionError
            See `verification.ledger.verdicts.judge_part`.
        """
        judgements = judge_all(evidence)
        expected = for_run(read_baseline() if baseline is None else baseline, evidence)
        return cls(evidence, judgements, expected, assess(evidence, judgements, expected))


def read_baseline(path: Traversable = BASELINE) -> dict[str, Verdict]:
    """Read the expected verdict of every claim and part.

    Raises
    ------
    FileFormatError
        The file cannot be read, or holds something other than verdicts by key.
    """
    remedy = "Write it anew from a run whose verdicts you have read."
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
        if data["schema"] != SCHEMA:
            raise FileFormatError(f"schema of {path.name}", value=data["schema"], must=f"must be {SCHEMA!r}")
        return {key: Verdict(word) for key, word in (data["claims"] | data["parts"]).items()}
    except OSError as problem:
        raise FileFormatError(
            path.name, value=problem.strerror, must="must be readable", remedy=remedy
        ) from None
    except (KeyError, TypeError, ValueError, AttributeError) as problem:
        if isinstance(problem, FileFormatError):
            raise
        raise FileFormatError(
            path.name, value=str(problem), must="must map claims and parts to verdicts", remedy=remedy
        ) from None


def baseline_file(judgements: Mapping[str, Judgement]) -> bytes:
    """The content of a baseline that expects these verdicts."""
    data = {
        "schema": SCHEMA,
        "claims": {key: judgements[key].verdict.value for key in CLAIMS},
        "parts": {key: judgements[key].verdict.value for key in PARTS},
    }
    return (json.dumps(data, indent=1) + "\n").encode()


def for_run(baseline: Mapping[str, Verdict], evidence: Evidence) -> dict[str, Verdict]:
    """What the baseline expects of the claims that a run was about."""
    return {key: each for key, each in baseline.items() if is_selected(evidence, key.split("/")[0])}


def compare(judgements: Mapping[str, Judgement], baseline: Mapping[str, Verdict]) -> tuple[Change, ...]:
    """Every verdict that differs from the baseline's, in the order of the ledger."""
    keys = dict.fromkeys([*judgements, *baseline])
    before = {key: baseline[key].value if key in baseline else NOT_LISTED for key in keys}
    after = {key: judgements[key].verdict.value if key in judgements else NOT_LISTED for key in keys}
    return tuple(Change(key, before[key], after[key]) for key in keys if before[key] != after[key])


def assess(
    evidence: Evidence, judgements: Mapping[str, Judgement], baseline: Mapping[str, Verdict]
) -> Assessment:
    """Compare a run with the baseline and say what it amounts to.

    A verdict that became inconclusive although nothing failed is not a change but something left open: a
    shorter run, or a check that broke. Where a case or a step failed it is a change. A claim about the
    experiments is open where no record speaks of it; what a record says of it is never merely open.
    """
    changes = compare(judgements, baseline)
    unproved = [change for change in changes if _merely_open(change, evidence)]
    left = [str(change) for change in unproved] + [f"missing: {what}" for what in evidence.missing]
    changed = tuple(str(change) for change in changes if change not in unproved)
    failed = _failed_promises(evidence)
    stale = tuple(
        f"{found.part}: record {found.id} no longer fails"
        for found in evidence.refutations
        if not found.confirmed
    )
    code: Literal[0, 1, 3] = 1 if changed or failed or stale else 3 if left else 0
    return Assessment(code, changed, failed, stale, tuple(left))


def _failed_promises(evidence: Evidence) -> tuple[str, ...]:
    lines = []
    for key, part in PARTS.items():
        if CLAIMS[part.claim].voice is not Voice.PROMISE:
            continue
        count = summed(evidence.counts, key)
        if count.failed:
            lines.append(f"{key}: {count.failed:,} of {count.held + count.failed:,} cases failed")
        lines += [
            f"{key}: {found.finding}"
            for found in evidence.refutations
            if found.part == key and found.confirmed
        ]
    return tuple(lines)


def _merely_open(change: Change, evidence: Evidence) -> bool:
    claim = CLAIMS.get(change.key.split("/")[0])
    if claim is not None and claim.surveyed:
        return change.after == Verdict.NOT_TESTABLE
    if change.after != Verdict.INCONCLUSIVE:
        return False
    if change.key in PARTS:
        keys = {change.key}
    else:
        keys = {part.key for part in CLAIMS[change.key].parts if part.role is Role.STATED}
    failed = any(summed(evidence.counts, key).failed for key in keys)
    broken = any(not argument.passed for argument in evidence.arguments if argument.part in keys)
    return not failed and not broken
