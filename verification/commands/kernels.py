"""The command about losses and their weights: tables, and the campaign about the judges; no mathematics."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.table import Table as Grid

from convexperc.files import write_json
from verification.commands.console import console, say
from verification.commands.misuse import FAILED, OPEN, check_places, misuse
from verification.commands.progress import progress
from verification.commands.resumable import counted, open_journal, store

if TYPE_CHECKING:
    from verification.reweighted.answers import Answer
    from verification.reweighted.terms.campaign import Settings
    from verification.reweighted.terms.kernels import Judged

KERNELS_HELP = (
    "Judge robust losses and their weights: known formulas, and those of installed libraries.\n\n"
    "With --campaign the judges themselves are tried, on random pairs and on planted faults; with --json one "
    "that is broken off goes on where it was when it is started again. Exit code 0: all was judged, "
    "whatever the answers, or no sound pair of the campaign was accused; 1: one was, a planted fault "
    "was not named, an exception was raised, or pairs were lost with a worker; 2: misuse; "
    "3: the campaign was broken off, or a kernel could not be judged."
)
QUESTIONS = ("tangent", "majorises", "sign", "at zero", "units")
SCHEMA = "convexperc/kernel-table/1"


def kernels(
    library: Annotated[
        list[str] | None,
        typer.Option(help="formulas, scipy, statsmodels or gtsam; repeatable. Default: all."),
    ] = None,
    json_file: Annotated[
        Path | None, typer.Option("--json", help="Write everything to this file.", dir_okay=False)
    ] = None,
    campaign: Annotated[
        int, typer.Option(min=0, help="How many random sound pairs; 0: the tables instead.")
    ] = 0,
    seed: Annotated[int, typer.Option(min=0, help="Of the pairs of the campaign.")] = 0,
    mutants: Annotated[int, typer.Option(min=0, help="A planted fault at every k-th number; 0: none.")] = 20,
    exact: Annotated[
        int, typer.Option(min=0, help="Formulas as well at every k-th number, a second each; 0: none.")
    ] = 0,
    jobs: Annotated[
        int, typer.Option(min=1, help="Worker processes; more than one needs the extra `verify`.")
    ] = 1,
) -> None:
    """Run the command ``kernels``."""
    from verification.provenance import stamp  # noqa: PLC0415 - keeps --help quick
    from verification.reweighted.terms.campaign import Settings  # noqa: PLC0415
    from verification.reweighted.terms.kernels import LIBRARIES, judged  # noqa: PLC0415

    check_places(json=json_file)
    chosen = tuple(library or LIBRARIES)
    for name in chosen:
        if name not in LIBRARIES:
            raise typer.BadParameter(f"must be one of {', '.join(LIBRARIES)}", param_hint="--library")
    if campaign and library:
        raise typer.BadParameter("is about tables, and a campaign has none", param_hint="--library")
    made = stamp("kernels")
    if campaign:
        raise typer.Exit(_try(Settings(campaign, seed, mutants, exact), jobs, json_file, made))
    with progress() as show:
        rows = list(judged(chosen, show))
    console().print(_table(rows))
    _say(rows)
    if json_file is not None:
        with misuse("--json"):
            write_json(
                json_file, {"schema": SCHEMA, "made": made, "kernels": [row.as_json() for row in rows]}
            )
    raise typer.Exit(OPEN if any(row.name and row.answers is None for row in rows) else 0)


def _table(rows: "list[Judged]") -> Grid:
    grid = Grid("library", "kernel", *QUESTIONS)
    for row in rows:
        if row.answers is not None:
            grid.add_row(row.library, row.name, *(_cell(row.answers[each]) for each in QUESTIONS))
    return grid


def _cell(answer: "Answer") -> str:
    """The word; a measurement is called one."""
    from verification.reweighted.terms.measured import ROOTED  # noqa: PLC0415 - keeps --help quick

    return f"{answer.word.value} (measured)" if answer.basis.startswith(ROOTED) else answer.word.value


def _say(rows: "list[Judged]") -> None:
    for row in rows:
        if row.answers is None:
            say(f"{' '.join(filter(None, (row.library, row.name)))}: left out, {row.reason}")
            continue
        for fault in row.answers.faults:
            numbers = ", ".join(f"{name} {value}" for name, value in fault.instance.items())
            say(f"{row.library} {row.name}: {fault.statement} ({numbers})")


def _try(settings: "Settings", jobs: int, json_file: Path | None, made: dict[str, Any]) -> int:
    """Run the campaign, write and print what it found; the exit code."""
    from verification.reweighted.terms.campaign import run  # noqa: PLC0415 - keeps --help quick

    journal = open_journal(json_file, settings.head(made))
    with counted("kernels", settings.pairs, journal) as told:
        outcome = run(
            settings, jobs=jobs, journal=journal,
            progress=lambda found: told(found.measured.sound, f"{len(found.found)} found"),
        )  # fmt: skip
    store(json_file, settings.as_json(outcome, made), journal, whole=not outcome.lost)
    for way, tally in (("measured", outcome.measured), ("by formulas", outcome.exact)):
        say(
            f"{way}: {tally.sound} sound pairs, {tally.accused} accused; {tally.mutants} planted faults, "
            f"{tally.caught} caught, {tally.named} named; {tally.crashed} crashed, {tally.seconds:.0f} s"
        )
    for question, count in outcome.undecided.items():
        say(f"undecided, {question}: {count}")
    for each in outcome.found:
        say(f"{each['pair']} ({each['way']}): {each['wrong']}")
    for name, ending in outcome.lost.items():
        say(f"{name}: lost, {ending}")
    return 0 if outcome.clean and outcome.named else FAILED
