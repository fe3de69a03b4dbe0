"""The rule that turns evidence into verdicts: for each part, and for each claim over its stated parts.

Deterministic, and cautious on purpose: a failure refutes only when it was confirmed in exact arithmetic, a
part holds only with a written proof whose algebraic steps were all checked, and cases alone never do more
than support. The reason names what a verdict rests on.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import groupby
from operator import itemgetter

from convexperc.errors import ConvexpercError
from verification.ledger.claims import CLAIMS, PARTS, PROTOCOL, Claim, Part, Role
from verification.ledger.evidence import (
    Argument,
    Checker,
    Count,
    Evidence,
    Judgement,
    Refutation,
    Step,
    Verdict,
    summed,
)
from verification.ledger.surveys import COMMAND, DECIDING, Survey

WEAKEST_FIRST = (
    Verdict.NOT_TESTABLE,
    Verdict.INCONCLUSIVE,
    Verdict.SUPPORTED,
    Verdict.HOLDS_UNDER,
    Verdict.HOLDS,
)
"""The order in which a claim takes the verdict of its weakest stated part."""
WEAKEST_SURVEY_FIRST = (
    Verdict.NOT_TESTABLE,
    Verdict.OPPOSITE,
    Verdict.NOT_REPRODUCED,
    Verdict.INCONCLUSIVE,
    Verdict.DEPENDS,
    Verdict.WHERE_DECIDED,
    Verdict.REPRODUCED,
)
"""The same of a claim about the experiments."""

NOT_JUDGED = "not judged in this run"
"""Said of a part of another claim that was not selected."""


ABSENT = f"no record of the experiments has it; `{COMMAND}` makes one"
"""Why a part that no record speaks of is not testable."""


class ContradictionError(ConvexpercError, RuntimeError):
    """The verifier disagrees with itself: one part is both proved and refuted."""


def judge_all(evidence: Evidence) -> dict[str, Judgement]:
    """Judge the claims that the run was about, and their parts: all of the ledger, unless some were selected.

    Returns
    -------
    dict of str to Judgement
        By claim id and by part key, in the order of the ledger.

    Raises
    ------
    ContradictionError
        See `judge_part`.
    """
    claims = [claim for claim in CLAIMS.values() if is_selected(evidence, claim.id)]
    parts = {part.key: judge_part(part, evidence) for claim in claims for part in claim.parts}
    return {claim.id: judge_from_parts(claim, parts) for claim in claims} | parts


def is_selected(evidence: Evidence, claim: str) -> bool:
    """Whether the run was about this claim, as its settings say."""
    selected = evidence.settings.get("claims", ())
    return not selected or claim in selected


def judge(claim: Claim, evidence: Evidence) -> Judgement:
    """Judge one claim: refuted if a stated part is, else its weakest stated part.

    Raises
    ------
    ContradictionError
        See `judge_part`.
    """
    keys = {part.key for part in claim.parts} | {part.key for part in corrected_statements(claim)}
    return judge_from_parts(claim, {key: judge_part(PARTS[key], evidence) for key in sorted(keys)})


def judge_part(part: Part, evidence: Evidence) -> Judgement:
    """Judge one part.

    A confirmed counterexample refutes. Failures that nobody confirmed leave the part open, even where an
    argument passed: then the code does not do what was proved. Otherwise an argument proves and
    cases support. A part about the experiments is judged by its surveys alone.

    Raises
    ------
    ContradictionError
        A counterexample is confirmed and an argument without a condition passed.
    """
    if part.rule is not None:
        return judge_surveys(part, evidence.surveys)
    arguments = [argument for argument in evidence.arguments if argument.part == part.key]
    refutations = [found for found in evidence.refutations if found.part == part.key]
    count = summed(evidence.counts, part.key)
    if confirmed := [found for found in refutations if found.confirmed]:
        return _refuted(part, confirmed, arguments, count)
    notes = _notes(refutations, arguments, count)
    if count.failed:
        return Judgement(Verdict.INCONCLUSIVE, "; ".join([_unconfirmed(count, arguments), *notes]))
    if arguments and all(argument.passed for argument in arguments):
        return _proved(arguments, count, notes)
    if count.held:
        return Judgement(Verdict.SUPPORTED, "; ".join([_tested(count), *notes]))
    return Judgement(Verdict.INCONCLUSIVE, "; ".join(["no case was decided and no argument passed", *notes]))


def judge_from_parts(claim: Claim, parts: Mapping[str, Judgement]) -> Judgement:
    """Judge a claim by the verdicts on its parts and on the corrected statements."""
    stated = [part for part in claim.parts if part.role is Role.STATED]
    if claim.surveyed:
        return join_surveyed(
            *(
                {part.key: parts[part.key] for part in claim.parts if part.role is role}
                for role in (Role.STATED, Role.VARIANT)
            )
        )
    refuted = [part.key for part in stated if parts[part.key].verdict is Verdict.REFUTED]
    if refuted:
        repairs = [
            f"{part.key} {_corrected_in_words(parts.get(part.key))}" for part in corrected_statements(claim)
        ] or ["none is stated"]
        share = f" ({len(refuted)} of {len(stated)} stated parts)" if len(stated) > 1 else ""
        reason = f"{', '.join(refuted)}{share}"
        return Judgement(Verdict.REFUTED, f"{reason}; corrected statement: {', '.join(repairs)}")
    weakest = min((parts[part.key].verdict for part in stated), key=WEAKEST_FIRST.index)
    at_it = [part.key for part in stated if parts[part.key].verdict is weakest]
    conditions = (parts[key].condition for key in at_it)
    condition = "; ".join(dict.fromkeys(filter(None, conditions)))
    if len(stated) == 1:
        return Judgement(weakest, parts[stated[0].key].reason, condition)
    if len(at_it) == len(stated):
        return Judgement(weakest, f"the verdict on all {len(stated)} stated parts", condition)
    others = [parts[part.key].verdict for part in stated if part.key not in at_it]
    told = ", ".join(f"{verdict.value} ({others.count(verdict)})" for verdict in dict.fromkeys(others))
    reason = f"the weakest of {len(stated)} stated parts: {', '.join(at_it)}; the others: {told}"
    return Judgement(weakest, reason, condition)


def corrected_statements(claim: Claim) -> tuple[Part, ...]:
    """The parts that say what is true where the claim is not."""
    own = tuple(part for part in claim.parts if part.role is Role.REPAIR)
    return own + tuple(PARTS[key] for key in claim.repaired_by)


def survey_judgement(survey: Survey) -> Judgement:
    """Judge all configurations of one set together, by the rule of the ledger."""
    rule = PARTS[survey.part].rule
    verdict = PROTOCOL.verdict(survey.tally, figure=rule is not None and rule.figure)
    condition = PROTOCOL.deciding_factor(survey.levels) if verdict is Verdict.DEPENDS else ""
    return Judgement(verdict, f"{survey.pictures}, {survey.told}", condition)


def judge_surveys(part: Part, surveys: Sequence[Survey]) -> Judgement:
    """Judge a part by the simulation; what other pictures say is told beside it."""
    deciding = [survey for survey in surveys if survey.part == part.key and survey.pictures == DECIDING]
    if not deciding:
        return Judgement(Verdict.NOT_TESTABLE, ABSENT)
    found = survey_judgement(deciding[0])
    beside = [each for each in surveys if each.part == part.key and each is not deciding[0]]
    told = [f"{each.pictures}: {verdict_in_words(survey_judgement(each))}" for each in beside]
    return replace(found, reason="; ".join([found.reason, *told]))


def join_surveyed(parts: Mapping[str, Judgement], figures: Mapping[str, Judgement]) -> Judgement:
    """Judge a claim about the experiments by its weakest part, since it states them all.

    Parameters
    ----------
    parts, figures : mapping of str to Judgement
        By key: what the claim states, and the figures that it gives for single scenes, which are told beside.
    """
    joint = min((found.verdict for found in parts.values()), key=WEAKEST_SURVEY_FIRST.index)
    told = {key: found for key, found in parts.items() if found.verdict is joint}
    condition = "; ".join(dict.fromkeys(found.condition for found in told.values() if found.condition))
    if len(parts) + len(figures) == 1 or joint is Verdict.NOT_TESTABLE:
        return Judgement(joint, next(iter(told.values())).reason, condition)
    others = [f"{key}: {verdict_in_words(found)}" for key, found in parts.items() if key not in told]
    others += [f"{key}, a figure: {verdict_in_words(found)}" for key, found in figures.items()]
    reason = "; ".join([*(f"{key}: {found.reason}" for key, found in told.items()), *others])
    return Judgement(joint, reason, condition)


def _refuted(part: Part, confirmed: list[Refutation], arguments: list[Argument], count: Count) -> Judgement:
    proofs = [argument.conclusion for argument in arguments if argument.passed and not argument.condition]
    if proofs:
        raise ContradictionError(
            f"part {part.key}",
            value={"counterexample": confirmed[0].id, "argument": proofs[0]},
            must="must not be both proved without a condition and refuted",
            remedy="The verifier disagrees with itself: check argument, counterexample and ledger.",
        )
    reasons = [f"counterexample {confirmed[0].id}: {confirmed[0].finding} ({confirmed[0].basis})"]
    if len(confirmed) > 1:
        reasons.append(f"{len(confirmed) - 1} more confirmed")
    if count.failed:
        reasons.append(f"{count.failed:,} of {_cases(count, count.held + count.failed)} tried failed")
    reasons += [f"yet it holds under: {proof.condition}" for proof in arguments if proof.passed]
    return Judgement(Verdict.REFUTED, "; ".join(reasons))


def _proved(arguments: list[Argument], count: Count, notes: list[str]) -> Judgement:
    reasons = [f"written proof: {trust_base([step for argument in arguments for step in argument.steps])}"]
    if count.held:
        reasons.append(_tested(count))
    reason = "; ".join([*reasons, *notes])
    if any(not argument.condition for argument in arguments):
        return Judgement(Verdict.HOLDS, reason)
    return Judgement(Verdict.HOLDS_UNDER, reason, " or ".join(argument.condition for argument in arguments))


def trust_base(steps: Sequence[Step]) -> str:
    """What a proof rests on, counted: checked steps by their checker, cited theorems, joints in prose."""
    number = {checker: sum(step.checker is checker for step in steps) for checker in Checker}
    kinds = {
        Checker.IDENTITY: _many(number[Checker.IDENTITY], "exact identity", "exact identities"),
        Checker.SOLVERS: f"{number[Checker.SOLVERS]} by {Checker.SOLVERS}",
        Checker.EXACT: _many(number[Checker.EXACT], "exact evaluation", "exact evaluations"),
    }
    how = ", ".join(told for checker, told in kinds.items() if number[checker])
    checked = sum(number[checker] for checker in kinds)
    told = [f"{_many(checked, 'step', 'steps')} checked" + (f" ({how})" if how else "")]
    if number[Checker.CITED]:
        told.append(_many(number[Checker.CITED], "cited theorem", "cited theorems"))
    if number[Checker.PROSE]:
        places = sorted({step.source for step in steps if step.checker is Checker.PROSE})
        pages = groupby((place.split() for place in places), key=itemgetter(0))
        where = "; ".join(f"{page} {', '.join(section for _, section in found)}" for page, found in pages)
        told.append(f"{_many(number[Checker.PROSE], 'joint', 'joints')} in prose ({where})")
    return ", ".join(told)


def _many(number: int, one: str, several: str) -> str:
    return f"{number} {one if number == 1 else several}"


def _unconfirmed(count: Count, arguments: list[Argument]) -> str:
    several = "failure" if count.failed == 1 else "failures"
    reason = (
        f"{count.failed:,} {several} in {_cases(count, count.held + count.failed)}, none confirmed exactly"
    )
    if any(argument.passed for argument in arguments):
        return (
            f"{reason}, although its argument passed: the code does not do what was proved, or rounding shows"
        )
    return reason


def _notes(refutations: list[Refutation], arguments: list[Argument], count: Count) -> list[str]:
    notes = [f"{_cases(count, count.undecided)} undecided"] if count.undecided else []
    for argument in arguments:
        if not argument.passed:
            failed = [step.statement for step in argument.steps if not step.passed]
            notes.append(
                f"an argument failed at: {failed[0]}"
                if failed
                else "an argument has no step that a machine checked"
            )
    stale = [found.id for found in refutations if not found.confirmed]
    return notes + ([f"stale: {', '.join(stale)}"] if stale else [])


def verdict_in_words(judgement: Judgement) -> str:
    """A verdict with its condition."""
    return f"{judgement.verdict.value} {judgement.condition}".strip()


def _corrected_in_words(judgement: Judgement | None) -> str:
    return verdict_in_words(judgement) if judgement else NOT_JUDGED


def _tested(count: Count) -> str:
    return f"tested on {_cases(count, count.held)} without a failure"


def _cases(count: Count, number: int) -> str:
    return f"{number:,} {case_word(count.formula, number)}"


def case_word(formula: bool, number: int) -> str:
    """What the cases of a part are called: what evaluates a formula alone is no case of the code."""
    plural = "" if number == 1 else "s"
    return f"evaluation{plural} of the formula" if formula else f"case{plural}"
