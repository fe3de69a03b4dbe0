"""Where the commands print: the terminal, or a fixed width where there is none."""

import sys

from rich.console import Console


def console() -> Console:
    """A console on standard output."""
    return Console(file=sys.stdout, width=None if sys.stdout.isatty() else 140)
