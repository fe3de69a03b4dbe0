"""Cameras and streams: the newest picture wins."""

import atexit
import threading
import time
from collections.abc import Iterator, Mapping
from typing import Any, Protocol, runtime_checkable

from convexperc.errors import InputError, SourceError
from convexperc.inputs.capture import capture_of, captured
from convexperc.inputs.frames import Frame, Source
from convexperc.inputs.tracks import Counts

_STEP = 0.05
"""Seconds after which a wait looks for what no event tells of: a camera that has stopped delivering."""
_PATIENCE = 2.0
"""Seconds that closing waits for a camera that is being read."""


@runtime_checkable
class Capture(Protocol):
    """What of `cv2.VideoCapture` is used."""

    def read(self) -> tuple[bool, Any]:
        """Wait for the next picture, B, G, R."""

    def release(self) -> None:
        """Close the device."""


class Live(Source):
    """A camera or stream, read by a thread that keeps the newest frame; its time is that of its arrival.

    Parameters
    ----------
    text, name : str
        See `Source`.
    capture : Capture
        An open device.
    timeout : float
        Seconds without a frame after which it counts as stopped; it is back with its next frame.
    """

    live = True

    def __init__(self, text: str, name: str, capture: Capture, timeout: float) -> None:
        super().__init__(text, name)
        self.timeout = timeout
        self.arrived = threading.Event()
        """Set at each frame and at the end; `arrivals` shares one among several sources."""
        self._capture = capture
        self._lock = threading.Lock()
        self._newest: Frame | None = None
        self._frames = self._dropped = self._used = self._unreadable = self._unused = 0
        self._heard = time.monotonic()
        self._end = ""  # why the thread has ended
        self._ended = ""  # why it had stopped when it was closed
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._read, name=f"convexperc: {name}", daemon=True)
        self._thread.start()
        atexit.register(self.close)  # Python ends threads by force, within OpenCV with an abort

    def _read(self) -> None:
        end = "it gives no more pictures"
        try:
            while not self._closing.is_set():
                sound, pixels = self._capture.read()
                if not sound:
                    break
                frame = Frame(now(), captured(pixels, self.name))
                with self._lock:
                    self._dropped += self._newest is not None
                    self._newest, self._heard = frame, time.monotonic()
                    self._frames += 1
                self.arrived.set()
        except Exception as problem:  # a driver's error of any type: it ends the camera, not the program
            end = f"{type(problem).__name__}: {problem}"
        finally:
            self._capture.release()
            with self._lock:
                self._end = "it was closed" if self._closing.is_set() else end
            self.arrived.set()

    def take(self) -> Frame | None:
        """Return the newest frame, unless it has been taken."""
        with self._lock:
            frame, self._newest = self._newest, None
        return frame

    @property
    def waiting(self) -> bool:
        """Whether there is a frame that has not been taken."""
        with self._lock:
            return self._newest is not None

    @property
    def stopped(self) -> str:
        """Why no frame is to be expected; empty where there is one, or one may come."""
        with self._lock:
            if self._newest is not None:
                return ""
            if self._end:
                return f"{self.name}: {self._end}"
            silent = time.monotonic() - self._heard
        return f"{self.name}: no picture for {silent:.1f} s" if silent > self.timeout else ""

    def account(self, frame: Frame, *, used: bool) -> None:
        """Count a frame that was taken, once it is known whether a moment used it."""
        with self._lock:
            if used:
                self._used += 1
            elif frame.error is not None:
                self._unreadable += 1
            else:
                self._unused += 1

    @property
    def counts(self) -> Counts:
        """What became of the frames so far."""
        ended = self._ended if self._closing.is_set() else self.stopped
        with self._lock:
            return Counts(
                self._frames, self._used, self._unused, self._unreadable, dropped=self._dropped, ended=ended
            )

    def __iter__(self) -> Iterator[Frame]:
        """Wait for new frames, one after the other, until it stops.

        Raises
        ------
        SourceError
            It gives no more pictures, or none for the timeout.
        """
        while True:
            self.arrived.clear()
            frame = self.take()
            if frame is not None:
                yield frame
                continue
            stopped = self.stopped
            if stopped and self._closing.is_set():
                return
            if stopped:
                raise SourceError(self.name, value=stopped, must="must deliver pictures")
            self.arrived.wait(_STEP)

    def close(self) -> None:
        """Stop reading and release the device, once the picture that is being read has come."""
        if not self._closing.is_set():
            self._ended = self.stopped
            self._closing.set()
            atexit.unregister(self.close)
        self._thread.join(_PATIENCE)
        self._dropped += self.take() is not None

    @property
    def remarks(self) -> tuple[str, ...]:
        """Whether it could not be closed."""
        hangs = self._closing.is_set() and self._thread.is_alive()
        return ("it does not answer, and is left to the end of the program",) if hangs else ()


def now() -> float:
    """Seconds since the epoch, on a clock that is never set while the program runs."""
    return _EPOCH + time.monotonic()


_EPOCH = time.time() - time.monotonic()


def open_live(text: str, name: str, address: int | str, timeout: float) -> Live:
    """Open a camera by its number, or a stream by its address.

    Raises
    ------
    SourceError
        It cannot be opened.
    """
    capture = capture_of(address, timeout)
    if not capture.isOpened():
        capture.release()
        must, remedy = "must be a camera or stream that OpenCV can open", "Is it connected, and free?"
        raise SourceError("source", value=name, must=must, remedy=remedy)
    return Live(text, name, capture, timeout)


Arrival = Mapping[str, Frame | InputError | str]
"""The frame of each robot, or why there is none."""


def arrivals(
    sources: Mapping[str, Live], slop: float, every: float | None
) -> Iterator[tuple[Arrival, float]]:
    """Yield the newest frames of several live sources, and the time of the newest; see `moments`."""
    arrived = threading.Event()
    for source in sources.values():
        source.arrived = arrived
    held, begun = dict[str, Frame](), float("-inf")
    while True:
        if every is not None:
            time.sleep(max(0.0, begun + every - now()))
        if not _wait(sources, arrived, any_of_them=True, seconds=float("inf")):
            return
        begun = now()
        _wait(sources, arrived, any_of_them=False, seconds=slop)
        fresh = {name: frame for name, source in sources.items() if (frame := source.take()) is not None}
        held.update(fresh)
        moment = max(frame.time for frame in fresh.values())
        chosen = {name: _choice(source, held.get(name), moment, slop) for name, source in sources.items()}
        for name, frame in fresh.items():
            sources[name].account(frame, used=chosen[name] is frame)
        yield chosen, moment


def _wait(
    sources: Mapping[str, Live], arrived: threading.Event, *, any_of_them: bool, seconds: float
) -> bool:
    """Wait for a frame of any, or of every source that has not stopped; return whether there is one."""
    end = now() + seconds
    while True:
        arrived.clear()
        waiting = [source.waiting for source in sources.values()]
        if (
            any(waiting)
            if any_of_them
            else all(there or source.stopped for there, source in zip(waiting, sources.values(), strict=True))
        ):
            return True
        if all(source.stopped for source in sources.values()) or now() >= end:
            return any(source.waiting for source in sources.values())
        arrived.wait(min(_STEP, max(0.0, end - now())))


def _choice(source: Live, frame: Frame | None, moment: float, slop: float) -> Frame | InputError | str:
    if frame is not None and moment - frame.time <= slop:
        return frame.error or frame
    stopped = source.stopped
    if stopped or frame is None:
        return stopped or "no picture yet"
    return f"no picture within {slop:g} s: its newest is {moment - frame.time:.3g} s old"
