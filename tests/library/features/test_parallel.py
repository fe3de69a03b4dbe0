"""Pictures described side by side: the same rows in the same order, the same errors, and no thread left."""

import os
import threading

import numpy as np
import pytest

from convexperc.errors import ImageError
from convexperc.features import FeatureConfiguration, extract, extraction, parallel
from convexperc.features.parallel import available_cores, side_by_side

CONFIGURATION = FeatureConfiguration(working_size=(40, 36), hog_pixels_per_cell=(8, 8))
PICTURES = np.random.default_rng(4).integers(0, 256, (7, 50, 60, 3), dtype=np.uint8)
LONG = 60.0
"""Seconds after which a thread that should have come is given up."""


def no_threads(*arguments):
    pytest.fail(f"a thread was asked for: {arguments}")


@pytest.mark.parametrize("workers", [0, 1, 2, 3, 6, 7, 40])
@pytest.mark.parametrize("count", [0, 1, 2, 7])
def test_results_are_in_the_order_of_the_items(workers, count):
    assert side_by_side(lambda item: item * 3, range(count), workers) == [3 * item for item in range(count)]


def test_as_many_items_as_workers_are_worked_on_at_once():
    barrier, before = threading.Barrier(3), threading.active_count()
    assert sorted(side_by_side(lambda item: barrier.wait(LONG), [0, 1, 2], 3)) == [0, 1, 2]
    assert threading.active_count() == before


def test_the_first_error_by_order_is_raised_and_every_thread_ends():
    later, before = threading.Event(), threading.active_count()

    def work(item):
        if item == 1:
            assert later.wait(LONG)
        if item in (1, 3, 4):
            later.set()
            raise ValueError(item)
        return item

    for workers in (2, 3, 5):
        later.clear()
        with pytest.raises(ValueError, match="1"):
            side_by_side(work, range(5), workers)
        assert threading.active_count() == before, workers


def test_the_cores_are_those_that_the_process_may_use(monkeypatch):
    monkeypatch.setattr(os, "sched_getaffinity", lambda process: {0, 2, 5}, raising=False)
    assert available_cores() == 3
    monkeypatch.delattr(os, "sched_getaffinity")
    for count, cores in ((6, 6), (None, 1)):
        monkeypatch.setattr(os, "cpu_count", lambda count=count: count)
        assert available_cores() == cores


@pytest.mark.parametrize("cores", [2, 3, 16])
@pytest.mark.parametrize("batch", [1, 30_000, 2**26])
def test_features_do_not_depend_on_cores_or_batches(cores, batch, monkeypatch):
    expected = np.stack([extract([picture], CONFIGURATION)[0] for picture in PICTURES])
    asked = []
    monkeypatch.setattr(extraction, "LARGE", 0)
    monkeypatch.setattr(extraction, "BATCH", batch)
    monkeypatch.setattr(extraction, "available_cores", lambda: asked.append(cores) or cores)
    found = extract(iter(PICTURES), CONFIGURATION)
    assert found.tobytes() == expected.tobytes()
    assert len(asked) == {1: 7, 30_000: 3, 2**26: 1}[batch], asked


def test_one_picture_and_small_ones_need_no_thread(monkeypatch):
    monkeypatch.setattr(extraction, "available_cores", lambda: 8)
    monkeypatch.setattr(parallel, "ThreadPoolExecutor", no_threads)
    large = np.kron(PICTURES[0], np.ones((20, 20, 1), np.uint8))
    assert extract([large], CONFIGURATION).shape[0] == 1
    assert extract(list(PICTURES) * 20, CONFIGURATION).shape[0] == 140
    with pytest.raises(pytest.fail.Exception, match="a thread was asked for"):
        extract([large, large], CONFIGURATION)


def test_the_first_picture_that_cannot_be_used_is_named(monkeypatch):
    monkeypatch.setattr(extraction, "LARGE", 0)
    monkeypatch.setattr(extraction, "available_cores", lambda: 3)
    images = [*PICTURES[:3], PICTURES[3] / 2.0, *PICTURES[4:6], "no picture"]

    def read():
        yield from images
        raise ZeroDivisionError

    with pytest.raises(ImageError, match=r"images\[3\]"):
        extract(read(), CONFIGURATION)


def test_no_thread_is_started_by_an_import_or_left_at_the_end(interpreter):
    program = (
        "import threading, numpy as np\n"
        "from convexperc.features import FeatureConfiguration, extract, extraction\n"
        "print(threading.active_count())\n"
        "extraction.LARGE, extraction.available_cores = 0, lambda: 3\n"
        "extract(np.zeros((5, 40, 40, 3), np.uint8), FeatureConfiguration())\n"
        "print(threading.active_count())\n"
    )
    done = interpreter.run(program)
    assert (done.returncode, done.stdout) == (0, "1\n1\n"), done
