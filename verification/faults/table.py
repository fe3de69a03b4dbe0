"""The table of planted faults: what was planted, and what caught it where."""

from collections.abc import Callable, Sequence
from dataclasses import asdict
from typing import Any

from rich.table import Table

from verification.faults.fault import Fault
from verification.faults.hunt import SEED, Caught, hunt
from verification.faults.own import FAULTS

SCHEMA = "convexperc/faults/1"
WIDTH = 140
WHAT = (
    "Each fault is planted in the running code, one at a time; the check that should name it then hunts for a"
    " problem that shows it, and Hypothesis shrinks that. Nothing is found when nothing is planted. n x d is"
    " the size of the shrunk problem, bits the length of its numbers as fractions."
)
VOLATILE = (
    "The seconds are those of one run on one machine; two runs of the same versions differ in nothing else."
)


def planted(
    progress: Callable[[int, int], None] = lambda done, total: None, faults: Sequence[Fault] = FAULTS
) -> tuple[Caught, ...]:
    """Plant one fault after the other and let its check hunt for it.

    Parameters
    ----------
    progress : callable
        Called with how many are done and how many there are.
    faults : sequence of Fault

    Returns
    -------
    tuple of Caught
        In the order of `faults`.
    """
    outcomes = []
    for done, fault in enumerate(faults):
        progress(done, len(faults))
        outcomes.append(hunt(fault))
    progress(len(faults), len(faults))
    return tuple(outcomes)


def table(outcomes: Sequence[Caught]) -> Table:
    """One line a fault, at most `WIDTH` columns wide."""
    escaped = sum(not each.caught for each in outcomes)
    title = f"{len(outcomes)} planted faults, {escaped or 'none'} escaped"
    found = Table("fault", "caught by", "part", "in family", title=title, width=WIDTH)
    for column in ("n x d", "bits", "problems", "seconds"):
        found.add_column(column, justify="right", no_wrap=True)
    for each in outcomes:
        size = (f"{each.n} x {each.d}", str(each.bits)) if each.caught else ("", "")
        check = each.check if each.caught else f"escaped {each.check}"
        found.add_row(
            each.fault, check, each.part, each.family, *size, str(each.problems), f"{each.seconds:.1f}"
        )
    return found


def as_markdown(outcomes: Sequence[Caught]) -> str:
    """The same table for a file, with the size of the problem that shows the fault."""
    escaped = sum(not each.caught for each in outcomes)
    head = ("fault", "caught by", "part", "in family", "n x d", "bits", "problems tried", "seconds")
    lines = [f"# {len(outcomes)} planted faults, {escaped or 'none'} escaped", "", WHAT, ""]
    lines += ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    for each in outcomes:
        size = [f"{each.n} x {each.d}", str(each.bits)] if each.caught else ["", ""]
        check = each.check if each.caught else f"escaped {each.check}"
        cells = [each.fault, check, each.part, each.family, *size, str(each.problems), f"{each.seconds:.1f}"]
        lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    return "\n".join([*lines, "", VOLATILE, ""])


def as_json(outcomes: Sequence[Caught]) -> dict[str, Any]:
    """For a file: the schema's name, what is volatile, the seed, the counts, and every outcome."""
    return {
        "schema": SCHEMA,
        "note": VOLATILE,
        "seed": SEED,
        "planted": len(outcomes),
        "caught": sum(each.caught for each in outcomes),
        "faults": [asdict(each) | {"caught": each.caught} for each in outcomes],
    }
