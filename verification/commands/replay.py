"""The command that runs one counterexample again; no mathematics."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from convexperc.files import write_atomic
from verification.commands.claims import Out
from verification.commands.console import console, say
from verification.commands.misuse import check_places, misuse

if TYPE_CHECKING:
    from verification.counterexamples.record import Record

RECORDS = "counterexamples"
"""Folder beside a report."""


REPLAY_HELP = (
    "Run one counterexample again in exact arithmetic, iteration by iteration.\n\n"
    "Exit code 0: it still fails as recorded; 1: it no longer fails, the record is stale."
)


def replay(
    name: Annotated[str, typer.Argument(metavar="ID", help="Of a record, or its file.")],
    out: Out = Path("reports"),
    plot: Annotated[
        Path | None, typer.Option(help="Also draw F by iteration: .svg or .png.", dir_okay=False)
    ] = None,
) -> None:
    """Run the command ``replay``."""
    from convexperc.report import picture_kind  # noqa: PLC0415 - keeps --help quick
    from verification.checks.catalogue import CHECKS  # noqa: PLC0415
    from verification.counterexamples.replay import replay as again  # noqa: PLC0415

    check_places({"ID": _place(name, out)}, plot=plot)
    with misuse("--plot"):
        kind = None if plot is None else picture_kind(plot)
    with misuse("ID"):
        result = again(_record(name, out), {check.name: check for check in CHECKS})
    for line in result.text():
        say(line)
    console().print(result.table())
    if plot is not None and kind is not None:
        with misuse("--plot"):
            write_atomic(plot, result.plot(kind))
    raise typer.Exit(1 if result.stale else 0)


def _record(name: str, out: Path) -> "Record":
    """The record of the catalogue, the file, or the record beside the report in `out`, of that name."""
    from verification.counterexamples.files import catalogue, load  # noqa: PLC0415 - keeps --help quick

    stored = {record.id: record for record in catalogue()}
    if name in stored:
        return stored[name]
    place = _place(name, out)
    if place is not None:
        return load(place)
    known = ", ".join(sorted(stored))
    message = f"no record {name!r} in {out / RECORDS} and no such file; the catalogue has {known}"
    raise typer.BadParameter(message, param_hint="ID")


def _place(name: str, out: Path) -> Path | None:
    """The file of that name, else that of the record beside the report in `out`; None if there is none."""
    places = Path(name), out / RECORDS / f"{name}.json"
    return next((place for place in places if place.is_file()), None)
