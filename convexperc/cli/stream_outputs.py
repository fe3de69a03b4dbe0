"""Where the outcome of each moment goes: lines of JSON, a bag, and the live view."""

import math
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from convexperc import inputs, report
from convexperc.cli.ending import held_back
from convexperc.cli.watching import Watch
from convexperc.errors import InputError

if TYPE_CHECKING:
    from io import FileIO
    from types import TracebackType

    from convexperc.inputs import Hypothesis, ResultBag
    from convexperc.recognition import Recognition

_Bounds = tuple[str, float, float, float]
"""An object, the bounds of its optimum, and the share of it that is left unexplained at most."""


class Outputs:
    """Where the lines go: to the standard output or a file, into a bag, and to the live view."""

    def __init__(self, lines: "_LineWriter | None", bag: "ResultBag | None", watch: Watch | None) -> None:
        self._lines, self._bag, self._watch = lines, bag, watch

    def write(self, line: Mapping[str, Any], found: "Recognition | None") -> None:
        """Write the line of a moment, and what it is of, to all of them."""
        if self._lines is not None:
            self._lines.write(report.line_text(line))
        if self._bag is not None:
            bounded = [] if found is None else _bounded(line, found)
            with held_back():
                self._bag.write(line["nanoseconds"], _hypotheses(bounded), _details(line, bounded))
        if self._watch is not None:
            self._watch.show(line)


@contextmanager
def opened(robots: Sequence[str], jsonl: Path | None, results: Path | None, watch: bool) -> Iterator[Outputs]:
    """Open the outputs; the bag is whole once the block is left, and is not there if that raises.

    The lines go to the standard output if there is no file for them, but not into a terminal that shows the
    live view.
    """
    view = Watch(robots) if watch else None
    with ExitStack() as stack:
        bag = None if results is None else stack.enter_context(inputs.ResultBag(results))
        if view is not None:
            stack.enter_context(view)
        hidden = view is not None and view.shown and sys.stdout is not None and sys.stdout.isatty()
        lines = None if hidden and jsonl is None else stack.enter_context(_LineWriter(jsonl))
        yield Outputs(lines, bag, view)


class _LineWriter:
    """Lines on the standard output, or in a file that is begun with the first of them; each is flushed."""

    def __init__(self, file: Path | None) -> None:
        self._file = file
        self._stream: FileIO | None = None

    def __enter__(self) -> "_LineWriter":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: "TracebackType | None"
    ) -> None:
        if self._stream is not None:
            self._stream.close()

    def write(self, text: str) -> None:
        if self._file is None:
            typer.echo(text)
            return
        try:
            if self._stream is None:
                self._stream = self._file.open("wb", buffering=0)
            _append(self._stream, f"{text}\n".encode("ascii"))
        except OSError as problem:
            must = "must be a file that can be written"
            remedy = "Choose another place."
            raise InputError(
                f"output {self._file}", value=problem.strerror, must=must, remedy=remedy
            ) from None


def _append(stream: "FileIO", line: bytes) -> None:
    """Write a whole line, or none of it: what of one was written as the disk became full is taken away."""
    begin, written = stream.tell(), 0
    try:
        while written < len(line):
            written += stream.write(line[written:])
    finally:
        if stream.tell() < begin + len(line):
            stream.truncate(begin)


def _hypotheses(bounded: Sequence[_Bounds]) -> "list[Hypothesis]":
    """Each object whose optimum is bounded."""
    return [inputs.Hypothesis(*each) for each in bounded if _usable(each)]


def _bounded(line: Mapping[str, Any], found: "Recognition") -> list[_Bounds]:
    """Each object that the calibration accepts, or without one each candidate, by its best template."""
    judged, (_, most) = line["acceptance"], found.unexplained
    published = line["candidates"] if judged is None else judged["accepted"]
    best = [each for each in found.best_templates if each.object in published]
    return [(each.object, *each.interval, float(most[each.index])) for each in best]


def _usable(bounds: _Bounds) -> bool:
    return all(map(math.isfinite, bounds[1:]))


def _details(line: Mapping[str, Any], bounded: Sequence[_Bounds]) -> dict[str, Any]:
    names = ("verdict", "label", "certified", "acceptance", "candidates", "margin", "views", "missing")
    unbounded = [each[0] for each in bounded if not _usable(each)]
    return {name: line[name] for name in names} | {"unbounded": unbounded}
