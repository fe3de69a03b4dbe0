"""Options that several commands share, and how their files are checked and written."""

import contextlib
import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated

import typer

from convexperc.cli.exits import FAILURES
from convexperc.errors import escaped
from convexperc.files import check_apart, check_place, write_atomic

# Shown below the help of every command.
EPILOG = (
    "Exit codes: 0 solve, certify: the answer is certified; recognize: so is that of the label, whose optimum"
    " is proved to be the lowest, and a calibration, if there is one, accepts the label alone; 1 one of these"
    f" does not hold; 2 the input cannot be used; {FAILURES}"
)
Json = Annotated[Path | None, typer.Option("--json", metavar="FILE", help="Write the full record as JSON.")]
Seconds = Annotated[
    float, typer.Option(metavar="S", help="Budget in seconds for ball arithmetic and exact numbers; or inf.")
]
BUDGET = 60.0
"""`convexperc.enclosure.budget.SECONDS`, which is not loaded for ``--help``."""
MOST_NAMED = 12
"""Entries of a folder that are named in a line; more are counted."""


def check_outputs(
    outputs: dict[str, Path | None],
    inputs: dict[str, Path | None],
    depths: dict[str, int] | None = None,
) -> None:
    """Refuse outputs that cannot be written, or would replace an input or each other, before any work.

    `depths` says of folders among the inputs how many levels of their sub-folders are read, too.
    """
    check_apart(outputs, inputs=with_folders(inputs, depths or {}))
    for file in outputs.values():
        if file is not None:
            check_place(file)


def with_folders(inputs: dict[str, Path | None], depths: dict[str, int]) -> dict[str, Path | None]:
    """Return the inputs and the sub-folders that are read with them; see `check_outputs`."""
    inner = {
        f"{name}, {folder}": folder
        for name, depth in depths.items()
        for folder in _folders(inputs[name], depth)
    }
    return {**inputs, **inner}


def _folders(folder: Path | None, depth: int) -> Iterator[Path]:
    """The sub-folders down to a level; those that cannot be read are refused when they are."""
    if folder is not None and depth > 0:
        with contextlib.suppress(OSError):
            for entry in sorted(folder.iterdir()):
                if entry.is_dir():
                    yield entry
                    yield from _folders(entry, depth - 1)


def write(content: dict[Path, bytes]) -> None:
    """Write files, each at once or not at all, and say so on the error stream."""
    for path, data in content.items():
        write_atomic(path, data)
        typer.echo(f"wrote {escaped(os.fspath(path))}", err=True)


def say_left_out(folder: Path, said: Sequence[str]) -> None:
    """Say in one line what of a folder is not used, and why; of many, the first and how many more."""
    more = [f"and {len(said) - MOST_NAMED} more"] if len(said) > MOST_NAMED + 1 else []
    named = said[:MOST_NAMED] if more else said
    if said:
        typer.echo(escaped(f"left out of {os.fspath(folder)}: {', '.join([*named, *more])}"), err=True)
