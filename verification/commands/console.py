"""Where the commands print: the terminal, or a fixed width where there is none."""

import sys

import typer
from rich.console import Console

from convexperc.errors import escaped


def console() -> Console:
    """A console on standard output; what is in brackets is no markup."""
    wide = sys.stdout is not None and sys.stdout.isatty()
    return Console(file=sys.stdout, width=None if wide else 140, markup=False, highlight=False, emoji=False)


def say(line: str) -> None:
    """Print one line, whatever names are in it; only a terminal breaks it."""
    typer.echo(escaped(line))
