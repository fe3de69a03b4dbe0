"""Pictures in files: one, a sequence, or a video."""

import os
import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import cv2
import numpy as np

from convexperc.errors import ImageError, SourceError
from convexperc.features.folders import Folder
from convexperc.features.pictures import Picture, list_images, read_image
from convexperc.inputs.capture import capture_of, captured
from convexperc.inputs.frames import Frame, Source

_DIGITS = re.compile(r"(\d+)")
_STAMPS = {10: 1.0, 13: 1e-3, 16: 1e-6, 19: 1e-9}
"""Digits of the time since the epoch, from 2001 to 2286, in s, ms, us and ns, and the unit in seconds."""


class Still(Source):
    """One picture file, at time 0 and valid at every moment."""

    still = True

    def __init__(self, text: str, path: Path) -> None:
        super().__init__(text, f"picture {path}")
        self._path = path

    def __iter__(self) -> Iterator[Frame]:
        yield Frame(0.0, lambda: read_image(self._path))


class PictureSequence(Source):
    """Picture files, one frame each.

    Parameters
    ----------
    text, name : str
        See `Source`.
    paths : sequence of pathlib.Path
        At least one.
    rate : float
        Frames a second, where the names are no time stamps.
    omitted : tuple of str
        What of a folder is left out, and why.
    """

    def __init__(
        self, text: str, name: str, paths: Sequence[Path], rate: float, omitted: tuple[str, ...] = ()
    ) -> None:
        super().__init__(text, name)
        times = time_stamps([path.stem for path in paths])
        if times is None:
            ordered = sorted(paths, key=natural_order)
            self._frames = [(k / rate, path) for k, path in enumerate(ordered)]
            told = f"times by position, {rate:g} frames a second: the names are no time stamps"
        else:
            self._frames = sorted(zip(times, paths, strict=True))
            told = "times by the names of the files"
        self._remarks = (told, *(f"left out: {each}" for each in omitted))

    @property
    def remarks(self) -> tuple[str, ...]:
        """Where the times come from, and what of the folder is left out."""
        return self._remarks

    def __iter__(self) -> Iterator[Frame]:
        for time, path in self._frames:
            yield Frame(time, _reader(path))


def _reader(path: Path) -> Callable[[], Picture]:
    return lambda: read_image(path)


def natural_order(path: Path) -> tuple[list[tuple[int, str]], str]:
    """Sort by this to have digits in the order of their number: ``2.png`` before ``10.png``."""
    whole = os.fspath(path)
    parts = _DIGITS.split(whole)  # every second one is a number
    return [(int(part), "") if k % 2 else (0, part) for k, part in enumerate(parts)], whole


def time_stamps(stems: Sequence[str]) -> list[float] | None:
    """Read the names of files, without their suffix, as times in seconds; None unless all are times.

    A time is a number of seconds with a decimal point, ``1700000000.25`` or ``12.5``, or an integer without
    leading zeros of 10, 13, 16 or 19 digits, the seconds, milliseconds, microseconds or nanoseconds since the
    epoch. All must be of the same form. Other integers are counters.
    """
    if all(re.fullmatch(r"\d+\.\d+", stem, re.ASCII) for stem in stems):
        return [float(stem) for stem in stems]
    digits = {len(stem) for stem in stems}
    if len(digits) == 1 and all(re.fullmatch(r"[1-9]\d*", stem, re.ASCII) for stem in stems):
        count = digits.pop()
        if count in _STAMPS:  # a quotient of integers, which is rounded once
            return [int(stem) / round(1 / _STAMPS[count]) for stem in stems]
    return None


def open_folder(text: str, path: Path, rate: float) -> Source:
    """Open a folder of pictures.

    Raises
    ------
    SourceError
        It cannot be read or holds no picture.
    """
    try:
        pictures, found = list_images(path), Folder.of(path)
    except ImageError as error:
        raise SourceError(error.what, value=error.value, must=error.must, remedy=error.remedy) from None
    omitted = [f"{name} ({reason})" for name, reason in found.others]
    omitted += [f"{each.name} (a folder)" for each in found.folders]
    return PictureSequence(text, f"folder {path}", pictures, rate, tuple(omitted))


class Video(Source):
    """A video file, read by OpenCV; its frames have the time stamps of the file.

    Where these do not increase, as in streams that were stored without them, times are by position at the
    file's own rate, or at the given one if it states none.

    Raises
    ------
    SourceError
        OpenCV finds no video in it.
    """

    def __init__(self, text: str, path: Path, rate: float) -> None:
        super().__init__(text, f"video {path}")
        self._path, self._rate = path, rate
        self._remarks = list[str]()
        with _opened(path, self.name) as capture:
            stated = capture.get(cv2.CAP_PROP_FPS)
            self._expected = int(capture.get(cv2.CAP_PROP_FRAME_COUNT))
        self._stated = stated if 0 < stated < float("inf") else 0.0

    @property
    def remarks(self) -> tuple[str, ...]:
        """Where it lacks time stamps or frames, as far as it has been read."""
        return tuple(dict.fromkeys(self._remarks))

    def __iter__(self) -> Iterator[Frame]:
        with _opened(self._path, self.name) as capture:
            count, before = 0, -1.0
            while True:
                sound, pixels = capture.read()
                if not sound:
                    break
                time = capture.get(cv2.CAP_PROP_POS_MSEC) / 1000
                if not time > before:
                    time = before + 1 / (self._stated or self._rate)
                    self._tell_position()
                before = time
                yield Frame(time, captured(np.asarray(pixels, dtype=np.uint8), f"{self.name}, frame {count}"))
                count += 1
        if count < self._expected:
            self._remarks.append(f"ends after {count} of the {self._expected} frames that it states")
        if not count:
            raise SourceError(self.name, value="no frame", must="must hold frames that OpenCV can decode")

    def _tell_position(self) -> None:
        rate = self._stated or self._rate
        self._remarks.append(f"time stamps do not increase: such frames follow at {rate:g} frames a second")


@contextmanager
def _opened(path: Path, name: str) -> Iterator[cv2.VideoCapture]:
    capture = capture_of(str(path))
    try:
        if not capture.isOpened():
            must, remedy = (
                "must be a video that OpenCV can read",
                "Convert it, for example to MP4 with H.264.",
            )
            raise SourceError(name, value=f"{path.stat().st_size} bytes", must=must, remedy=remedy)
        yield capture
    finally:
        capture.release()
