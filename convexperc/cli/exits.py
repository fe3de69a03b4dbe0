"""Exit codes of the commands, and what the outcome of a command means."""

from collections.abc import Callable
from functools import wraps
from typing import ParamSpec

import typer

from convexperc import simulation
from convexperc.errors import ConvexpercError, InputError, MissingExtraError

CERTIFIED, NOT_CERTIFIED, MISUSE = 0, 1, 2
"""Exit codes of an outcome; 2 as the shell and Typer use it."""
FAULT, NO_MEMORY, BROKEN_STREAM = 70, 71, 74
"""EX_SOFTWARE, EX_OSERR, EX_IOERR of sysexits.h: an unexpected exception, no memory, a failed read or write.
Python's own code for them, 1, would say something of an answer.
"""
INTERRUPTED, NO_READER, SIGNALLED = 130, 141, 128
"""As the shell has it for a process that SIGINT or SIGPIPE has ended; others add 128 to their numbers."""
FAILURES = (
    "70 an internal error; 71 out of memory; 74 reading or writing failed; 130 interrupted; 141 what reads"
    " the output has ended; 143 terminated."
)
"""The codes that every command may end with, for its help."""
Arguments = ParamSpec("Arguments")


def exits(command: Callable[Arguments, bool]) -> Callable[Arguments, None]:
    """Turn a command that returns whether its result is certified into one that exits with that code."""

    @wraps(command)
    def run(*args: Arguments.args, **options: Arguments.kwargs) -> None:
        try:
            code = CERTIFIED if command(*args, **options) else NOT_CERTIFIED
        except ConvexpercError as error:
            if is_misuse(error):
                raise
            typer.echo(f"error: {error}", err=True)
            code = NOT_CERTIFIED
        raise typer.Exit(code)

    return run


def is_misuse(error: BaseException) -> bool:
    """Return whether the caller can mend it: an input, a missing extra, or a system that cannot draw."""
    return isinstance(error, (InputError, MissingExtraError)) or (
        isinstance(error, ConvexpercError) and isinstance(error, simulation.RenderingError)
    )
