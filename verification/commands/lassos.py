"""The command that judges certificates of lasso-family fits on many seeded problems; no mathematics."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from convexperc.files import write_json
from verification.commands.console import say
from verification.commands.misuse import FAILED, OPEN, check_places, misuse
from verification.commands.progress import progress

if TYPE_CHECKING:
    from verification.journal import Journal
    from verification.lassos.campaign import Outcome, Settings

LASSOS_HELP = (
    "Certify answers to seeded lasso-family problems, and compare some with the exact optimum.\n\n"
    "With --json a campaign that is broken off goes on where it was when it is started again. Exit code 0: "
    "no statement is false; 1: one is, an exception was raised, or problems were lost with a worker that was "
    "killed; 2: misuse; 3: broken off."
)


def lassos(
    problems: Annotated[int, typer.Option(min=1, help="How many, over all conventions.")] = 20_000,
    seed: Annotated[int, typer.Option(min=0, help="Of the stream of problems.")] = 0,
    referee: Annotated[int, typer.Option(min=0, help="Exact referee on every k-th problem; 0: none.")] = 20,
    json_file: Annotated[
        Path | None, typer.Option("--json", help="Write everything to this file.", dir_okay=False)
    ] = None,
    jobs: Annotated[
        int, typer.Option(min=1, help="Worker processes; more than one needs the extra `verify`.")
    ] = 1,
) -> None:
    """Run the command ``lassos``."""
    from verification.journal import Journal  # noqa: PLC0415 - keeps --help quick
    from verification.lassos.campaign import Settings  # noqa: PLC0415
    from verification.provenance import stamp  # noqa: PLC0415

    settings, made, journal = Settings(problems, seed, referee), stamp("lassos"), None
    check_places(json=json_file)
    if json_file is not None:
        with misuse("--json"):
            place = json_file.parent / ".journal" / f"{json_file.name}.jsonl"
            journal = Journal(place, settings.head(made))
    outcome = _run(settings, jobs, journal)
    if json_file is not None:
        with misuse("--json"):
            write_json(json_file, settings.as_json(outcome, made))
    if journal is not None and not outcome.lost:
        journal.finish()
    _print(outcome)
    raise typer.Exit(0 if outcome.clean else FAILED)


def _run(settings: "Settings", jobs: int, journal: "Journal | None") -> "Outcome":
    """Run with a progress line; Ctrl-C ends the command, and the journal keeps what was found."""
    from verification.lassos.campaign import run  # noqa: PLC0415 - keeps --help quick

    done = 0
    try:
        with progress() as show:

            def told(outcome: "Outcome") -> None:
                nonlocal done
                done = outcome.total.total
                show("lassos", done, settings.problems, f"{len(outcome.found)} wrong")

            return run(settings, jobs=jobs, journal=journal, progress=told)
    except KeyboardInterrupt:
        kept = "; the same command goes on from there" if journal is not None else ""
        typer.echo(f"interrupted after {done} of {settings.problems} problems{kept}", err=True)
        raise typer.Exit(OPEN) from None


def _print(outcome: "Outcome") -> None:
    for name, tally in [*outcome.conventions.items(), ("all", outcome.total)]:
        say(
            f"{name}: {tally.total} problems, {tally.certified} certified, {tally.bounded} bounded, "
            f"{tally.zeros} zeros, {tally.refereed} refereed ({tally.loose} loosely), {tally.wrong} wrong, "
            f"{tally.crashed} crashed, {tally.seconds:.0f} s"
        )
    for each in outcome.found:
        say(f"{each['number']} ({each['kind']}): {'; '.join(each['wrong'])}")
    for name, ending in outcome.lost.items():
        say(f"{name}: lost, {ending}")
