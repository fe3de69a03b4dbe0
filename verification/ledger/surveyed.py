"""The rule that turns the readings of the experiments into the verdict on a part."""

from collections.abc import Mapping, Sequence

from verification.ledger.claims import PROTOCOL, Part
from verification.ledger.evidence import Judgement, Verdict
from verification.ledger.survey import Survey

DECIDING = "simulation"
"""The set of pictures whose readings decide; others stand beside it."""
COMMAND = "python -m verification experiments"
"""What makes a record of the experiments."""
ABSENT = f"no record of the experiments has it; `{COMMAND}` makes one"
"""Why a part that no record speaks of is not testable."""


def verdict(survey: Survey) -> Verdict:
    """Judge all readings of one set together.

    Supported if the part holds in at least the stated share of the readings and none refutes it; refuted if
    more than the stated share refute it; otherwise inconclusive.
    """
    if survey.refuted > PROTOCOL.refuted_share * survey.readings:
        return Verdict.REFUTED
    if not survey.refuted and survey.holds >= PROTOCOL.supported_share * survey.readings:
        return Verdict.SUPPORTED
    return Verdict.INCONCLUSIVE


def judge_surveys(part: Part, surveys: Sequence[Survey]) -> Judgement:
    """Judge a part by the simulation; what other pictures say is told beside it."""
    deciding = [survey for survey in surveys if survey.part == part.key and survey.pictures == DECIDING]
    if not deciding:
        return Judgement(Verdict.NOT_TESTABLE, ABSENT)
    found = deciding[0]
    beside = (each for each in surveys if each.part == part.key and each is not found)
    told = [f"{DECIDING}: {found.told}", *(f"{each.pictures}: {verdict(each).value}" for each in beside)]
    return Judgement(verdict(found), "; ".join(told))


def join_surveyed(parts: Mapping[str, Judgement]) -> Judgement:
    """Judge a claim about the experiments: refuted if a part is, supported if all are."""
    order = (Verdict.REFUTED, Verdict.NOT_TESTABLE, Verdict.INCONCLUSIVE, Verdict.SUPPORTED)
    joint = min((found.verdict for found in parts.values()), key=order.index)
    told = {key: found.reason for key, found in parts.items() if found.verdict is joint}
    if len(parts) == 1 or joint is Verdict.NOT_TESTABLE:
        return Judgement(joint, next(iter(told.values())))
    others = [f"{key}: {found.verdict.value}" for key, found in parts.items() if key not in told]
    return Judgement(joint, "; ".join([*(f"{key}: {reason}" for key, reason in told.items()), *others]))
