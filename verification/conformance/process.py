"""A program that runs beside this one: what it has written, listening to it until a deadline, its end."""

import os
import selectors
import signal
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import IO, Any

from verification.conformance.answers import shown

LINGER = 0.2
"""Seconds in which a program may end by itself once its input is closed; what it still writes is read."""

KEPT = 2000
"""Last characters of standard error that a fault shows."""


@dataclass
class Process:
    """A running program and what it has written."""

    popen: "subprocess.Popen[bytes]"
    out: bytearray = field(default_factory=bytearray)
    err: bytearray = field(default_factory=bytearray)
    answered: bool = False

    @property
    def last_words(self) -> str:
        """The end of its standard error, on one line."""
        text = bytes(self.err[-KEPT:]).decode("utf-8", "replace").strip()
        return shown(text[-400:]) if text else ""


class Listening:
    """Writes what is pending and reads what comes, whichever is possible, until a deadline."""

    def __init__(self, process: Process, pending: bytes) -> None:
        self.process, self.pending, self.closed = process, memoryview(pending), False
        self.start = time.monotonic()
        self.selector = selectors.DefaultSelector()
        popen = process.popen
        for stream, found in ((popen.stdout, process.out), (popen.stderr, process.err)):
            if stream is not None:
                self.selector.register(stream, selectors.EVENT_READ, found)
        if pending and popen.stdin is not None:
            self.selector.register(popen.stdin, selectors.EVENT_WRITE, None)

    def __call__(self, deadline: float) -> bool:
        """Wait for one event; False once the output is closed or the deadline has passed."""
        while not self.closed and (left := deadline - time.monotonic()) > 0.0:
            read = False
            for key, _ in self.selector.select(left):
                if key.data is None:
                    self._write(key.fileobj)
                else:
                    read |= self._read(key)
            if read:
                return True
        return False

    def _write(self, stream: Any) -> None:
        try:
            self.pending = self.pending[os.write(stream.fileno(), self.pending) :]
        except BlockingIOError:
            return
        except BrokenPipeError:
            self.pending = self.pending[:0]
        if not self.pending:
            self.selector.unregister(stream)

    def _read(self, key: selectors.SelectorKey) -> bool:
        """Read what is there; whether it was of standard output."""
        stream: Any = key.fileobj
        try:
            chunk = os.read(stream.fileno(), 1 << 16)
        except BlockingIOError:
            return False
        is_out = key.data is self.process.out
        if chunk:
            key.data.extend(chunk)
            if not is_out:
                del key.data[:-KEPT]
        else:
            self.selector.unregister(stream)
            self.closed |= is_out
        return is_out and bool(chunk)


@contextmanager
def listening(process: Process, pending: bytes) -> Iterator[Listening]:
    """Listen to a program, with what it is still to read."""
    listening = Listening(process, pending)
    try:
        yield listening
    finally:
        listening.selector.close()


def kill(popen: "subprocess.Popen[bytes]") -> None:
    """End it and what it has started."""
    try:
        os.killpg(popen.pid, signal.SIGKILL)
    except (ProcessLookupError, PermissionError):
        popen.kill()
    popen.wait()
    for stream in (popen.stdin, popen.stdout, popen.stderr):
        close(stream)


def close(stream: IO[bytes] | None) -> None:
    """Close a pipe, whether or not anybody is at its other end."""
    try:
        if stream is not None:
            stream.close()
    except OSError:  # the program has ended, what was to be written is lost
        pass
