"""What a run found, in a few sentences: made from its verdicts, so that they change with them."""

import re
from collections.abc import Sequence
from fractions import Fraction
from typing import NamedTuple

from verification.ledger.claims import CAUSES, Cause, Role, Subject, Voice
from verification.ledger.evidence import Refutation, Verdict
from verification.ledger.surveys import DECIDING
from verification.report.contents import JudgedClaim, JudgedPart, Report
from verification.report.sentences import examples, listed, many

RISE = re.compile(r"iteration (\d+): F (\S+) -> (\S+), ")
"""How a record of a rise tells its numbers: `verification.counterexamples.loops.confirm_rise`."""
WRONG_LIMIT = re.compile(r"F\* = (\S+); F = (\S+) at the fixed point")
"""The same of a wrong limit."""
SMALLEST = "the smallest in whole numbers"
"""What the size of a record says if an exhaustive search found nothing smaller."""
PROVED = (Verdict.HOLDS, Verdict.HOLDS_UNDER)
RIGHT = (*PROVED, Verdict.SUPPORTED, Verdict.REPRODUCED, Verdict.WHERE_DECIDED)
"""Verdicts in favour of a claim."""
DESCENT = ("T1c/descent/gauss_seidel", "T1c/descent/jacobi")
LIMIT = "T1c/limit"
LOOP = ("D1", "D2", "T1a", "T1b", "L2", "A2")
"""The claims about the weights D^w and D^u of the loop, and about the proof that uses them."""
IN_WORDS = {
    Verdict.REPRODUCED: ("is reproduced", "are reproduced"),
    Verdict.WHERE_DECIDED: ("is reproduced where the data decide", "are reproduced where the data decide"),
    Verdict.DEPENDS: (
        "depends on a choice that the paper leaves open",
        "depend on a choice that the paper leaves open",
    ),
    Verdict.NOT_REPRODUCED: ("is not reproduced", "are not reproduced"),
    Verdict.OPPOSITE: (
        "is contradicted in at least one comparison",
        "are contradicted in at least one comparison",
    ),
    Verdict.INCONCLUSIVE: ("remains undecided", "remain undecided"),
    Verdict.NOT_TESTABLE: ("could not be tested", "could not be tested"),
}


class Finding(NamedTuple):
    """A sentence or two, and the claims that it follows from, or the section that has them."""

    text: str
    claims: tuple[str, ...]


class Caused(NamedTuple):
    """A cause of some of the paper's refuted claims.

    Attributes
    ----------
    cause : Cause
    claims : tuple of str
        Ids of these claims.
    example : Refutation or None
        One counterexample, if it was confirmed in this run.
    corrected : tuple of JudgedPart
        What is true instead.
    unjudged : tuple of str
        Keys of further such parts, of claims that the run was not about.
    """

    cause: Cause
    claims: tuple[str, ...]
    example: Refutation | None
    corrected: tuple[JudgedPart, ...]
    unjudged: tuple[str, ...]


def findings(report: Report) -> list[Finding]:
    """The first screen: the theorem, its repair, the experiments, and what to do."""
    made = [_theorem(report), _repair(report), _experiments(report), _advice(report)]
    return [each for each in made if each is not None]


def _theorem(report: Report) -> Finding | None:
    claims = {claim.id: claim for claim in report.claims}
    first, second = claims.get("T1a"), claims.get("T1b")
    judged = tuple(claim.id for claim in (first, second) if claim)
    if not judged:
        return None
    told = ["Theorem 1 states that the iteration of Algorithm 1 converges to the minimum F*."]
    if Verdict.REFUTED in [claim.verdict for claim in (first, second) if claim]:
        told.append("As printed, this is false.")
    told += [_descent(first)] if first else []
    told.append(_limit(second, first) if second else "Its limit was not judged in this run.")
    return Finding(" ".join(told), judged)


def _descent(claim: JudgedClaim) -> str:
    """What happens to F from one iteration to the next."""
    if claim.verdict is not Verdict.REFUTED:
        return f"That the printed update never raises F: {_verdict(claim)}."
    for _, found in examples(claim):
        if numbers := RISE.match(found.finding):
            iteration, before, after = numbers.groups()
            smallest = "the smallest counterexample" if SMALLEST in found.size else "a counterexample"
            where = ", ".join(["", *_data(found), ""])
            return f"On {smallest}{where or ', '}iteration {iteration} raises F from {before} to {after}."
    return "F can rise from one iteration to the next."


def _limit(claim: JudgedClaim, before: JudgedClaim | None) -> str:
    """Where F tends to; of its data what differs from the counterexample that was told before."""
    if claim.verdict is not Verdict.REFUTED:
        return f"That its values tend to F*: {_verdict(claim)}."
    for _, found in examples(claim):
        if numbers := WRONG_LIMIT.search(found.finding):
            least, end = numbers.groups()
            known = [each for _, shown in examples(before)[:1] for each in _data(shown)] if before else []
            data = _data(found)
            changed = [each for each in data if each not in known]
            other = f"With {', '.join(changed)} instead" if 0 < len(changed) < len(data) else "On another one"
            return f"{other}, it settles at F = {_also_decimal(end)}, although F* = {least}."
    return "It can settle at a value above F*."


def _also_decimal(number: str) -> str:
    """A fraction, and its decimals if these are few and exact."""
    decimals = f"{float(Fraction(number)):g}"
    return f"{number} = {decimals}" if "/" in number and Fraction(decimals) == Fraction(number) else number


def _data(found: Refutation) -> list[str]:
    """The data of a counterexample, one by one."""
    return found.given.partition(";")[0].split(", ") if found.given else []


def _repair(report: Report) -> Finding | None:
    parts = {part.key: part for part in report.parts}
    descent, limit = [parts[key] for key in DESCENT if key in parts], parts.get(LIMIT)
    if not descent or limit is None:
        return None
    corrections = "|w_i| for w_i, and lambda2 D^w and lambda3 D^u for (lambda2/2) D^w and (lambda3/2) D^u"
    if all(part.verdict in PROVED for part in descent):
        told = f"With two corrections, {corrections}, F never rises."
    else:
        verdicts = listed([_verdict(each) for each in descent])
        told = f"With two corrections, {corrections}, that F never rises: {verdicts}."
    condition = "lambda1, lambda2, lambda3 > 0 and no entry of w and no block of u ever becomes exactly 0"
    if limit.verdict in PROVED:
        told += f" Its values then tend to F* provided that {condition}."
    else:
        told += f" That its values tend to F* provided that {condition}: {_verdict(limit)}."
    return Finding(told, ("T1c",))


def _experiments(report: Report) -> Finding | None:
    claims = [claim for claim in report.claims if claim.surveyed]
    if not claims:
        return None
    if all(claim.verdict is Verdict.NOT_TESTABLE for claim in claims):
        return Finding("No record of the experiments was available, so this run says nothing about them.", ())
    told = counted([claim.verdict for claim in claims])
    text = (
        "The paper's experiments were repeated on simulated scenes and on photographs, not on its own data,"
        f" which are not public. Of its {many(claims, 'claim')} about them, judged on the simulation, {told}."
    )
    return Finding(text, ("experiments",))


def counted(verdicts: Sequence[str]) -> str:
    """How many verdicts on experiments are of which kind, in words."""
    found = {verdict: verdicts.count(verdict) for verdict in IN_WORDS}
    return listed([f"{count} {IN_WORDS[verdict][count != 1]}" for verdict, count in found.items() if count])


def _advice(report: Report) -> Finding | None:
    """What to use instead, as far as it was judged in this run."""
    claims = {claim.id: claim for claim in report.claims}
    if "T1a" not in claims or claims["T1a"].verdict is not Verdict.REFUTED:
        return None
    told = [
        "In practice, solve the convex problem directly and check the result: `convexperc.solve` returns a"
        " proved interval for F*, and `convexperc.certify` proves one for the answer of any solver, such as"
        " CVXPY with Clarabel."
    ]
    if _repair(report) is not None:
        told.append(
            "To keep the iteration, use the corrected update, or the smoothed one, which has no exact zeros."
        )
    certified = claims.get("B2")
    if certified is not None and certified.verdict not in RIGHT:
        told.append(f"In this run, however, the claim that no certificate is false is {_verdict(certified)}.")
    return Finding(" ".join(told), ("B2", "T1c") if certified and "T1c" in claims else ())


def right(report: Report) -> list[JudgedClaim]:
    """The paper's claims whose verdict is in their favour; of the experiments see `right_parts`."""
    claims = [claim for claim in report.claims if claim.voice is Voice.PAPER and not claim.surveyed]
    return [claim for claim in claims if claim.verdict in RIGHT]


def right_parts(report: Report) -> list[JudgedPart]:
    """Stated parts of the paper's other claims whose verdict is in their favour.

    A claim about an experiment may name figures that are variants and were not found: its parts are exact.
    """
    taken = [claim.id for claim in right(report)]
    others = [claim for claim in report.claims if claim.voice is Voice.PAPER and claim.id not in taken]
    stated = [part for claim in others for part in claim.parts if part.role is Role.STATED]
    return [part for part in stated if part.verdict in RIGHT]


def where_decided(part: JudgedPart) -> str:
    """The counts of a part that is reproduced where the data decide; else empty."""
    if part.verdict is not Verdict.WHERE_DECIDED:
        return ""
    return next(each.told for each in part.surveys if each.pictures == DECIDING)


def structure(report: Report) -> str:
    """What is right about the algorithm, if its repair is proved in this run; else empty."""
    parts = {part.key: part for part in report.parts}
    if not all(key in parts and parts[key].verdict in PROVED for key in DESCENT):
        return ""
    return (
        "The structure of Algorithm 1, iteratively reweighted least squares, is sound: it replaces each"
        " norm by a weighted square and solves two linear systems in turn. With the two corrections above,"
        " this is a descent method for F, in either order of the two updates (T1c)."
    )


def causes(report: Report) -> list[Caused]:
    """Each cause of refuted claims of the paper, as far as they were judged."""
    refuted = _refuted(report)
    parts = {part.key: part for part in report.parts}
    records = {each.id: each for part in report.parts for each in part.counterexamples if each.confirmed}
    made = []
    for cause in CAUSES.values():
        claims = tuple(claim.id for claim in refuted if cause.id in claim.causes)
        if claims:
            corrected = tuple(parts[key] for key in cause.statements if key in parts)
            unjudged = tuple(key for key in cause.statements if key not in parts)
            made.append(Caused(cause, claims, records.get(cause.example), corrected, unjudged))
    return made


def counted_by_cause(report: Report) -> str:
    """How many refuted claims of the paper come from how many causes, and which of them are one story."""
    refuted = _refuted(report)
    if not refuted:
        return "No claim of the paper is refuted in this run."
    made = causes(report)
    told = f"{len(refuted)} of the paper's claims {'is' if len(refuted) == 1 else 'are'} refuted."
    if made:
        told += f" They have {many(made, 'cause')}; one claim may have several." if len(made) > 1 else ""
    loop = [each.id for each in refuted if each.id in LOOP]
    if len(loop) > 1:
        told += (
            f" {listed(loop)} are one story and should not be counted as {len(loop)} separate faults: they"
            " concern the weights D^w and D^u of the iteration, and the proof of Theorem 1 that relies on"
            " them."
        )
    return told


def _refuted(report: Report) -> list[JudgedClaim]:
    """The paper's claims that are refuted."""
    return [claim for claim in by_voice(report.claims, Voice.PAPER) if claim.verdict is Verdict.REFUTED]


def by_voice(claims: Sequence[JudgedClaim], voice: Voice) -> list[JudgedClaim]:
    """The claims that this voice states."""
    return [claim for claim in claims if claim.voice is voice]


def is_certificate(claim: JudgedClaim) -> bool:
    """Whether the claim is about what the report itself rests on: the library, or another solver."""
    return claim.subject in (Subject.LIBRARY, Subject.SOLVERS)


def _verdict(found: JudgedClaim | JudgedPart) -> str:
    """A verdict within a sentence."""
    if found.condition and found.verdict is Verdict.HOLDS_UNDER:
        return f"{found.verdict} {found.condition}"
    return f"{found.verdict} in this run"
