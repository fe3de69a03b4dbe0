"""The command that solves many seeded problems; no mathematics."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from verification.commands.console import console, say
from verification.commands.misuse import FAILED, check_places, misuse
from verification.commands.resumable import counted, journal_place, open_journal, store

if TYPE_CHECKING:
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
    from verification.provenance import stamp  # noqa: PLC0415 - keeps --help quick
    from verification.search.campaign import Campaign  # noqa: PLC0415
    from verification.search.certify import run  # noqa: PLC0415

    settings = Campaign(random, degenerate, extreme, seed, solver, escalate, referee, clarabel)
    made = stamp("campaign")  # before this command changes a file
    if resume is not None:
        settings = _stored(resume, made)
    if not settings.total:
        raise typer.BadParameter("at least one problem is needed: a run that checks nothing proves nothing")
    place = json_file or resume
    begun = None if resume is None else journal_place(resume)
    check_places({"the journal of --resume": begun}, json=place)
    journal = open_journal(resume or place, settings.head(made), reopen=resume is not None)
    with counted("campaign", settings.total, journal) as told:
        report = run(settings, jobs=jobs, journal=journal, progress=lambda each: told(each.total, _bad(each)))
    store(place, settings.as_json(report, made), journal, whole=not report.lost)
    _print(report)
    raise typer.Exit(0 if report.clean else FAILED)


def _stored(file: Path, made: dict[str, Any]) -> "Campaign":
    """The settings of a campaign that was begun with these versions and this code."""
    from verification.journal import read_head  # noqa: PLC0415 - keeps --help quick
    from verification.search.campaign import Campaign  # noqa: PLC0415

    with misuse("--resume"):
        head = read_head(journal_place(file))
    try:
        settings = Campaign(**head["settings"])
    except (KeyError, TypeError):
        raise typer.BadParameter(f"{journal_place(file)} is no campaign's", param_hint="--resume") from None
    if head != settings.head(made):
        message = f"the campaign of {file} was begun with other versions or other code; start it anew"
        raise typer.BadParameter(message, param_hint="--resume")
    return settings


def _bad(report: "Report") -> str:
    return f"{len(report.failures)} failed, {len(report.contradictions)} contradicted"


def _print(report: "Report") -> None:
    from verification.search.screen import clarabel_table, details, families_table  # noqa: PLC0415

    screen = console()
    screen.print(families_table(report))
    if report.clarabel:
        screen.print(clarabel_table(report))
    for line in details(report):
        say(line)
