"""The stored record of the experiments in a run: read, given to the evidence, and its figures printed."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rich.table import Table

if TYPE_CHECKING:
    from verification.experiments.record.reading import Experiments
    from verification.ledger.evidence import Evidence
    from verification.ledger.surveys import Survey


def read_stored(file: Path | None) -> "Experiments | None":
    """The record in a file, else the one that comes with the verifier; None if it comes without.

    Raises
    ------
    FileFormatError
        See `verification.experiments.record.reading.read_experiments`.
    """
    from verification.experiments.record.reading import packaged, read_experiments  # noqa: PLC0415 - keeps --help quick

    return packaged() if file is None else read_experiments(file)


def attach(evidence: "Evidence", stored: "Experiments | None", file: Path | None) -> None:
    """Give the evidence what the record says of the claims that the run is about, and name its file."""
    from verification.ledger.claims import CLAIMS, PARTS  # noqa: PLC0415 - keeps --help quick
    from verification.ledger.verdicts import is_selected  # noqa: PLC0415

    wanted = {claim.id for claim in CLAIMS.values() if claim.surveyed and is_selected(evidence, claim.id)}
    if stored is None or not wanted:
        return
    evidence.surveys = [each for each in stored.surveys if PARTS[each.part].claim in wanted]
    pictures = {each["name"]: each["digest"] for each in stored.content["sets"]}
    told = {"record": stored.digest, **pictures, "made by": stored.command}
    named = "" if file is None else f" --experiments {file.name}"
    command = f"{evidence.settings['command']}{named}"
    evidence.settings = evidence.settings | {"command": command, "experiments": told}


def figures(evidence: "Evidence") -> Iterator[Table]:
    """What the record says of each part of a claim about the experiments that was selected by name."""
    if not evidence.settings.get("claims") or not evidence.surveys:
        return
    told = evidence.settings["experiments"]
    caption = f"read from record {told['record'][:12]}, not found by this run; `{told['made by']}`"
    yield survey_table(evidence.surveys, caption)


def survey_table(surveys: "Sequence[Survey]", caption: str) -> Table:
    """What configurations say of each part of a claim, and the comparison that decides the default one."""
    from verification.ledger.verdicts import survey_judgement, verdict_in_words  # noqa: PLC0415 - keeps --help quick

    heads = ("part", "pictures", "verdict", "configurations", "default configuration")
    table = Table(*heads, "statistic [lower, upper]", "scenes", title="The experiments", caption=caption)
    for each in surveys:
        default = each.default
        row = (each.tally.told, f"{default.outcome}: {default.name}", default.figures, f"{default.units}")
        table.add_row(each.part, each.pictures, verdict_in_words(survey_judgement(each)), *row)
    return table
