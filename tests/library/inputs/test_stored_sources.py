"""Picture files, folders, patterns and videos as sources, and what a user's text means."""

import os
import re
import stat
import subprocess
import sys
from fractions import Fraction
from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from made_sources import jpeg, number_of, picture, png

from convexperc.errors import InputError, SourceError
from convexperc.inputs import GRAMMAR, moments, open_source, open_sources
from convexperc.inputs.stored import natural_order, time_stamps


def fill(folder, names):
    folder.mkdir(exist_ok=True)
    for number, name in enumerate(names):
        (folder / name).write_bytes(png(picture(number)))
    return folder


def frames(source):
    return [(frame.time, number_of(frame.picture)) for frame in source]


def test_a_picture_is_a_still(tmp_path):
    (tmp_path / "a.png").write_bytes(png(picture(5)))
    source = open_source(str(tmp_path / "a.png"))
    assert source.still
    assert not source.live
    assert frames(source) == [(0.0, 5)]


def test_a_folder_without_times_is_in_natural_order_at_the_rate(tmp_path):
    folder = fill(tmp_path / "f", ["frame10.png", "frame9.png", "frame1.PNG"])
    (folder / "notes.txt").write_text("x")
    (folder / "more").mkdir()
    source = open_source(str(folder), rate=4.0)
    assert frames(source) == [(0.0, 2), (0.25, 1), (0.5, 0)]
    assert frames(source) == frames(source)
    assert source.remarks == (
        "times by position, 4 frames a second: the names are no time stamps",
        "left out: notes.txt (no picture by its name)",
        "left out: more (a folder)",
    )


@pytest.mark.parametrize(
    ("names", "times"),
    [
        (["1700000000500000000", "1700000000000000000"], [1700000000.5, 1700000000.0]),
        (["1700000000500000", "1700000001000000"], [1700000000.5, 1700000001.0]),
        (["1700000000500", "1700000000000"], [1700000000.5, 1700000000.0]),
        (["1700000001", "1700000000"], [1700000001.0, 1700000000.0]),
        (["1311868164.363181", "12.5"], [1311868164.363181, 12.5]),
        (["000001", "000002"], None),
        (["0000000001", "0000000002"], None),
        (["1", "2"], None),
        (["1700000000", "1700000000000"], None),
        (["1700000000", "17.5"], None),
        (["1.5", "x"], None),
        (["-1.5"], None),
        (["1e5"], None),
    ],
)
def test_which_names_are_times(names, times):
    assert time_stamps(names) == times


@given(st.integers(10**18, 10**19 - 1))
def test_nanoseconds_are_rounded_once(stamp):
    assert time_stamps([str(stamp)]) == [float(Fraction(stamp, 10**9))]


def test_a_folder_with_times_is_in_their_order(tmp_path):
    folder = fill(tmp_path / "f", ["12.5.png", "9.25.png", "100.0.png"])
    source = open_source(str(folder))
    assert frames(source) == [(9.25, 1), (12.5, 0), (100.0, 2)]
    assert source.remarks == ("times by the names of the files",)


@given(st.lists(st.from_regex(r"[a-c]{1,2}[0-9]{0,3}[a-c]?[0-9]{0,2}", fullmatch=True), min_size=2))
def test_natural_order_is_that_of_the_numbers_where_the_rest_is_the_same(names):
    ordered = sorted(map(Path, names), key=natural_order)
    for one, other in pairwise(ordered):
        parts = [re.split(r"(\d+)", path.name) for path in (one, other)]
        assert [p if k % 2 == 0 else int(p) for k, p in enumerate(parts[0])] <= [
            p if k % 2 == 0 else int(p) for k, p in enumerate(parts[1])
        ]


def test_a_pattern_is_what_it_matches(tmp_path):
    fill(tmp_path / "a", ["left1.png", "left2.png", "right1.png"])
    (tmp_path / "a" / "left.txt").write_text("x")
    source = open_source(f"{tmp_path}/**/left*", rate=10.0)
    assert frames(source) == [(0.0, 0), (0.1, 1)]
    assert [line for line in source.remarks if "left.txt" in line]
    with pytest.raises(SourceError, match="must match a picture"):
        open_source(f"{tmp_path}/*.jpg")


def test_what_exists_is_taken_for_itself(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    fill(tmp_path / "a*b", ["x.png"])
    (tmp_path / "run.bag#" / "topic").mkdir(parents=True)
    fill(tmp_path / "run.bag#" / "topic", ["y.png"])
    assert open_source("a*b").name == "folder a*b"
    assert open_source("run.bag#/topic").name == "folder run.bag#/topic"
    fill(tmp_path / "0", ["x.png"])
    assert open_source("./0").name == "folder 0"


def test_a_broken_picture_of_a_sequence_is_a_frame_without_one(tmp_path):
    folder = fill(tmp_path / "f", ["1.png", "2.png", "3.png", "4.png", "5.png"])
    (folder / "2.png").write_bytes(png(picture(1))[:60])
    (folder / "3.png").write_bytes(b"")
    (folder / "4.png").unlink()
    (folder / "4.png").symlink_to(folder / "nothing")
    found = moments({"a": open_source(str(folder), rate=1.0)}, slop=0.1)
    made = list(found)
    assert [bool(m.views) for m in made] == [True, False, False, False, True]
    assert "0 bytes" in made[2].missing["a"]
    assert "no such file" in made[3].missing["a"]
    assert found.counts["a"].unreadable == 3
    with pytest.raises(InputError, match=r"robot .a. at 1\.000000 s"):
        list(moments({"a": open_source(str(folder), rate=1.0)}, slop=0.1, strict=True))


def test_what_cannot_be_read_is_refused_at_once(tmp_path):
    fifo, empty, link, text = (tmp_path / name for name in ("fifo.png", "empty.mp4", "link.avi", "notes.txt"))
    os.mkfifo(fifo)
    empty.write_bytes(b"")
    link.symlink_to(tmp_path / "nothing.avi")
    text.write_text("hello " * 1000)
    (tmp_path / "none").mkdir()
    for path, said in (
        (fifo, "Pipes and devices"),
        (empty, "must not be empty"),
        (link, "a link to nothing"),
        (text, "must be a picture"),
        (tmp_path / "none", "must hold a picture"),
        (tmp_path / "absent.png", "another of the forms"),
        ("", "another of the forms"),
        ("ftp://host/x", "another of the forms"),
        ("nul\0", "another of the forms"),
        (f"{text}#/topic", "must be a bag before #"),
        (f"{tmp_path / 'absent.mcap'}#/topic", "No such file"),
    ):
        with pytest.raises(SourceError, match=re.escape(said)):
            open_source(str(path))


def test_a_fifo_that_takes_the_place_of_a_picture_does_not_block(tmp_path):
    folder = fill(tmp_path / "f", ["1.png", "2.png"])
    source = open_source(str(folder))
    (folder / "2.png").unlink()
    os.mkfifo(folder / "2.png")
    assert stat.S_ISFIFO((folder / "2.png").stat().st_mode)
    assert [frame.picture is not None for frame in source] == [True, False]


@pytest.mark.parametrize(
    "option",
    [
        {"rate": 0.0}, {"rate": float("nan")}, {"rate": 1e-300},
        {"timeout": float("inf")}, {"timeout": 0.0}, {"timeout": float("nan")},
    ],
)  # fmt: skip
def test_a_rate_and_a_timeout_are_finite_and_positive(option):
    with pytest.raises(InputError, match=f"{next(iter(option))} must be a finite number >"):
        open_source("x", **option)


@pytest.mark.parametrize("number", ["99999999999999999999", "camera:" + "9" * 5000, "2147483648"])
def test_a_number_that_no_camera_has_is_refused(number):
    with pytest.raises(SourceError, match="at most 9 digits"):
        open_source(number)


def test_a_folder_that_is_named_by_digits_is_found_by_the_message(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "20231114").mkdir()
    with pytest.raises(SourceError, match=r"A file or folder of that name is \./20231114"):
        open_source("20231114")


def test_if_one_of_several_cannot_be_opened_the_others_are_closed(tmp_path, monkeypatch):
    closed = []
    (tmp_path / "a.png").write_bytes(png(picture(5)))
    monkeypatch.setattr("convexperc.inputs.stored.Still.close", lambda self: closed.append(self.text))
    with pytest.raises(SourceError):
        open_sources({"a": str(tmp_path / "a.png"), "b": str(tmp_path / "absent")})
    assert closed == [str(tmp_path / "a.png")]


def test_the_grammar_names_every_scheme_and_kind_of_bag():
    text = " ".join(f"{form} {what}" for form, what in GRAMMAR)
    for word in ("rtsp", "rtsps", "http", "https", "rtmp", "udp", ".mcap", ".db3", ".bag", "camera:"):
        assert word in text, word


def write_video(path, count=12, rate=10.0, size=(48, 64), code="MJPG"):
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*code), rate, size[::-1])
    if not writer.isOpened():
        pytest.skip(f"this OpenCV does not write {code}")
    for number in range(count):
        writer.write(np.full((*size, 3), (30, 20 * number, 200), dtype=np.uint8))  # B, G, R
    writer.release()
    return path


@pytest.mark.parametrize(("name", "code"), [("v.avi", "MJPG"), ("v.mp4", "mp4v")])
def test_a_video_has_the_times_and_colours_of_its_frames(tmp_path, name, code):
    source = open_source(str(write_video(tmp_path / name, code=code)))
    found = list(source)
    np.testing.assert_allclose([frame.time for frame in found], np.arange(12) / 10, atol=1e-6)
    for number, frame in enumerate(found):
        assert frame.picture.shape == (48, 64, 3)
        np.testing.assert_allclose(frame.picture.mean(axis=(0, 1)), (200, 20 * number, 30), atol=6)
    assert source.remarks == ()
    assert len(list(source)) == 12


def test_a_video_that_is_cut_says_so(tmp_path):
    path = write_video(tmp_path / "v.avi", count=60)
    data = path.read_bytes()
    path.write_bytes(data[: len(data) // 2])
    try:
        source = open_source(str(path))
    except SourceError as error:
        assert "OpenCV can read" in str(error)  # noqa: PT017 - either is right, silence is not
        return
    assert len(list(source)) < 60
    assert any("ends after" in line for line in source.remarks)


def test_a_video_without_time_stamps_has_times_by_its_rate_and_says_so(tmp_path, monkeypatch):
    class Without:
        """A video of three frames, of which all have the time 0."""

        def __init__(self, *_):
            self.left = 3

        def isOpened(self):  # noqa: N802 - OpenCV's name
            return True

        def get(self, what):
            return {cv2.CAP_PROP_FPS: 20.0, cv2.CAP_PROP_FRAME_COUNT: 3.0}.get(what, 0.0)

        def read(self):
            self.left -= 1
            return self.left >= 0, picture(1)

        def release(self):
            pass

    monkeypatch.setattr("convexperc.inputs.stored.capture_of", Without)
    (tmp_path / "v.avi").write_bytes(b"x")
    source = open_source(str(tmp_path / "v.avi"))
    assert [frame.time for frame in source] == pytest.approx([0.0, 0.05, 0.1])
    assert source.remarks == ("time stamps do not increase: such frames follow at 20 frames a second",)


def test_what_is_no_video_is_refused_without_noise(tmp_path):
    for name in ("a.mp4", "a.avi", "a.mkv"):
        (tmp_path / name).write_bytes(b"\0\0\0\x18ftypisom\0\0\2\0isomiso2" + b"no video " * 300)
    code = """if True:
        import sys
        from convexperc.inputs import open_source
        from convexperc.errors import SourceError
        for path in sys.argv[1:]:
            try:
                list(open_source(path))
            except SourceError as error:
                print(error)
    """
    done = subprocess.run(
        [sys.executable, "-c", code, *(str(tmp_path / name) for name in ("a.mp4", "a.avi", "a.mkv"))],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("OpenCV can") == 3, done.stdout
    assert len(done.stdout.splitlines()) == 3, done.stdout
    assert done.stderr == ""


def test_a_jpeg_sequence_keeps_its_colours(tmp_path):
    (tmp_path / "1.jpg").write_bytes(jpeg(np.full((48, 64, 3), (200, 90, 30), dtype=np.uint8)))
    (frame,) = open_source(f"{tmp_path}/*.jpg")
    np.testing.assert_allclose(frame.picture.mean(axis=(0, 1)), (200, 90, 30), atol=3)
