"""The table of planted faults: what was planted, and which parts named it where."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from typing import Any

from rich.table import Table

from verification.faults.fault import Fault
from verification.faults.hunt import SEED, Caught, hunt_all
from verification.faults.own import FAULTS

SCHEMA = "convexperc/faults/2"
WIDTH = 140
WHAT = (
    "Each fault is planted in the running code, one at a time, and its check looks at the problems of the"
    " quick profile. It is caught if every part that it makes false fails in a family where it holds without"
    " the fault; if it hides the failures of parts that are false as stated, none of them may be left."
    " Hypothesis then draws and shrinks a small problem that shows the fault, where there is one: n x d is"
    " its size, bits the length of its numbers as fractions."
)
VOLATILE = (
    "The seconds are those of one run on one machine; two runs of the same versions differ in nothing else."
)
HEAD = ("fault", "caught by", "part", "parts that name it", "families", "smallest in", "n x d", "bits")


def planted(
    progress: Callable[[int, int], None] = lambda done, total: None,
    faults: Sequence[Fault] = FAULTS,
    *,
    jobs: int = 1,
) -> tuple[Caught, ...]:
    """Plant one fault after the other and see what names it.

    Parameters
    ----------
    progress : callable
        Called with how many are done and how many there are.
    faults : sequence of Fault
    jobs : int
        Worker processes; the outcome does not depend on it.

    Returns
    -------
    tuple of Caught
        In the order of `faults`.
    """
    progress(0, len(faults))
    outcomes: dict[str, Caught] = {}
    for found in hunt_all(faults, jobs=jobs):
        outcomes |= {each.fault: each for each in found}
        progress(len(outcomes), len(faults))
    return tuple(outcomes[fault.name] for fault in faults)


def title(outcomes: Sequence[Caught]) -> str:
    """How many there were, and how many escaped."""
    return f"{len(outcomes)} planted faults, {sum(not each.caught for each in outcomes) or 'none'} escaped"


def cells(each: Caught) -> tuple[str, ...]:
    """One line of the table, as `HEAD` names it."""
    check = each.check if each.caught else f"escaped {each.check}"
    size = (f"{each.n} x {each.d}", str(each.bits)) if each.n else ("", "")
    return each.fault, check, each.part, ", ".join(each.parts), str(each.families), each.family, *size


def table(outcomes: Sequence[Caught]) -> Table:
    """One line a fault, at most `WIDTH` columns wide."""
    found = Table(title=title(outcomes), width=WIDTH)
    for name in HEAD:
        found.add_column(name, no_wrap=name in {"n x d", "bits"})
    for each in outcomes:
        found.add_row(*cells(each))
    return found


def as_markdown(outcomes: Sequence[Caught]) -> str:
    """The same table for a file, with the problems that were tried and the seconds."""
    head = (*HEAD, "problems tried", "seconds")
    lines = [f"# {title(outcomes)}", "", WHAT, "", "| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    for each in outcomes:
        row = (*cells(each), str(each.problems), f"{each.seconds:.1f}")
        lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |")
    return "\n".join([*lines, "", VOLATILE, ""])


def as_json(outcomes: Sequence[Caught], made: Mapping[str, Any]) -> dict[str, Any]:
    """For a file: the schema's name, what made it, what is volatile, the seed, the counts, every outcome."""
    return {
        "schema": SCHEMA,
        "made": dict(made),
        "note": VOLATILE,
        "seed": SEED,
        "planted": len(outcomes),
        "caught": sum(each.caught for each in outcomes),
        "faults": [asdict(each) | {"parts": list(each.parts)} for each in outcomes],
    }
