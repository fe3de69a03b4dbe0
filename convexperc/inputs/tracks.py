"""The frames of one robot near the present moment."""

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass

from convexperc.errors import InputError, SourceError
from convexperc.inputs.frames import Frame, Silence, Source


@dataclass(frozen=True)
class Counts:
    """What became of the frames of one robot so far; final when the moments have ended.

    Attributes
    ----------
    frames : int
        Read from the source; those of a camera as far as it delivered them.
    used : int
        Chosen for at least one moment.
    unused : int
        In none, though sound as far as is known: another frame of the robot was nearer.
    waiting : int
        In none so far, and read for moments that are still to come; none at the end.
    unreadable : int
        Without a picture when one was wanted. Only frames that are wanted are decoded.
    disordered : int
        With a time that is out of order, or that came after its moment: left out.
    dropped : int
        Of a camera or stream: replaced by a newer one before it was asked for.
    ended : str
        Why the source broke off; empty if it did not.
    """

    frames: int = 0
    used: int = 0
    unused: int = 0
    unreadable: int = 0
    disordered: int = 0
    dropped: int = 0
    waiting: int = 0
    ended: str = ""


class Kept:
    """A frame in a track, whether it can be read, and whether a moment used it."""

    __slots__ = ("broken", "frame", "used")

    def __init__(self, frame: Frame) -> None:
        self.frame, self.used, self.broken = frame, False, False

    @property
    def time(self) -> float:
        """Seconds."""
        return self.frame.time


class Track:
    """The frames of a recording that a present or later moment may use, in the order of their times.

    Attributes
    ----------
    floor : float
        Every frame that is still to be read has at least this time; infinite at the end.
    last : float
        Time of the latest frame that was read; minus infinity if there is none.
    failure : InputError or None
        Why the source broke off.
    strict : bool
        Raise where it breaks off or a frame is out of order.
    over : bool
        Whether the moments have ended, so that what is in none has no use any more.
    """

    def __init__(self, robot: str, source: Source, *, strict: bool = False) -> None:
        self.robot, self.strict = robot, strict
        self.floor, self.last = float("-inf"), float("-inf")
        self.over = False
        self.failure: InputError | None = None
        self.frames = self.disordered = 0
        self._events: Iterator[Frame | Silence] = source.events()
        self._ahead: deque[Frame | Silence | InputError | None] = deque()
        self._window: deque[Kept] = deque()
        self._passed: float | None = None  # time of the latest frame that left the window
        self._gone = [0, 0, 0]  # used, unused and unreadable frames that left it

    @property
    def ended(self) -> bool:
        """Whether there is nothing more to read."""
        return self.floor == float("inf")

    def read(self) -> Kept | None:
        """Read one event; return its frame, if it is one that can be used.

        Of two frames out of order, the later one is left out if it is before the frames that preceded both:
        a clock was set back. Otherwise it is the earlier one: its time was too far ahead.
        """
        event = self._ahead.popleft() if self._ahead else self._next()
        if isinstance(event, InputError):
            if self.strict:
                raise event
            self.failure, event = event, None
        if event is None:
            self.floor = float("inf")
            return None
        if isinstance(event, Silence):
            self.floor = max(self.floor, event.time)
            return None
        self.frames += 1
        if event.time < self.floor:
            self._leave_out(event.time, self.floor)
            return None
        following = self._next()
        self._ahead.append(following)
        if isinstance(following, Frame) and self.floor <= following.time < event.time:
            self._leave_out(following.time, event.time)
            return None
        self.floor = self.last = event.time
        kept = Kept(event)
        self._window.append(kept)
        return kept

    def _next(self) -> Frame | Silence | InputError | None:
        try:
            return next(self._events, None)
        except InputError as error:
            return error

    def _leave_out(self, time: float, before: float) -> None:
        self.disordered += 1
        if self.strict:
            must = f"must not be before that of an earlier one, {before:.6f} s"
            raise SourceError(f"robot {self.robot!r}: time of a frame", value=time, must=must)

    def near(self, time: float, slop: float) -> list[Kept]:
        """Return the frames at most `slop` away, the nearest first, of equally near ones the earlier."""
        found = [kept for kept in self._window if abs(kept.time - time) <= slop]
        return sorted(found, key=lambda kept: (abs(kept.time - time), kept.time))

    def forget(self, time: float, slop: float) -> None:
        """Drop the frames that no moment from `time` on can use."""
        while self._window and time - self._window[0].time > slop:
            kept = self._window.popleft()
            self._passed = kept.time
            self._gone[_fate(kept)] += 1

    def after(self, time: float) -> float:
        """Return the least time above `time` that a frame may have."""
        return next((kept.time for kept in self._window if kept.time > time), self.floor)

    def absence(self, time: float, slop: float) -> str:
        """Say why no frame is near."""
        if self.failure is not None and time >= self.last:
            return str(self.failure)
        times = [kept.time for kept in self._window]
        if self._passed is not None:
            times.append(self._passed)
        if not times:
            return "it has no picture" if self.ended else "no picture of it has been read"
        nearest = min(times, key=lambda each: abs(each - time))
        side = "later" if nearest > time else "earlier"
        end = ", its last one" if self.ended and nearest == self.last else ""
        return f"no picture within {slop:g} s: the nearest is {abs(nearest - time):.3g} s {side}{end}"

    @property
    def counts(self) -> Counts:
        """What became of the frames so far; those in the window count by what they have been used for."""
        used, unused, unreadable = self._gone
        fates = [_fate(kept) for kept in self._window]
        ended, left = "" if self.failure is None else str(self.failure), fates.count(_UNUSED)
        return Counts(
            self.frames,
            used + fates.count(_USED),
            unused + (left if self.over else 0),
            unreadable + fates.count(_UNREADABLE),
            self.disordered,
            waiting=0 if self.over else left,
            ended=ended,
        )


_USED, _UNUSED, _UNREADABLE = range(3)


def _fate(kept: Kept) -> int:
    return _UNREADABLE if kept.broken else _USED if kept.used else _UNUSED
