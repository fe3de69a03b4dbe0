"""A command line whose every ending has an exit code and at most a few lines, never a traceback."""

import os
import platform
import select
import sys
import tempfile
import traceback
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, NoReturn, TextIO

import typer
from typer.core import TyperGroup

from convexperc import __version__
from convexperc.cli.ending import Ended, ended_in_order
from convexperc.cli.exits import (
    BROKEN_STREAM,
    CERTIFIED,
    FAULT,
    INTERRUPTED,
    MISUSE,
    NO_MEMORY,
    NO_READER,
    SIGNALLED,
    is_misuse,
)
from convexperc.errors import escaped


class Program(TyperGroup):
    """The commands of a program; `main` runs one and ends the process with its code."""

    def main(
        self, args: Sequence[str] | None = None, prog_name: str | None = None, *_: Any, **__: Any
    ) -> NoReturn:
        """Run the command that the arguments name, by default those of the process.

        Typer's own `main` would turn a broken pipe and an end of file into 1, which has a meaning here.
        """
        with _surroundings():
            try:
                with ended_in_order():
                    code = self._run(prog_name or _called(), list(sys.argv[1:] if args is None else args))
                    if sys.stdout is not None:
                        sys.stdout.flush()
            except BaseException as error:
                code = _told(error)
        _settle(sys.stdout, sys.stderr)
        sys.exit(code)

    def _run(self, name: str, arguments: list[str]) -> int:
        try:
            with self.make_context(name, arguments) as context:
                self.invoke(context)
        except typer.Exit as end:
            return int(end.exit_code)
        return CERTIFIED


@contextmanager
def _surroundings() -> Iterator[None]:
    """What a command finds: streams that can print all names, no backend, and warnings in one line."""
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")
    backend, shown = os.environ.pop("MPLBACKEND", None), warnings.showwarning
    warnings.showwarning = _warn
    try:
        yield
    finally:
        warnings.showwarning = shown
        if backend is not None:
            os.environ["MPLBACKEND"] = backend


def _warn(message: Warning | str, category: type[Warning], *_: Any, **__: Any) -> None:
    """Print a warning; that of another library with its kind."""
    ours = category.__module__.partition(".")[0] == "convexperc"
    typer.echo(
        escaped(f"warning: {message}" if ours else f"warning: {category.__name__}: {message}"), err=True
    )


def _called() -> str:
    place = Path(sys.argv[0])
    return f"python -m {place.parent.name}" if place.name == "__main__.py" else place.name


def _told(error: BaseException) -> int:
    """Say how a command ended, and return its exit code."""
    if isinstance(error, Ended):
        code, lines = SIGNALLED + error.number, ["terminated"]
    elif isinstance(error, KeyboardInterrupt):
        code, lines = INTERRUPTED, ["interrupted"]
    elif isinstance(error, MemoryError):
        code, lines = NO_MEMORY, [f"error: out of memory. {error}"]
    elif is_misuse(error):
        code, lines = MISUSE, [f"error: {error}"]
    elif hasattr(error, "format_message"):
        code, lines = MISUSE, _usage(error)
    elif _is_end_of_reader(error):
        code, lines = NO_READER, []
    elif isinstance(error, OSError) and error.errno is not None:
        code, lines = BROKEN_STREAM, [f"error: reading or writing failed: {error}"]
    else:
        code, lines = FAULT, _fault(error)
    with suppress(OSError):
        for line in lines:
            typer.echo(escaped(line.rstrip()), err=True)
    return code


def _usage(error: Any) -> list[str]:
    """Say what is wrong with the arguments; where help was shown instead, nothing."""
    message, context = error.format_message(), getattr(error, "ctx", None)
    lines = [f"error: {message}"] if message else []
    if lines and context is not None and not isinstance(error, typer.BadParameter):
        lines.append(f"Try '{context.command_path} --help' for help.")
    return lines


def _fault(error: BaseException) -> list[str]:
    """Write the traceback to a file of its own, or give it where that cannot be."""
    told = f"internal error: {type(error).__name__}: {error}"
    trace = "".join(traceback.format_exception(error))
    versions = f"convexperc {__version__}, Python {platform.python_version()}, {platform.platform()}"
    try:
        number, place = tempfile.mkstemp(prefix="convexperc-fault-", suffix=".txt")
        with os.fdopen(number, "w", encoding="utf-8", errors="backslashreplace") as stream:
            stream.write(f"{sys.argv}\n{versions}\n\n{trace}")
    except OSError:
        return [
            told,
            "This is a fault of the program. Please report it with these lines:",
            versions,
            *trace.splitlines(),
        ]
    return [
        told,
        f"This is a fault of the program. Please report it with {place}, which says where it happened.",
    ]


def _is_end_of_reader(error: BaseException) -> bool:
    """Return whether what read the output of the process has gone; other pipes may break as well."""
    if isinstance(error, SystemExit):  # Rich has closed the stream, and ends the process with 1
        return isinstance(error.__context__, BrokenPipeError)
    if not isinstance(error, BrokenPipeError) or not hasattr(select, "poll"):
        return isinstance(error, BrokenPipeError)
    streams = select.poll()
    for number in (1, 2):
        streams.register(number, 0)
    return any(event & select.POLLERR for _, event in streams.poll(0))


def _settle(*streams: TextIO | None) -> None:
    """Flush the streams; drop what cannot be written, or Python would end with a code of its own."""
    for stream in streams:
        if stream is None:
            continue
        try:
            stream.flush()
        except (OSError, ValueError):
            with suppress(OSError, ValueError):
                os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
