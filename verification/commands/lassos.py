"""The command that judges certificates of lasso-family fits on many seeded problems; no mathematics."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from verification.commands.console import say
from verification.commands.misuse import FAILED, check_places
from verification.commands.resumable import counted, open_journal, store

if TYPE_CHECKING:
    from verification.lassos.campaign import Outcome

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
    from verification.lassos.campaign import Settings, run  # noqa: PLC0415 - keeps --help quick
    from verification.provenance import stamp  # noqa: PLC0415

    settings, made = Settings(problems, seed, referee), stamp("lassos")
    check_places(json=json_file)
    journal = open_journal(json_file, settings.head(made))
    with counted("lassos", problems, journal) as told:
        outcome = run(
            settings, jobs=jobs, journal=journal,
            progress=lambda found: told(found.total.total, f"{len(found.found)} wrong"),
        )  # fmt: skip
    store(json_file, settings.as_json(outcome, made), journal, whole=not outcome.lost)
    _print(outcome)
    raise typer.Exit(0 if outcome.clean else FAILED)


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
