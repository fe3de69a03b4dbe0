"""The live view of a stream on the standard error, if that is a terminal that can be drawn on."""

import os
import sys
import time
from collections import deque
from collections.abc import Mapping, Sequence
from types import TracebackType
from typing import TYPE_CHECKING, Any

from convexperc import report

if TYPE_CHECKING:
    from rich.live import Live

PERIOD = 0.1
"""Seconds from one drawing to the next at least: more often cannot be read."""
RECENT = 30
"""Moments whose times give the rate."""


class Watch:
    """Shows one moment after the other in the same place; the last one stays.

    Parameters
    ----------
    robots : sequence of str
        In the order of their rows.
    """

    def __init__(self, robots: Sequence[str]) -> None:
        self._robots = tuple(robots)
        self._times: deque[float] = deque(maxlen=RECENT)
        self._live: Live | None = None
        self._drawn = -PERIOD
        self._last: Mapping[str, Any] | None = None
        self.shown = _can_be_drawn_on()

    def __enter__(self) -> "Watch":
        if self.shown:
            from rich.console import Console  # noqa: PLC0415 - takes as long to load as --help
            from rich.live import Live  # noqa: PLC0415

            console = Console(stderr=True, markup=False, highlight=False, emoji=False)
            self._live = Live(console=console, auto_refresh=False, redirect_stdout=False)
            self._live.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._live is not None:
            self._draw()
            self._live.stop()

    @property
    def rate(self) -> float | None:
        """Moments a second, of the last `RECENT`."""
        if len(self._times) < 2 or self._times[-1] == self._times[0]:
            return None
        return (len(self._times) - 1) / (self._times[-1] - self._times[0])

    def show(self, line: Mapping[str, Any]) -> None:
        """Show a moment, or keep it until the next one can be read."""
        now = time.monotonic()
        self._times.append(now)
        self._last = line
        if self._live is not None and now - self._drawn >= PERIOD:
            self._draw()
            self._drawn = now

    def _draw(self) -> None:
        if self._live is not None and self._last is not None:
            self._live.update(report.live_view(self._last, self._robots, self.rate), refresh=True)


def _can_be_drawn_on() -> bool:
    return (
        sys.stderr is not None and sys.stderr.isatty() and os.environ.get("TERM") not in ("dumb", "unknown")
    )
