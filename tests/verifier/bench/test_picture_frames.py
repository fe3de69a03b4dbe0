"""The benchmark of whole frames from pictures: its scene, its stages, and the label it must find."""

from itertools import combinations, count

import cv2
import numpy as np
import pytest

from convexperc.features import FeatureConfiguration
from convexperc.recognition.references import References
from verification.bench import picture_frames
from verification.bench.picture_frames import (
    LABEL,
    SIZE,
    PictureTimes,
    eight_references,
    one_opencv_thread,
    picture_times,
    six_views,
)


def test_the_scene_has_six_views_and_eight_different_references():
    references, views = eight_references(), six_views(0)
    assert (len(references), len(views)) == (8, 6)
    assert LABEL in references
    for picture in (*references.values(), *views.values()):
        assert (picture.shape, picture.dtype) == ((*SIZE, 3), np.uint8)
    features = References.of(references, FeatureConfiguration()).O.T
    for (i, a), (j, b) in combinations(enumerate(features), 2):
        assert np.linalg.norm(a - b) > 0.3, (i, j, np.linalg.norm(a - b))


def test_the_next_frame_differs_a_little():
    for name, now in six_views(3).items():
        later = six_views(4)[name]
        assert np.array_equal(np.roll(now, 1, axis=1), later), name
        assert not np.array_equal(now, later), name


def test_every_frame_ends_in_the_right_label_proved():
    threads = cv2.getNumThreads()
    times = picture_times(2)
    assert times.proved == len(times.frames) == len(times.extractions) == 3, times
    assert len(times.recognitions) == 3, times
    assert min(times.preparation, *times.frames, *times.extractions, *times.recognitions) > 0.0, times
    assert cv2.getNumThreads() == threads


def test_a_wrong_label_is_not_counted(monkeypatch):
    monkeypatch.setattr(picture_frames, "LABEL", "ica-sign")
    shown = six_views(0)
    monkeypatch.setattr(picture_frames, "LABEL", LABEL)
    monkeypatch.setattr(picture_frames, "six_views", lambda frame: shown)
    assert picture_times(1).proved == 0


def test_stages_are_medians_of_the_further_frames():
    times = PictureTimes(1.0, (90.0, 7.0, 8.0, 12.0), (50.0, 5.0, 7.0, 6.0), (40.0, 2.0, 1.0, 6.0), 4)
    assert (times.first, times.warm, times.extraction, times.recognition) == (90.0, 8.0, 6.0, 2.0)


def test_the_clock_is_read_around_each_stage_only():
    ticks = count()
    times = picture_times(1, clock=lambda: float(next(ticks)))
    assert (times.preparation, times.frames) == (1.0, (1.0, 1.0)), times
    assert (times.extractions, times.recognitions) == ((1.0, 1.0), (1.0, 1.0)), times


def test_opencv_gets_its_threads_back_after_an_error():
    def fail():
        with one_opencv_thread():
            assert cv2.getNumThreads() == 1
            raise ZeroDivisionError

    threads = cv2.getNumThreads()
    with pytest.raises(ZeroDivisionError):
        fail()
    assert cv2.getNumThreads() == threads
