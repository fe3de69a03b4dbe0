"""The command about planted faults; no mathematics."""

from pathlib import Path
from typing import Annotated

import typer

from convexperc.files import write_atomic, write_json
from verification.commands.console import console
from verification.commands.misuse import check_places, misuse
from verification.commands.progress import progress

FAULTS_HELP = (
    "Plant every known fault in the library and say which parts named it; exit code 1 if one escaped."
)


def faults(
    json_file: Annotated[
        Path | None, typer.Option("--json", help="Write the table here.", dir_okay=False)
    ] = None,
    markdown: Annotated[Path | None, typer.Option(help="Write it here as Markdown.", dir_okay=False)] = None,
    jobs: Annotated[
        int, typer.Option(min=1, help="Worker processes; the outcome does not depend on it.")
    ] = 2,
) -> None:
    """Run the command ``faults``."""
    from verification.faults.table import as_json, as_markdown, planted, table  # noqa: PLC0415 - keeps --help quick
    from verification.provenance import stamp  # noqa: PLC0415

    screen, made = console(), stamp("faults")  # before the work, during which files may change
    check_places(json=json_file, markdown=markdown)
    with progress() as show:
        outcomes = planted(lambda done, total: show("faults", done, total), jobs=jobs)
    screen.print(table(outcomes))
    if json_file is not None:
        with misuse("--json"):
            write_json(json_file, as_json(outcomes, made))
    if markdown is not None:
        with misuse("--markdown"):
            write_atomic(markdown, as_markdown(outcomes).encode())
    raise typer.Exit(0 if all(each.caught for each in outcomes) else 1)
