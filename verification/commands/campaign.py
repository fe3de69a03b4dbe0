"""The command that solves many seeded problems; no mathematics."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from convexperc.files import write_json
from verification.commands.console import console, say
from verification.commands.misuse import FAILED, OPEN, check_places, misuse
from verification.commands.progress import progress

if TYPE_CHECKING:
    from verification.journal import Journal
    from verification.search.campaign import Campaign
    from verification.search.tallies import Report


CAMPAIGN_HELP = (
    "Solve, certify and referee seeded problems.\n\n"
    "With --json a campaign that is broken off goes on where it was when it is started again, or by "
    "--resume. Exit code 0: every problem is certified or enclosed and no proof is false; 1: not so, or "
    "problems were lost with a worker that was killed; 2: misuse; 3: broken off."
)


def campaign(  # noqa: PLR0913, PLR0917 - one for each option
    random: Annotated[int, typer.Option(min=0, help="Random problems.")] = 2000,
    degenerate: Annotated[
        int, typer.Option(min=0, help="Degenerate problems, scales 1e-8..1e8 among them.")
    ] = 2000,
    extreme: Annotated[int, typer.Option(min=0, help="Problems with scales 1e-150..1e150.")] = 0,
    seed: Annotated[int, typer.Option(min=0, help="Seed of every family's stream.")] = 0,
    solver: Annotated[Literal["newton", "conic"], typer.Option(help="What answers.")] = "newton",
    escalate: Annotated[
        bool, typer.Option(help="Use ball arithmetic where the solver's answer is not certified.")
    ] = True,
    referee: Annotated[
        int, typer.Option(min=0, help="Exact referee on every k-th problem of a family; 0: none.")
    ] = 20,
    clarabel: Annotated[
        int,
        typer.Option(min=0, help="CVXPY + Clarabel, called directly, on every k-th of a family; 0: none."),
    ] = 0,
    json_file: Annotated[
        Path | None, typer.Option("--json", help="Write everything to this file.", dir_okay=False)
    ] = None,
    resume: Annotated[
        Path | None,
        typer.Option(help="Continue the campaign of this --json file, with its settings.", dir_okay=False),
    ] = None,
    jobs: Annotated[
        int, typer.Option(min=1, help="Worker processes; more than one needs the extra `verify`.")
    ] = 1,
) -> None:
    """Run the command ``campaign``."""
    from verification.provenance import stamp  # noqa: PLC0415
    from verification.search.campaign import Campaign  # noqa: PLC0415

    settings = Campaign(random, degenerate, extreme, seed, solver, escalate, referee, clarabel)
    made = stamp("campaign")  # before this command changes a file
    if resume is not None:
        settings = _stored(resume, made)
    if not settings.total:
        raise typer.BadParameter("at least one problem is needed: a run that checks nothing proves nothing")
    place, journal = json_file or resume, None
    begun = None if resume is None else _place(resume)
    check_places({"the journal of --resume": begun}, json=place)
    if place is not None:
        with misuse("--json"):
            journal = _journal(resume or place, settings.head(made), reopen=resume is not None)
    report = _run(settings, jobs, journal)
    if place is not None:
        with misuse("--json"):
            write_json(place, settings.as_json(report, made))
    if journal is not None and not report.lost:
        journal.finish()
    _print(report)
    raise typer.Exit(0 if report.clean else FAILED)


def _place(file: Path) -> Path:
    """Where the journal of a --json file is."""
    return file.parent / ".journal" / f"{file.name}.jsonl"


def _journal(file: Path, head: dict[str, Any], *, reopen: bool) -> "Journal":
    from verification.journal import Journal  # noqa: PLC0415 - keeps --help quick

    return Journal(_place(file), head, reopen=reopen)


def _stored(file: Path, made: dict[str, Any]) -> "Campaign":
    """The settings of a campaign that was begun with these versions and this code."""
    from verification.journal import read_head  # noqa: PLC0415 - keeps --help quick
    from verification.search.campaign import Campaign  # noqa: PLC0415

    with misuse("--resume"):
        head = read_head(_place(file))
    try:
        settings = Campaign(**head["settings"])
    except (KeyError, TypeError):
        raise typer.BadParameter(f"{_place(file)} is no campaign's", param_hint="--resume") from None
    if head != settings.head(made):
        message = f"the campaign of {file} was begun with other versions or other code; start it anew"
        raise typer.BadParameter(message, param_hint="--resume")
    return settings


def _run(settings: "Campaign", jobs: int, journal: "Journal | None") -> "Report":
    """Run with a progress line; Ctrl-C ends the command, and the journal keeps what was found."""
    from verification.search.certify import run  # noqa: PLC0415 - keeps --help quick

    done = 0
    try:
        with progress() as show:

            def told(report: "Report") -> None:
                nonlocal done
                done = report.total
                bad = f"{len(report.failures)} failed, {len(report.contradictions)} contradicted"
                show("campaign", done, settings.total, bad)

            return run(settings, jobs=jobs, journal=journal, progress=told)
    except KeyboardInterrupt:
        kept = "; the same command goes on from there" if journal is not None else ""
        typer.echo(f"interrupted after {done} of {settings.total} problems{kept}", err=True)
        raise typer.Exit(OPEN) from None


def _print(report: "Report") -> None:
    from verification.search.screen import clarabel_table, details, families_table  # noqa: PLC0415

    screen = console()
    screen.print(families_table(report))
    if report.clarabel:
        screen.print(clarabel_table(report))
    for line in details(report):
        say(line)
