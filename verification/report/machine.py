"""report.json: everything that the report says, as plain data; the other files are rendered from it.

Schema: `report.schema.json` beside this file.
"""

import hashlib
import json
import math
import re
from collections import Counter
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from convexperc.errors import InputError
from verification.ledger.baseline import Assessment
from verification.ledger.claims import CLAIMS, Claim, Part
from verification.ledger.evidence import Argument, Count, Evidence, Judgement, Refutation, Verdict, summed
from verification.ledger.verdicts import nearest_true_form
from verification.provenance import record_digest
from verification.report.experiments.summary import survey_table

SCHEMA = "convexperc/report/1"
UNPRINTABLE = re.compile(r"[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""What XML 1.0 cannot hold, and HTML should not."""
NEEDED = ("command", "profile", "seed", "versions")
"""Settings without which nobody could repeat the run."""


def report_record(
    evidence: Evidence,
    judgements: Mapping[str, Judgement],
    baseline: Mapping[str, Verdict],
    assessment: Assessment,
    records: Mapping[str, bytes],
    experiments: Mapping[str, Any] | None = None,
) -> dict[str, Any]:
    """Gather what the report says.

    Parameters
    ----------
    evidence : Evidence
    judgements : mapping of str to Judgement
        On every claim that was judged and its parts, see `verification.ledger.verdicts.judge_all`.
    baseline : mapping of str to Verdict
    assessment : Assessment
    records : mapping of str to bytes
        Counterexamples by file name.
    experiments : mapping or None
        What is shown of the record of the experiments, see `verification.report.experiments.summary.summary`.

    Returns
    -------
    dict
        Plain data; "volatile" holds all that may differ between two runs of one seed, "digest" is the SHA-256
        of the canonical JSON of the rest.

    Raises
    ------
    InputError
        The settings lack one of `NEEDED`.
    """
    if missing := [name for name in NEEDED if name not in evidence.settings]:
        raise InputError("settings", value=missing, must=f"must have {', '.join(NEEDED)}; these are missing")
    judged = [claim for claim in CLAIMS.values() if claim.id in judgements]
    stable: dict[str, Any] = {
        "schema": SCHEMA,
        "outcome": _outcome(assessment),
        "settings": evidence.settings,
        "summary": _summary(judged, judgements),
        "claims": [_claim(claim, evidence, judgements, baseline) for claim in judged],
        "unjudged": [claim.id for claim in CLAIMS.values() if claim.id not in judgements],
        "missing": evidence.missing,
        "series": evidence.series,
        "experiments": experiments,
        "counterexamples": {name: hashlib.sha256(data).hexdigest() for name, data in sorted(records.items())},
    }
    stable = plain(stable)
    return stable | {"digest": record_digest(stable), "volatile": plain(evidence.volatile)}


def report_file(record: Mapping[str, Any]) -> bytes:
    """The bytes of report.json; the volatile block comes last."""
    return (json.dumps(record, indent=1, allow_nan=False) + "\n").encode()


def plain(value: Any) -> Any:
    """JSON data; "inf", "-inf" and "nan" where JSON has no number, "?" for what no file can hold."""
    if isinstance(value, Mapping):
        return {plain(str(key)): plain(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(entry) for entry in value]
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    return UNPRINTABLE.sub("?", str(value)) if isinstance(value, str) else value


def _outcome(assessment: Assessment) -> dict[str, Any]:
    return {
        "code": assessment.code,
        "changed": list(assessment.changed),
        "failed": list(assessment.failed),
        "stale": list(assessment.stale),
        "open": list(assessment.open),
    }


def _summary(judged: list[Claim], judgements: Mapping[str, Judgement]) -> list[dict[str, Any]]:
    subjects = dict.fromkeys(claim.subject for claim in judged)
    rows = []
    for subject in subjects:
        claims = [claim for claim in judged if claim.subject is subject]
        counted = Counter(judgements[claim.id].verdict for claim in claims)
        rows.append(
            {
                "subject": subject,
                "claims": len(claims),
                "verdicts": {verdict: counted[verdict] for verdict in Verdict},
            }
        )
    return rows


def _claim(
    claim: Claim,
    evidence: Evidence,
    judgements: Mapping[str, Judgement],
    baseline: Mapping[str, Verdict],
) -> dict[str, Any]:
    return {
        "id": claim.id,
        "place": claim.place,
        "subject": claim.subject,
        "statement": claim.statement,
        "method": claim.method,
        **_judged(claim.id, judgements, baseline),
        "nearest": [part.key for part in nearest_true_form(claim)],
        "parts": [_part(part, evidence, judgements, baseline) for part in claim.parts],
    }


def _part(
    part: Part,
    evidence: Evidence,
    judgements: Mapping[str, Judgement],
    baseline: Mapping[str, Verdict],
) -> dict[str, Any]:
    counts = _by_family(evidence.of_part(part.key))
    return {
        "key": part.key,
        "role": part.role,
        "statement": part.statement,
        "tolerance": part.tolerance,
        "measure": part.measure,
        **_judged(part.key, judgements, baseline),
        "count": _numbers(summed(counts, part.key)),
        "worst_family": max(counts, key=lambda count: count.worst).family if counts else "",
        "families": {count.family: _numbers(count) for count in counts},
        "arguments": [_argument(each) for each in evidence.arguments if each.part == part.key],
        "rule": asdict(part.rule) if part.rule else None,
        "surveys": [survey_table(each) for each in evidence.surveys if each.part == part.key],
        "counterexamples": [_refutation(each) for each in evidence.refutations if each.part == part.key],
    }


def _by_family(counts: list[Count]) -> list[Count]:
    merged: dict[str, Count] = {}
    for count in counts:
        merged.setdefault(count.family, Count(count.part, count.family)).add(count)
    return list(merged.values())


def _judged(
    key: str, judgements: Mapping[str, Judgement], baseline: Mapping[str, Verdict]
) -> dict[str, str | None]:
    found = judgements[key]
    return {
        "verdict": found.verdict,
        "reason": found.reason,
        "condition": found.condition,
        "baseline": baseline.get(key),
    }


def _numbers(count: Count) -> dict[str, float]:
    return {
        "held": count.held,
        "failed": count.failed,
        "undecided": count.undecided,
        "skipped": count.skipped,
        "worst": count.worst,
    }


def _argument(argument: Argument) -> dict[str, Any]:
    steps = [
        {
            "statement": step.statement,
            "checker": step.checker,
            "passed": step.passed,
            "source": step.source,
        }
        for step in argument.steps
    ]
    return {
        "conclusion": argument.conclusion,
        "condition": argument.condition,
        "passed": argument.passed,
        "steps": steps,
    }


def _refutation(found: Refutation) -> dict[str, Any]:
    return {
        "id": found.id,
        "confirmed": found.confirmed,
        "finding": found.finding,
        "size": found.size,
        "origin": found.origin,
        "given": found.given,
    }
