"""Cameras and streams: what is newest, what is dropped, what stops; and how they end."""

import subprocess
import sys
import threading
import time
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import numpy as np
import pytest
from made_sources import Lone, jpeg, number_of, picture

from convexperc.errors import SourceError
from convexperc.inputs import moments, open_source
from convexperc.inputs.live import Live


class Fake:
    """A device that gives a picture whenever it is told to, and at the end none."""

    def __init__(self, numbers=()):
        self.ready = threading.Semaphore(0)
        self.numbers = []
        self.released = threading.Event()
        self.fails = None
        for number in numbers:
            self.give(number)

    def give(self, number):
        """None for the end."""
        self.numbers.append(number)
        self.ready.release()

    def read(self):
        while not self.ready.acquire(timeout=0.01):
            if self.fails is not None:
                raise self.fails
            if self.released.is_set():
                return False, None
        number = self.numbers.pop(0)
        if number is None:
            return False, None
        return True, np.full((12, 16, 3), (77, number // 256, number % 256), dtype=np.uint8)  # B, G, R

    def release(self):
        self.released.set()


@pytest.fixture
def cameras():
    """Make cameras; close them, and see that no thread is left."""
    made = []

    def make(*numbers, timeout=5.0):
        device = Fake(numbers)
        made.append((Live("0", f"camera {len(made)}", device, timeout), device))
        return made[-1]

    yield make
    for source, device in made:
        device.give(None)
        source.close()
        assert device.released.is_set()
    assert not [thread for thread in threading.enumerate() if thread.name.startswith("convexperc")]


def until(condition, seconds=5.0):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "it did not happen"
        time.sleep(0.001)


def test_the_newest_frame_wins_and_the_dropped_are_counted(cameras):
    source, device = cameras(1, 2, 3)
    until(lambda: source.counts.frames == 3)
    frame = source.take()
    assert number_of(frame.picture) == 3
    assert source.take() is None
    assert source.counts.dropped == 2
    device.give(4)
    until(lambda: source.waiting)
    assert number_of(source.take().picture) == 4


def test_times_are_those_of_the_arrival(cameras):
    before = time.time()
    source, _ = cameras(1)
    until(lambda: source.waiting)
    assert before - 0.1 <= source.take().time <= time.time() + 0.1


def test_a_moment_waits_for_all_cameras_but_not_longer_than_the_slop(cameras):
    (a, first), (b, second) = cameras(), cameras()
    found = moments({"a": a, "b": b}, slop=0.3)
    first.give(1)
    threading.Timer(0.05, second.give, [2]).start()
    moment = next(found)
    assert {robot: number_of(view) for robot, view in moment.views.items()} == {"a": 1, "b": 2}
    assert moment.time == max(moment.times.values())
    first.give(3)
    begun = time.monotonic()
    moment = next(found)
    assert 0.2 < time.monotonic() - begun < 20.0
    assert number_of(moment.views["a"]) == 3
    assert "b" not in moment.views or moment.time - moment.times["b"] <= 0.3
    found.close()


def test_an_old_frame_is_left_out_with_its_age(cameras):
    (a, first), (b, _) = cameras(), cameras(2)
    until(lambda: b.waiting)
    found = moments({"a": a, "b": b}, slop=0.05)
    assert set(next(found).views) == {"b"}
    time.sleep(0.2)
    first.give(1)
    moment = next(found)
    assert set(moment.views) == {"a"}
    assert "s: its newest is " in moment.missing["b"]


def test_a_camera_that_stops_is_named_and_the_rest_go_on(cameras):
    (a, first), (b, _) = cameras(1, timeout=5.0), cameras(2, timeout=0.2)
    until(lambda: a.waiting and b.waiting)
    found = moments({"a": a, "b": b}, slop=0.5)
    assert set(next(found).views) == {"a", "b"}
    time.sleep(0.8)
    first.give(3)
    moment = next(found)
    assert "camera 1: no picture for " in moment.missing["b"]
    assert "b: broke off: camera 1: no picture for" in "\n".join(found.remarks)


def test_a_camera_that_is_back_is_back(cameras):
    (a, first), (b, second) = cameras(1), cameras(2, timeout=0.1)
    until(lambda: a.waiting and b.waiting)
    found = moments({"a": a, "b": b}, slop=0.5)
    next(found)
    time.sleep(0.8)
    first.give(3)
    assert set(next(found).views) == {"a"}
    first.give(5)
    second.give(4)
    until(lambda: a.waiting and b.waiting)
    assert set(next(found).views) == {"a", "b"}


def test_moments_end_when_all_have_ended_and_nothing_is_uncounted(cameras):
    (a, _), (b, _) = cameras(1, 2, None), cameras(3, None)
    until(lambda: a.counts.frames == 2 and b.counts.frames == 1)
    found = moments({"a": a, "b": b}, slop=1.0)
    (only,) = found
    assert {robot: number_of(view) for robot, view in only.views.items()} == {"a": 2, "b": 3}
    assert (found.counts["a"].frames, found.counts["a"].used, found.counts["a"].dropped) == (2, 1, 1)
    assert "a: 1 of 2 frames dropped for newer ones" in found.remarks
    assert "gives no more pictures" in found.counts["b"].ended


def test_if_all_stop_delivering_the_moments_end(cameras):
    source, _ = cameras(1, timeout=0.2)
    begun = time.monotonic()
    assert len(list(moments({"a": source}, slop=0.1))) == 1
    assert time.monotonic() - begun < 20.0


def test_every_is_kept(cameras):
    source, device = cameras(0)
    found = moments({"a": source}, slop=0.0, every=0.2)
    begun = []
    for number in range(1, 4):
        next(found)
        begun.append(time.monotonic())
        device.give(number)
    gaps = np.diff(begun)
    assert (gaps > 0.15).all(), gaps
    found.close()


def test_a_still_goes_with_cameras(cameras):
    source, _ = cameras(1, None)
    (only,) = moments({"still": Lone(9), "a": source}, slop=0.1)
    assert [number_of(view) for view in only.views.values()] == [9, 1]
    assert only.times["still"] == only.time


def test_a_driver_that_raises_ends_its_camera_with_the_reason(cameras):
    source, device = cameras(1)
    until(lambda: source.waiting)
    device.fails = RuntimeError("unplugged")
    found = list(moments({"a": source}, slop=0.1))
    assert len(found) == 1
    assert "RuntimeError: unplugged" in source.counts.ended


def test_frames_come_one_by_one_and_the_end_is_an_error(cameras):
    source, device = cameras()
    frames = iter(source)
    for number in (1, 2):
        device.give(number)
        assert number_of(next(frames).picture) == number
    device.give(None)
    with pytest.raises(SourceError, match="gives no more pictures"):
        next(frames)


def test_a_frame_that_is_no_picture_leaves_its_robot_out(cameras):
    source, device = cameras()
    device.read = lambda: (
        (device.released.is_set() or time.sleep(0.01), np.zeros((2, 2, 3), np.uint8))[1:]
        and (
            not device.released.is_set(),
            np.zeros((2, 2, 3), np.uint8),
        )
    )
    device.give(1)
    found = moments({"a": source}, slop=0.1)
    next(found)
    moment = next(found)
    assert "sides of at least" in moment.missing["a"]
    assert found.counts["a"].unreadable == 1
    found.close()


def test_closing_on_the_way_ends_the_thread(cameras):
    source, device = cameras(1)
    with moments({"a": source}, slop=0.1) as found:
        next(found)
        device.give(2)
        until(lambda: source.waiting)
        device.give(3)
    counts = found.counts["a"]
    assert counts.ended == ""
    assert counts.used + counts.dropped == counts.frames
    device.give(None)
    until(device.released.is_set)


def test_a_camera_that_hangs_does_not_hold_up_the_end_and_is_named(cameras, monkeypatch):
    monkeypatch.setattr("convexperc.inputs.live._PATIENCE", 0.1)
    source, device = cameras(1)
    with moments({"a": source}, slop=0.1) as found:
        next(found)
    assert not device.released.is_set()
    assert "a: it does not answer, and is left to the end of the program" in found.remarks


def test_a_camera_that_is_not_there_is_refused():
    with pytest.raises(SourceError, match=r"camera 97.*free"):
        open_source("camera:97")
    with pytest.raises(SourceError, match="stream rtsp"):
        open_source("rtsp://127.0.0.1:9/none", timeout=1.0)


def test_a_password_is_not_repeated():
    """It would stand in the lines and the bag of results, where the camera is missing."""
    with pytest.raises(SourceError, match=r"stream rtsp://u:\*\*\*@127.0.0.1:9/none") as raised:
        open_source("rtsp://u:se:cr@t@127.0.0.1:9/none", timeout=1.0)
    assert "cr@t" not in str(raised.value)


class Motion(BaseHTTPRequestHandler):
    """Motion JPEG, as network cameras send it."""

    def do_GET(self):
        self.send_response(200)
        self.send_header("Content-Type", "multipart/x-mixed-replace; boundary=x")
        self.end_headers()
        try:
            for number in range(60):
                data = jpeg(picture(number % 10 + 100, (48, 64)))
                head = f"--x\r\nContent-Type: image/jpeg\r\nContent-Length: {len(data)}\r\n\r\n"
                self.wfile.write(head.encode() + data + b"\r\n")
                time.sleep(0.02)
        except OSError:
            pass  # the reader has closed

    def log_message(self, *_):
        pass


@pytest.fixture
def address():
    """The address of a stream."""
    server = ThreadingHTTPServer(("127.0.0.1", 0), Motion)
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    yield f"http://127.0.0.1:{server.server_port}/stream.mjpg"
    server.shutdown()
    thread.join()
    server.server_close()


def test_a_stream_is_read(address):
    with moments({"a": open_source(address, timeout=5.0)}, slop=0.1) as found:
        views = [next(found).views["a"] for _ in range(3)]
    for view in views:
        red, green, blue = view[0, 0]
        assert abs(int(blue) - 77) <= 4
        assert 96 <= red <= 113
        assert green <= 4


@pytest.mark.parametrize(
    "end", ["", "raise SystemExit(2)", "inputs.moments({'a': stream, 'b': other}, slop=0.1)"]
)
def test_a_program_may_end_while_a_stream_is_read(address, tmp_path, end):
    """The thread that reads is not stopped within OpenCV, which would abort the process."""
    still = tmp_path / "run"
    still.mkdir()
    (still / "0.5.jpg").write_bytes(jpeg(picture(1, (48, 64))))
    program = (
        "import sys; from convexperc import inputs\n"
        "stream, other = map(inputs.open_source, sys.argv[1:])\n"
        "while not stream.waiting: pass\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program + end, address, str(still)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == {"": 0, "raise SystemExit(2)": 2}.get(end, 1), done.stderr
    assert "FATAL" not in done.stderr
