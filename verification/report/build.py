"""What a report says, gathered from a run that was judged."""

import hashlib
from collections import Counter
from collections.abc import Mapping
from typing import Any

from convexperc.errors import InputError
from verification.ledger.baseline import Judged
from verification.ledger.claims import CLAIMS, Claim, Part, Voice
from verification.ledger.evidence import Verdict
from verification.ledger.verdicts import corrected_statements
from verification.report.contents import (
    NEEDED,
    Cases,
    JudgedClaim,
    JudgedPart,
    Report,
    SurveyCounts,
    VoiceCounts,
)


def build(run: Judged, records: Mapping[str, bytes], experiments: dict[str, Any] | None = None) -> Report:
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
        summary=tuple(
            _summary(voice, judged, run) for voice in Voice if any(c.voice is voice for c in judged)
        ),
        claims=tuple(_claim(claim, run) for claim in judged),
        unjudged=tuple(key for key in CLAIMS if key not in run.judgements),
        missing=tuple(evidence.missing),
        series=evidence.series,
        experiments=experiments,
        counterexamples={name: hashlib.sha256(data).hexdigest() for name, data in sorted(records.items())},
        volatile=evidence.volatile,
    )


def _summary(voice: Voice, judged: list[Claim], run: Judged) -> VoiceCounts:
    found = Counter(run.judgements[claim.id].verdict for claim in judged if claim.voice is voice)
    return VoiceCounts(voice, found.total(), {verdict: found[verdict] for verdict in Verdict})


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
        formula=any(count.formula for count in counts),
        families=families,
        worst_family=max(families, key=lambda name: families[name].worst, default=""),
        arguments=tuple(each for each in evidence.arguments if each.part == part.key),
        surveys=tuple(SurveyCounts.of(each) for each in evidence.surveys if each.part == part.key),
        counterexamples=tuple(each for each in evidence.refutations if each.part == part.key),
    )
