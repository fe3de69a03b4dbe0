"""Runs that keep a journal beside their --json file: opened, counted, broken off, written; no mathematics."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from convexperc.files import write_json
from verification.commands.misuse import OPEN, misuse
from verification.commands.progress import progress

if TYPE_CHECKING:
    from verification.journal import Journal


def journal_place(file: Path) -> Path:
    """Where the journal of a --json file is."""
    return file.parent / ".journal" / f"{file.name}.jsonl"


def open_journal(file: Path | None, head: dict[str, Any], *, reopen: bool = False) -> "Journal | None":
    """The journal of a --json file; none without a file. Head and `reopen` as `Journal` has them."""
    from verification.journal import Journal  # noqa: PLC0415 - keeps --help quick

    if file is None:
        return None
    with misuse("--json"):
        return Journal(journal_place(file), head, reopen=reopen)


@contextmanager
def counted(stage: str, total: int, journal: "Journal | None") -> Iterator[Callable[[int, str], None]]:
    """Give what shows how many of `total` problems are done; Ctrl-C ends the command, the journal stays."""
    done = 0
    try:
        with progress() as show:

            def told(count: int, note: str) -> None:
                nonlocal done
                done = count
                show(stage, done, total, note)

            yield told
    except KeyboardInterrupt:
        kept = "; the same command goes on from there" if journal is not None else ""
        typer.echo(f"interrupted after {done} of {total} problems{kept}", err=True)
        raise typer.Exit(OPEN) from None


def store(file: Path | None, content: dict[str, Any], journal: "Journal | None", *, whole: bool) -> None:
    """Write the --json file, if there is one; where nothing was lost on the way, the journal is finished."""
    if file is None or journal is None:
        return
    with misuse("--json"):
        write_json(file, content)
    if whole:
        journal.finish()
