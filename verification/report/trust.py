"""What the verdicts of a run rest on, and how to check it."""

from collections import Counter
from typing import NamedTuple

from verification.ledger.evidence import Checker, Verdict
from verification.report import words
from verification.report.contents import Report
from verification.report.proofs import Proofs
from verification.report.sentences import listed, many, replay

UNCHECKED = {Checker.CITED: "cited theorems", Checker.PROSE: "inferences in words"}
"""What no machine checks."""


class Basis(NamedTuple):
    """What some verdicts rest on."""

    verdicts: tuple[Verdict, ...]
    rests_on: str
    check: str


def bases(report: Report, proofs: Proofs) -> list[Basis]:
    """One row for each kind of evidence that this run has."""
    made = [_counterexamples(report), _proofs(report, proofs), _cases(report), _experiments(report)]
    return [each for each in made if each is not None]


def made(report: Report) -> tuple[str, str]:
    """The day and the commit of the run, as far as they are known."""
    machine = report.volatile.get("machine", report.volatile)
    machine = machine if isinstance(machine, dict) else {}
    day = str(machine.get("date", "unknown date"))[:16].replace("T", " ")
    return day, str(machine.get("commit", "unknown"))


def _counterexamples(report: Report) -> Basis | None:
    confirmed = [each for part in report.parts for each in part.counterexamples if each.confirmed]
    if not confirmed:
        return None
    by = Counter(each.basis for each in confirmed)
    told = listed([f"{count} ({basis})" for basis, count in sorted(by.items())])
    text = f"{many(confirmed, 'counterexample')}, confirmed again in this run: {told}."
    return Basis((Verdict.REFUTED,), text, replay("ID"))


def _proofs(report: Report, proofs: Proofs) -> Basis | None:
    if not proofs.listed:
        return None
    counted = proofs.by_checker.items()
    checked = {checker: count for checker, count in counted if checker.is_machine}
    kinds = ", ".join(f"{count} {checker}" for checker, count in checked.items())
    others = [f"{count} {UNCHECKED[checker]}" for checker, count in counted if not checker.is_machine]
    text = (
        f"{many(proofs.listed, 'written proof')}. A machine checked {sum(checked.values())} different steps"
        f" ({kinds})."
    )
    if others:
        text += f" No machine checks the {listed(others)}, which {words.THEOREM} gives."
    claim = next(proof.part.claim for proof in proofs.listed)
    return Basis((Verdict.HOLDS, Verdict.HOLDS_UNDER), text, f"python -m verification run --claim {claim}")


def _cases(report: Report) -> Basis | None:
    held = sum(part.cases.held for part in report.parts)
    if not held:
        return None
    text = (
        "Cases that were drawn from families of problems, without a failure. In all, the cases of this run"
        f" held {held:,} times. Another seed or a longer profile draws others."
    )
    return Basis((Verdict.SUPPORTED,), text, "python -m verification run --profile full --seed 1")


def _experiments(report: Report) -> Basis | None:
    if report.experiments is None:
        return None
    text = (
        "A stored record of the experiments, bound by its SHA-256"
        f" ({str(report.experiments['record'])[:12]}...), which this run read and did not measure. Its"
        " verdicts were counted again from its configurations."
    )
    kinds = (
        Verdict.REPRODUCED,
        Verdict.WHERE_DECIDED,
        Verdict.DEPENDS,
        Verdict.NOT_REPRODUCED,
        Verdict.OPPOSITE,
        Verdict.INCONCLUSIVE,
    )
    found = [claim.verdict for claim in report.claims if claim.surveyed]
    verdicts = tuple(kind for kind in kinds if kind in found)
    return Basis(verdicts, text, str(report.experiments["command"]))
