"""Requests of the system to end, which are followed in the same order as Ctrl-C."""

import os
import signal
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from types import FrameType

ENDINGS = tuple(getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name))
"""What `kill`, `timeout`, systemd and Docker send, and a terminal that is closed."""


class Ended(KeyboardInterrupt):
    """Raised where one of `ENDINGS` has come.

    Attributes
    ----------
    number : int
        Of the signal.
    """

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.number = number


@contextmanager
def ended_in_order() -> Iterator[None]:
    """Raise `Ended` in the block where this process is asked to end; a signal that is ignored stays so."""
    own = os.getpid()

    def end(number: int, _: FrameType | None) -> None:
        if os.getpid() == own:
            raise Ended(number)
        signal.signal(number, signal.SIG_DFL)  # a process that was forked: what ends it waits for that
        os.kill(os.getpid(), number)

    with _handled([number for number in ENDINGS if signal.getsignal(number) == signal.SIG_DFL], end):
        yield


@contextmanager
def held_back() -> Iterator[None]:
    """Let the block end before Ctrl-C or one of `ENDINGS` is followed; for what must not be left halfway."""
    came = list[tuple[int, FrameType | None]]()
    numbers = [each for each in (signal.SIGINT, *ENDINGS) if callable(signal.getsignal(each))]
    followed = {number: signal.getsignal(number) for number in numbers}
    try:
        with _handled(numbers, lambda number, frame: came.append((number, frame))):
            yield
    finally:
        for number, frame in came[:1]:
            handler = followed[number]
            assert callable(handler)
            handler(number, frame)


@contextmanager
def _handled(numbers: Iterable[int], handler: Callable[[int, FrameType | None], None]) -> Iterator[None]:
    """Have a handler in the block, if this is the main thread."""
    mine = numbers if threading.current_thread() is threading.main_thread() else ()
    before = {number: signal.signal(number, handler) for number in mine}
    try:
        yield
    finally:
        for number, each in before.items():
            signal.signal(number, each)
