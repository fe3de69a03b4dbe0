"""Exit codes of the commands, and the message of an error."""

from collections.abc import Callable
from functools import wraps
from typing import ParamSpec

import typer

from convexperc.errors import ConvexpercError, InputError, MissingExtraError

CERTIFIED, NOT_CERTIFIED, MISUSE, INTERRUPTED = 0, 1, 2, 130
"""Exit codes: 2 as the shell and Typer use it, 130 = 128 + SIGINT."""
Arguments = ParamSpec("Arguments")


def exits(command: Callable[Arguments, bool]) -> Callable[Arguments, None]:
    """Turn a command that returns whether its result is certified into one that exits with that code."""

    @wraps(command)
    def run(*args: Arguments.args, **options: Arguments.kwargs) -> None:
        try:
            code = CERTIFIED if command(*args, **options) else NOT_CERTIFIED
        except ConvexpercError as error:
            typer.echo(f"error: {error}", err=True)
            code = MISUSE if isinstance(error, (InputError, MissingExtraError)) else NOT_CERTIFIED
        except KeyboardInterrupt:
            typer.echo("interrupted", err=True)
            code = INTERRUPTED
        raise typer.Exit(code)

    return run
