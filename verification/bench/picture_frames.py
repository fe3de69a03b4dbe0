"""A frame from its pictures: six views of 320 x 240 pixels to the proved label against eight references.

The scene is made of the sample alone, so that it needs no simulator and is the same everywhere.
"""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from statistics import median
from typing import Any, TypeVar

import cv2
import numpy as np

from convexperc.features import FeatureConfiguration
from convexperc.features.extraction import extract
from convexperc.features.pictures import resize
from convexperc.recognition.label import recognize
from convexperc.recognition.recognition import Verdict
from convexperc.recognition.references import NamedPictures, References, perceive
from convexperc.recognition.sample import sample_scene
from convexperc.recognition.warming import warm
from verification.bench.instances import LAMBDAS, Lambdas

SIZE = (240, 320)
"""Height and width of every picture."""
LABEL = "red-car"
"""The object that all views show."""
RECOLORED = ("red-car", "ica-sign")
"""Objects whose colours are swapped to make others."""
NEGATED = "gray-car"
"""The object whose negative is another one."""

Clock = Callable[[], float]
Result = TypeVar("Result")


@dataclass(frozen=True)
class PictureTimes:
    """Seconds of successive frames against the same references, each frame a little different.

    Attributes
    ----------
    preparation : float
        The references described, once.
    frames : tuple of float
        Each whole frame, pictures to label, by machine code that is loaded before.
    extractions, recognitions : tuple of float
        The two stages of each frame, timed apart after it.
    proved : int
        Frames whose label is right and proved.
    """

    preparation: float
    frames: tuple[float, ...]
    extractions: tuple[float, ...]
    recognitions: tuple[float, ...]
    proved: int

    @property
    def first(self) -> float:
        """The first frame."""
        return self.frames[0]

    @property
    def warm(self) -> float:
        """Median of the further frames."""
        return median(self.frames[1:])

    @property
    def extraction(self) -> float:
        """Median of the further frames' features."""
        return median(self.extractions[1:])

    @property
    def recognition(self) -> float:
        """Median of the further frames' labels, from the features on."""
        return median(self.recognitions[1:])


def picture_times(
    repeat: int, lambdas: Lambdas = LAMBDAS[0], clock: Clock = time.perf_counter
) -> PictureTimes:
    """Time a first frame and `repeat` further ones, on the cores of the process, with OpenCV on one thread.

    Parameters
    ----------
    repeat : int
        At least 1.
    lambdas : tuple of float
    clock : callable
        Gives seconds; `time.process_time`, where the machine is shared, counts those of all threads.

    Returns
    -------
    PictureTimes
    """
    weights: dict[str, Any] = dict(zip(("lambda1", "lambda2", "lambda3"), lambdas, strict=True))
    configuration = FeatureConfiguration()
    warm()
    known, frames, extractions, recognitions, proved = eight_references(), [], [], [], 0
    with one_opencv_thread():
        preparation, references = _timed(lambda: References.of(known, configuration), clock)
        for frame in range(repeat + 1):
            views = six_views(frame)
            seconds, found = _timed(partial(perceive, views, references, **weights), clock)
            frames.append(seconds)
            proved += found.verdict is Verdict.PROVED and found.label == LABEL
            seconds, X = _timed(partial(extract, views.values(), configuration), clock)
            extractions.append(seconds)
            sizes = configuration.modality_sizes
            label = partial(recognize, X, references.O, names=references.names, modalities=sizes, **weights)
            recognitions.append(_timed(label, clock)[0])
    return PictureTimes(preparation, tuple(frames), tuple(extractions), tuple(recognitions), proved)


def eight_references() -> NamedPictures:
    """The sample's three objects, two of them with other colours, and one negative."""
    known = {name: resize(picture, SIZE) for name, picture in sample_scene(LABEL).references.items()}
    recolored = {
        f"{name}, channels moved by {step}": np.roll(known[name], step, axis=2)
        for name in RECOLORED
        for step in (1, 2)
    }
    return {**known, **recolored, f"{NEGATED}, negative": 255 - known[NEGATED]}


def six_views(frame: int) -> NamedPictures:
    """The sample's five views and the mirror image of the first, panned by one pixel a frame."""
    seen = [resize(picture, SIZE) for picture in sample_scene(LABEL).views.values()]
    seen.append(seen[0][:, ::-1])
    return {f"robot-{i}": np.roll(picture, frame, axis=1) for i, picture in enumerate(seen, 1)}


@contextmanager
def one_opencv_thread() -> Iterator[None]:
    """Context in which OpenCV uses one thread."""
    before = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        yield
    finally:
        cv2.setNumThreads(before)


def _timed(work: Callable[[], Result], clock: Clock) -> tuple[float, Result]:
    start = clock()
    result = work()
    return clock() - start, result
