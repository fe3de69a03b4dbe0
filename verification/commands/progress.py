"""How far a command has come: bars on a terminal, else a line now and then, on standard error."""

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any, Protocol

import typer

EVERY = 30.0
"""Seconds between two lines of one stage."""


class Show(Protocol):
    """Called with a stage, how much of it is done, how much there is, and what else to say."""

    def __call__(self, stage: str, done: int, total: int, note: str = "") -> None:
        """Show it."""


@contextmanager
def progress() -> Iterator[Show]:
    """A bar for each stage on a terminal, else a line for each at most every `EVERY` seconds."""
    if sys.stderr is None or not sys.stderr.isatty():
        yield Lines()
        return
    from rich.console import Console  # noqa: PLC0415 - keeps --help quick
    from rich.progress import (  # noqa: PLC0415
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeRemainingColumn,
    )

    bars: dict[str, Any] = {}
    left = TimeRemainingColumn()
    columns = TextColumn("{task.description}", markup=False), BarColumn(), MofNCompleteColumn(), left
    with Progress(
        *columns, TextColumn("{task.fields[note]}", markup=False), console=Console(stderr=True)
    ) as bar:

        def show(stage: str, done: int, total: int, note: str = "") -> None:
            if stage not in bars:
                bars[stage] = bar.add_task(stage, total=total, note=note)
            bar.update(bars[stage], completed=done, note=note)

        yield show


@dataclass
class Lines:
    """Prints a stage when it begins, when it is done, and in between at most every `EVERY` seconds.

    The rate is that since the first call: what was done before is no part of it.
    """

    _begun: dict[str, tuple[float, int]] = field(default_factory=dict)
    _last: dict[str, float] = field(default_factory=dict)

    def __call__(self, stage: str, done: int, total: int, note: str = "") -> None:
        """Print it if it is time."""
        now = time.monotonic()
        start, before = self._begun.setdefault(stage, (now, done))
        if stage in self._last and now - self._last[stage] < EVERY and done < total:
            return
        self._last[stage] = now
        rate = (done - before) / max(now - start, 1e-9)
        left = f"{(total - done) / rate / 60.0:.1f} min left" if rate else "time left unknown"
        line = f"{stage}: {done} of {total}, {rate:.1f}/s, {left}"
        typer.echo(f"{line}; {note}" if note else line, err=True)
