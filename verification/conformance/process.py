"""A program that runs beside this one: started, written to, read from within a time, and ended."""

import fcntl
import os
import selectors
import signal
import subprocess
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any, Self

LINGER = 0.2
"""Seconds in which a program may end by itself once its input is closed; what it still writes is read."""

TICK = 0.05
"""Seconds between two looks whether a program has ended, while what it started keeps its output open."""

PIPE = 1 << 18
"""Bytes that a pipe may hold: a long request is then written, and read, at once."""

KEPT, MOST_LEFT = 2000, 1 << 16
"""Bytes that are kept of the end of standard error, and read of what it writes after the last answer."""


@dataclass
class Process:
    """A running program and what it has written.

    Attributes
    ----------
    popen : subprocess.Popen
    out, err : bytearray
        What it wrote to standard output and was not taken yet; the end of what it wrote to standard error.
    """

    popen: "subprocess.Popen[bytes]"
    out: bytearray = field(default_factory=bytearray)
    err: bytearray = field(default_factory=bytearray)

    @classmethod
    def start(cls, words: Sequence[str], folder: Path | None) -> Self:
        """Start a program in a folder and in a process group of its own; no shell runs it.

        Raises
        ------
        OSError
            There is no such program, or it cannot be started.
        """
        pipe = subprocess.PIPE
        popen = subprocess.Popen(
            words, stdin=pipe, stdout=pipe, stderr=pipe, cwd=folder, start_new_session=True
        )
        for stream in (popen.stdin, popen.stdout, popen.stderr):
            if stream is not None:
                os.set_blocking(stream.fileno(), False)
                _widen(stream)
        return cls(popen)

    @property
    def last_words(self) -> str:
        """The end of its standard error; bytes that are no UTF-8 are replaced."""
        return bytes(self.err).decode("utf-8", "replace").strip()

    @contextmanager
    def listening(self, pending: bytes = b"", *, last: bool = False) -> Iterator["Listening"]:
        """Listen to it, with what it is still to read; after the last of that its input is closed."""
        found = Listening(self, pending, last)
        try:
            yield found
        finally:
            found.selector.close()

    def waiting(self) -> list[bytes]:
        """The lines that it has written already and that are not blank, taken."""
        with self.listening() as ready:
            while len(self.out) < MOST_LEFT and ready(0.0):
                pass
        whole, end, rest = bytes(self.out).rpartition(b"\n")
        self.out[:] = rest
        return [line for line in whole.split(b"\n") if line.strip()] if end else []

    def finish(self) -> list[bytes]:
        """Close its input, read what it writes within `LINGER`, and end it; the lines that are not blank."""
        _close(self.popen.stdin)
        end = time.monotonic() + LINGER
        with self.listening() as ready:
            while len(self.out) < MOST_LEFT and ready(end):
                pass
        self.kill()
        return [line for line in bytes(self.out).split(b"\n") if line.strip()]

    def kill(self) -> None:
        """End it and what it has started."""
        try:
            os.killpg(self.popen.pid, signal.SIGKILL)
        except (ProcessLookupError, PermissionError):
            self.popen.kill()
        self.popen.wait()
        for stream in (self.popen.stdin, self.popen.stdout, self.popen.stderr):
            _close(stream)


class Listening:
    """Writes what is pending and reads what comes, whichever is possible, until a deadline.

    Parameters
    ----------
    process : Process
    pending : bytes
        Still to be written.
    last : bool
        Whether its input is closed after that.

    Attributes
    ----------
    closed : bool
        Whether the program has closed its output.
    """

    def __init__(self, process: Process, pending: bytes, last: bool) -> None:
        self.process, self.pending, self.closed = process, memoryview(pending), False
        self.last = last
        self.start = time.monotonic()
        self.selector = selectors.DefaultSelector()
        popen = process.popen
        for stream, found in ((popen.stdout, process.out), (popen.stderr, process.err)):
            if stream is not None:
                self.selector.register(stream, selectors.EVENT_READ, found)
        if pending and popen.stdin is not None:
            self.selector.register(popen.stdin, selectors.EVENT_WRITE, None)

    def __call__(self, deadline: float) -> bool:
        """Wait for standard output; False once that is closed or the deadline has passed.

        It counts as closed, too, once the program has ended and all that it wrote is read.
        """
        while not self.closed:
            left = max(0.0, deadline - time.monotonic())
            ended = self.process.popen.poll() is not None
            read = False
            for key, _ in self.selector.select(0.0 if ended else min(left, TICK)):
                if key.data is None:
                    self._write(key.fileobj)
                else:
                    read |= self._read(key)
            if read:
                return True
            self.closed |= ended
            if not left:
                break
        return False

    @property
    def elapsed(self) -> float:
        """Seconds since it began to listen."""
        return time.monotonic() - self.start

    def line(self, seconds: float, room: int) -> bytes | None:
        """The next line, without its end.

        None where none is complete within `seconds` from the start, or the output is closed before; or where
        more than `room` bytes have come without an end of line, and are left in `Process.out`.
        """
        out = self.process.out
        while (end := out.find(b"\n")) < 0:
            if len(out) > room or not self(self.start + seconds):
                return None
        got = bytes(out[:end])
        del out[: end + 1]
        return got

    def code(self, seconds: float) -> int | None:
        """The exit code; None while it runs. With its output closed it may take `seconds` from the start."""
        if not self.closed:
            return self.process.popen.poll()
        try:
            return self.process.popen.wait(max(LINGER, seconds - self.elapsed))
        except subprocess.TimeoutExpired:
            return None

    def _write(self, stream: Any) -> None:
        try:
            self.pending = self.pending[os.write(stream.fileno(), self.pending) :]
        except BlockingIOError:
            return
        except BrokenPipeError:
            self.pending = self.pending[:0]
        if not self.pending:
            self.selector.unregister(stream)
            if self.last:
                _close(stream)

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


def _widen(stream: IO[bytes]) -> None:
    """Let a pipe hold `PIPE` bytes where the system allows it, so that it is seldom full."""
    if hasattr(fcntl, "F_SETPIPE_SZ"):
        with suppress(OSError):  # the user's pipes may hold no more in sum
            fcntl.fcntl(stream.fileno(), fcntl.F_SETPIPE_SZ, PIPE)


def _close(stream: IO[bytes] | None) -> None:
    try:
        if stream is not None:
            stream.close()
    except OSError:  # the program has ended, what was to be written is lost
        pass
