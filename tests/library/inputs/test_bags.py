"""Bags of several robots, written by `rosbags`, as sources."""

import sqlite3
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from made_sources import (
    ROBOTS,
    START,
    BagMaker,
    file_of,
    jpeg,
    number_of,
    picture,
    png,
    three_robots,
    topic_of,
)

from convexperc.errors import ImageError, SourceError
from convexperc.inputs import bags, moments, open_source, open_sources

pytest.importorskip("rosbags", reason="the extra ros is not installed")

FORMS = ["mcap", "mcap file", "db3", "db3 file", "ros1"]


def made(tmp_path, form, count=10):
    """A bag of three robots in one of the forms: its path, and the stamps of each robot."""
    path = tmp_path / ("run.bag" if form == "ros1" else "run")
    stamps = three_robots(path, form.removesuffix(" file"), count)
    return (file_of(path) if form.endswith("file") else path), stamps


def robots(path):
    return {robot: f"{path}#{topic_of(robot)}" for robot in ROBOTS}


@pytest.mark.parametrize("form", FORMS)
def test_each_topic_gives_its_pictures_and_stamps(tmp_path, form):
    path, stamps = made(tmp_path, form)
    for k, (robot, source) in enumerate(open_sources(robots(path)).items()):
        found = list(source)
        assert [frame.nanoseconds for frame in found] == stamps[robot]
        assert [frame.time for frame in found] == [stamp / 10**9 for stamp in stamps[robot]]
        step = 2 if robot == "Carol" else 1
        assert [number_of(frame.picture) for frame in found] == list(range(1000 * k, 1000 * k + 10, step))
        assert source.remarks == ()


@pytest.mark.parametrize("form", FORMS)
def test_robots_are_joined_by_their_stamps(tmp_path, form):
    path, stamps = made(tmp_path, form)
    found = list(moments(open_sources(robots(path)), slop=0.03))
    assert [m.nanoseconds for m in found] == stamps["Alpha"]
    for k, moment in enumerate(found):
        numbers = {robot: number_of(view) for robot, view in moment.views.items()}
        expected = {"Alpha": k, "Bob": 1000 + k} | ({"Carol": 2000 + k} if k % 2 == 0 else {})
        assert numbers == expected
        assert set(moment.missing) == (set() if k % 2 == 0 else {"Carol"})


def test_topics_of_one_bag_are_read_in_one_pass(tmp_path, monkeypatch):
    path, _ = made(tmp_path, "mcap")
    opened = []
    plain = bags.Reading.open
    monkeypatch.setattr(bags.Reading, "open", lambda self: opened.append(self) or plain(self))
    sources = open_sources(robots(path))
    assert len(opened) == 1
    assert len(list(moments(sources, slop=0.03))) == 10
    assert len(opened) == 2
    assert len(list(sources["Alpha"])) == 10  # once more, from the beginning
    assert len(opened) == 3


def test_one_topic_alone_holds_nothing_of_the_others(tmp_path, monkeypatch):
    path, _ = made(tmp_path, "mcap")
    monkeypatch.setattr(bags, "HELD_BYTES", 100)
    sources = open_sources(robots(path))
    assert [number_of(frame.picture) for frame in sources["Bob"]] == list(range(1000, 1010))
    iterator = iter(sources["Alpha"])
    assert number_of(next(iterator).picture) == 0
    assert [number_of(frame.picture) for frame in sources["Bob"]] == list(range(1000, 1010))
    assert [number_of(frame.picture) for frame in iterator] == list(range(1, 10))


def test_a_topic_that_is_closed_before_it_is_read_holds_nothing(tmp_path, monkeypatch):
    path, _ = made(tmp_path, "mcap")
    monkeypatch.setattr(bags, "HELD_BYTES", 100)
    sources = open_sources(robots(path))
    with sources["Alpha"] as closed:
        iter(closed)
        bob = iter(sources["Bob"])
    assert [number_of(frame.picture) for frame in bob] == list(range(1000, 1010))


def test_a_topic_that_falls_silent_holds_up_nothing(tmp_path, monkeypatch):
    """Alpha sends at the beginning and at the end; what Bob sends between is not kept until then."""
    path, data = tmp_path / "run", png(picture(1))
    with BagMaker(path) as bag:
        for k in range(2000):
            stamp = START + k * 10**8
            if k < 5 or k >= 1995:
                bag.compressed("/Alpha/c", stamp, data, recorded=stamp + 10**7)
            bag.compressed("/Bob/c", stamp, data, recorded=stamp + 10**7 + 1)
    monkeypatch.setattr(bags, "HELD_BYTES", 20 * len(data))
    most, plain = [], bags.Pass.next

    def watched(self, topic):
        most.append(self._held)
        return plain(self, topic)

    monkeypatch.setattr(bags.Pass, "next", watched)
    found = list(moments(open_sources({"a": f"{path}#/Alpha/c", "b": f"{path}#/Bob/c"}), slop=0.02))
    assert [set(m.views) for m in found] == [{"a", "b"} if k < 5 or k >= 1995 else {"b"} for k in range(2000)]
    assert max(most) < 3 * 20 * len(data)


def test_clocks_that_are_too_far_apart_to_wait_for_are_an_error(tmp_path, monkeypatch):
    path, data = tmp_path / "run", png(picture(1))
    with BagMaker(path) as bag:
        for k in range(1000):
            recorded = START + k * 10**8
            bag.compressed("/Alpha/c", recorded, data, recorded=recorded)
            bag.compressed("/Bob/c", recorded + 10**12, data, recorded=recorded + 1)
    monkeypatch.setattr(bags, "HELD_BYTES", 20 * len(data))
    texts = {"a": f"{path}#/Alpha/c", "b": f"{path}#/Bob/c"}
    found = moments(open_sources(texts), slop=0.02)
    assert not any(len(m.views) == 2 for m in found)
    assert "Set right the clock" in found.counts["a"].ended
    with pytest.raises(SourceError, match="no picture within"):
        list(moments(open_sources(texts), slop=0.02, strict=True))


def test_frames_without_a_stamp_have_the_time_of_the_recording_and_it_is_said(tmp_path):
    path = tmp_path / "run"
    with BagMaker(path) as bag:
        for k in range(4):
            stamp = (0, -(10**9))[k // 2] if k % 2 else START + k * 10**9
            bag.compressed("/a", stamp, png(picture(k)), recorded=START + k * 10**9 + 5)
    source = open_source(f"{path}#/a")
    assert [frame.nanoseconds - START for frame in source] == [0, 10**9 + 5, 2 * 10**9, 3 * 10**9 + 5]
    assert source.remarks == (
        "2 of 4 frames have no time stamp above 0: their time is that of the recording",
    )


@pytest.mark.parametrize("form", ["mcap", "ros1"])
def test_raw_images_are_read(tmp_path, form):
    path = tmp_path / ("run.bag" if form == "ros1" else "run")
    with BagMaker(path) as bag:
        kind = bag.types["sensor_msgs/msg/Image"]
        pixels = picture(300)[..., ::-1]
        rows = np.pad(pixels.reshape(12, -1), ((0, 0), (0, 7)))
        for encoding in ("bgr8", "8UC3", "32FC1"):
            image = kind(bag.header(START), 12, 16, encoding, 0, rows.shape[1], rows.reshape(-1))
            bag.put("/a", image, START)
    source = open_source(f"{path}#/a")
    found = list(source)
    assert [number_of(frame.picture) for frame in found[:2]] == [300, 300]
    assert "32FC1" in found[2].reason
    assert "message 3" in found[2].reason
    assert source.remarks == ("encoding 8UC3 does not name its channels: they are taken for B, G, R",)


def test_broken_pictures_leave_their_robot_out_by_name(tmp_path):
    path = tmp_path / "run"
    with BagMaker(path) as bag:
        whole = jpeg(picture(5, (48, 64)))
        for k, data in enumerate([whole, whole[:200], b"", whole]):
            bag.compressed("/a", START + k * 10**9, data, stated="rgb8; jpeg compressed bgr8")
    found = moments({"a": open_source(f"{path}#/a")}, slop=0.1)
    assert [bool(m.views) for m in found] == [True, False, False, True]
    assert found.counts["a"].unreadable == 2


def test_bytes_that_are_no_message_are_a_frame_without_a_picture(tmp_path):
    path = tmp_path / "run"
    with BagMaker(path) as bag:
        bag.compressed("/a", START, png(picture(1)))
        bag.writer.write(bag.connections["/a"], START + 1, b"\0\1\0\0garbage")
        bag.compressed("/a", START + 2, png(picture(2)))
    found = list(open_source(f"{path}#/a"))
    assert [frame.picture is not None for frame in found] == [True, False, True]
    assert "sensor_msgs/msg/CompressedImage" in found[1].reason


@pytest.mark.parametrize("form", FORMS)
def test_a_topic_that_is_not_there_is_refused_with_those_that_are(tmp_path, form):
    path, _ = made(tmp_path, form, count=2)
    with pytest.raises(SourceError) as caught:
        open_source(f"{path}#/Dave/left_camera/compressed")
    for robot in ROBOTS:
        assert topic_of(robot) in str(caught.value)
    assert "1 others have none" in str(caught.value)
    with pytest.raises(SourceError, match="CompressedImage; those with pictures are /Alpha"):
        open_source(f"{path}#/Alpha/note")
    with pytest.raises(SourceError, match=r"must be followed by a topic.*/Bob/left_camera/compressed"):
        open_source(str(path))


@pytest.mark.parametrize("form", ["mcap file", "db3 file", "ros1"])
@pytest.mark.parametrize("share", [0.0, 0.01, 0.5, 0.99])
def test_a_truncated_bag_is_an_error_or_breaks_off_by_name(tmp_path, form, share):
    path, _ = made(tmp_path, form, count=200)
    data = path.read_bytes()
    path.write_bytes(data[: int(share * len(data))])
    try:
        found = moments(open_sources(robots(path)), slop=0.03)
        count = len(list(found))
    except SourceError:
        return
    assert count < 200
    assert any("broke off" in line for line in found.remarks)


@pytest.fixture(scope="module")
def sound(tmp_path_factory):
    """The bytes of a bag in each form, by its suffix, and where to write damaged ones."""
    folder = tmp_path_factory.mktemp("sound")
    three_robots(folder / "run.bag", count=20)
    found = {".bag": (folder / "run.bag").read_bytes()}
    for storage in ("mcap", "db3"):
        three_robots(folder / storage, storage, count=20)
        found[f".{storage}"] = file_of(folder / storage).read_bytes()
    return folder, found


@settings(max_examples=60)
@given(st.sampled_from([".bag", ".mcap", ".db3"]), st.data())
def test_damage_anywhere_gives_moments_or_an_error_of_ours(sound, suffix, data):
    folder, whole = sound
    content = bytearray(whole[suffix])
    place = data.draw(st.integers(0, len(content) - 1))
    if data.draw(st.booleans()):
        content[place : place + data.draw(st.sampled_from([1, 8, 200]))] = b""
    else:
        content[place] ^= data.draw(st.integers(1, 255))
    path = folder / f"damaged{suffix}"
    path.write_bytes(content)
    try:
        for moment in moments(open_sources(robots(path)), slop=0.03):
            assert set(moment.views) | set(moment.missing) == set(ROBOTS)
    except (SourceError, ImageError):
        pass


def test_a_length_beyond_all_memory_is_damage(tmp_path):
    """That of the first record of the summary, in the eight bytes after its opcode."""
    path, _ = made(tmp_path, "mcap file")
    data = bytearray(path.read_bytes())
    summary = int.from_bytes(data[-28:-20], "little")
    data[summary + 1 : summary + 9] = (2**62).to_bytes(8, "little")
    path.write_bytes(data)
    with pytest.raises(SourceError, match="undamaged"):
        open_source(f"{path}#{topic_of('Alpha')}")


def test_damage_in_the_middle_is_named_and_strict_raises(tmp_path):
    path, _ = made(tmp_path, "mcap file", count=300)
    data = bytearray(path.read_bytes())
    middle = len(data) // 2
    data[middle : middle + 4096] = bytes(4096)
    path.write_bytes(data)
    found = moments(open_sources({"Alpha": robots(path)["Alpha"]}), slop=0.0)
    count = len(list(found))
    assert 0 < count < 300
    assert "broke off" in "".join(found.remarks)
    with pytest.raises((SourceError, ImageError)):
        list(moments(open_sources({"Alpha": robots(path)["Alpha"]}), slop=0.0, strict=True))


def test_an_old_bag_without_definitions_is_read(tmp_path):
    """Those of ROS 2 before Iron: SQLite, without the table of the messages' definitions."""
    path, stamps = made(tmp_path, "db3 file")
    with sqlite3.connect(path) as database:
        database.execute("DROP TABLE message_definitions")
        database.execute("UPDATE schema SET schema_version = 3")
    database.close()
    found = list(open_source(f"{path}#{topic_of('Bob')}"))
    assert [frame.nanoseconds for frame in found] == stamps["Bob"]


@pytest.mark.parametrize(("name", "storage"), [("run", "mcap"), ("run", "db3"), ("run.bag", "")])
def test_a_compressed_bag_is_read(tmp_path, name, storage):
    with BagMaker(tmp_path / name, storage, compress=True) as bag:
        bag.compressed("/a", START, png(picture(9)))
    (frame,) = open_source(f"{tmp_path / name}#/a")
    assert number_of(frame.picture) == 9


@pytest.mark.parametrize("form", ["mcap", "db3", "ros1"])
def test_a_suffix_in_upper_case_is_read_or_refused_for_what_it_is(tmp_path, form):
    path, _ = made(tmp_path, "ros1" if form == "ros1" else f"{form} file")
    upper = path.rename(path.with_suffix(path.suffix.upper()))
    text = f"{upper}#{topic_of('Bob')}"
    if form == "ros1":
        assert len(list(open_source(text))) == 10
        return
    with pytest.raises(SourceError, match=rf"must end in \.{form}, in lower case.*Rename it"):
        open_source(text)


def test_two_robots_may_have_the_same_topic(tmp_path):
    path, _ = made(tmp_path, "mcap")
    topic = f"{path}#{topic_of('Alpha')}"
    found = list(moments(open_sources({"a": topic, "b": topic}), slop=0.0, strict=True))
    assert [[number_of(view) for view in m.views.values()] for m in found] == [[k, k] for k in range(10)]


def test_without_the_extra_it_is_named(tmp_path):
    path, _ = made(tmp_path, "mcap", count=2)
    code = f"""if True:
        import sys
        from importlib.machinery import PathFinder
        find = PathFinder.find_spec
        PathFinder.find_spec = lambda name, *a, **k: None if name == "rosbags" else find(name, *a, **k)
        from convexperc.errors import MissingExtraError
        from convexperc.inputs import open_source, ResultBag
        for call in (lambda: open_source({str(path)!r} + "#/a"), lambda: ResultBag("out.mcap")):
            try:
                call()
            except MissingExtraError as error:
                print(error)
    """
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.stdout.count("pip install 'convexperc[ros]'") == 2, (done.stdout, done.stderr)
