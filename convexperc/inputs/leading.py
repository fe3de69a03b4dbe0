"""Which times of recorded frames are moments: those of the robots that lead, or a grid."""

import heapq
import math
from collections import deque
from collections.abc import Callable, Iterator, Sequence

from convexperc.inputs.tracks import Kept, Track


def led(tracks: Sequence[Track], slop: float) -> Iterator[float]:
    """Yield the times of the frames that lead, in order, once all frames within the slop are in the tracks.

    Every frame of the first track leads; one of a later track leads if no leading frame of a track before it
    is at most `slop` away. Of frames of one track with the same time, the first leads. Between two of these
    times, the tracks may forget what lies more than `slop` before.
    """
    leads = _Leads(tracks, slop)
    while True:
        while leads.settled():
            yield leads.pop()
        if not read_lowest(tracks, leads.take):
            return


Taker = Callable[[Track, Kept | None], None]
"""What is told of each event that is read: its track, and its frame if there is one."""


def read_lowest(tracks: Sequence[Track], take: Taker) -> bool:
    """Read from the track that is known least far; false if all have ended."""
    lowest = min((track for track in tracks if not track.ended), key=lambda track: track.floor, default=None)
    if lowest is None:
        return False
    take(lowest, lowest.read())
    return True


class _Leads:
    def __init__(self, tracks: Sequence[Track], slop: float) -> None:
        self.tracks, self.slop = tracks, slop
        self.place = {id(track): k for k, track in enumerate(tracks)}
        self.undecided: list[deque[float]] = [deque() for _ in tracks]
        self.leading: list[deque[float]] = [deque() for _ in tracks]
        self.decided = [float("-inf")] * len(tracks)
        self.pending: list[tuple[float, int]] = []

    def take(self, track: Track, kept: Kept | None) -> None:
        if kept is not None:
            self.undecided[self.place[id(track)]].append(kept.time)
        for k in range(len(self.tracks)):
            self._decide(k)
        known = min(self.decided)
        for times in self.leading:
            while times and known - times[0] > self.slop:
                times.popleft()

    def _decide(self, k: int) -> None:
        waiting = self.undecided[k]
        while waiting and all(self.decided[j] - waiting[0] > self.slop for j in range(k)):
            time = waiting.popleft()
            again = bool(self.leading[k]) and self.leading[k][-1] == time
            if not again and not self._led(k, time):
                self.leading[k].append(time)
                heapq.heappush(self.pending, (time, k))
        self.decided[k] = waiting[0] if waiting else self.tracks[k].floor

    def _led(self, k: int, time: float) -> bool:
        return any(abs(lead - time) <= self.slop for j in range(k) for lead in self.leading[j])

    def settled(self) -> bool:
        """Whether no earlier moment can be found, and no further frame within the slop of the first one."""
        if not self.pending:
            return False
        time = self.pending[0][0]
        return min(self.decided) >= time and all(track.floor - time > self.slop for track in self.tracks)

    def pop(self) -> float:
        return heapq.heappop(self.pending)[0]


def grid(tracks: Sequence[Track], slop: float, every: float) -> Iterator[tuple[float | None, int]]:
    """Yield the times ``start + k * every``, each once all frames within the slop are in the tracks.

    `start` is the earliest time of all frames, and no time is after the latest one.

    Yields
    ------
    time : float or None
        A time with a frame within the slop, or the first one of a run of times without; None for the others.
    empty : int
        How many times without any frame this stands for.
    """
    start, k, within_run = _start(tracks), 0, False
    while start is not None:
        time = start + k * every
        while not all(track.floor - time > slop for track in tracks):
            read_lowest(tracks, _nothing)
        while max(track.last for track in tracks) < time and read_lowest(tracks, _nothing):
            pass
        latest = max(track.last for track in tracks)
        if time > latest:
            return
        if any(track.near(time, slop) for track in tracks):
            yield time, 0
            within_run, k = False, k + 1
            continue
        if not within_run:
            yield time, 1
            within_run, k = True, k + 1
            continue
        ahead = min(latest, *(track.after(time) for track in tracks))
        # The quotient is rounded: one time less, so that no time near a frame is passed over.
        following = max(k + 1, math.floor((ahead - slop - start) / every) - 1)
        yield None, following - k
        k = following


def _start(tracks: Sequence[Track]) -> float | None:
    """Return the earliest time of all frames; None if there is no frame."""
    first = dict[int, float]()

    def take(track: Track, kept: Kept | None) -> None:
        if kept is not None:
            first.setdefault(id(track), kept.time)

    while not first or any(id(track) not in first and track.floor < min(first.values()) for track in tracks):
        if not read_lowest(tracks, take):
            break
    return min(first.values(), default=None)


def _nothing(track: Track, kept: Kept | None) -> None:
    """Take nothing: the track keeps the frame."""
