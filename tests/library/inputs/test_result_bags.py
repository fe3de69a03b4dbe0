"""Results in a bag, read back by `rosbags` with the definitions in the bag itself."""

import json
import math
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from convexperc.errors import InputError
from convexperc.inputs import Hypothesis, ResultBag
from convexperc.inputs.results import CLASSIFICATION, HYPOTHESIS

pytest.importorskip("rosbags", reason="the extra ros is not installed")

FOUND = [
    Hypothesis("car", 0.30, 0.31, 0.31),
    Hypothesis("sign", 0.10, 0.125, 0.0625),
    Hypothesis("dog", 1.0, 1.0 + 1e-12, 1.0),
]
NOW = 1_700_000_000_123_456_789


def read(path):
    """The messages of each topic, parsed by what the bag says of itself."""
    from rosbags.highlevel import AnyReader  # noqa: PLC0415 - an extra

    with AnyReader([path]) as reader:
        found = {}
        for connection, recorded, data in reader.messages():
            message = reader.deserialize(data, connection.msgtype)
            found.setdefault((connection.topic, connection.msgtype), []).append((recorded, message))
        return found, reader.typestore


@pytest.mark.parametrize("name", ["out.mcap", "out.db3", "out"])
def test_a_bag_is_read_back(tmp_path, name):
    path = tmp_path / name
    with ResultBag(path, frame_id="map") as bag:
        bag.write(NOW, FOUND, {"verdict": "proved", "missing": {"Carol": "ε"}})
        bag.write(NOW + 10**9, [])
    assert path.is_file() == (name != "out")
    assert [each.name for each in tmp_path.iterdir()] == [name]
    found, store = read(path)
    assert set(found) == {
        ("/convexperc/classification", "vision_msgs/msg/Classification"),
        ("/convexperc/intervals", "std_msgs/msg/String"),
    }
    (first, message), (second, empty) = found["/convexperc/classification", "vision_msgs/msg/Classification"]
    assert (first, second) == (NOW, NOW + 10**9)
    stamp = message.header.stamp
    assert (stamp.sec * 10**9 + stamp.nanosec, message.header.frame_id) == (NOW, "map")
    assert [each.class_id for each in message.results] == ["sign", "car", "dog"]
    scores = [each.score for each in message.results]
    assert scores == sorted(scores, reverse=True)
    assert scores == pytest.approx([0.9375, 0.69, 0.0])
    assert not empty.results
    (_, text), _ = found["/convexperc/intervals", "std_msgs/msg/String"]
    record = json.loads(text.data)
    assert record["schema"] == "convexperc/intervals/1"
    assert record["nanoseconds"] == NOW
    assert record["objects"][0] == {"class_id": "sign", "lower": 0.1, "upper": 0.125, "unexplained": 0.0625}
    assert record["details"] == {"verdict": "proved", "missing": {"Carol": "ε"}}
    # As vision_msgs has them since Humble, in this order, on which the bytes depend.
    names = {kind: [field for field, _ in store.fielddefs[kind][1]] for kind in (CLASSIFICATION, HYPOTHESIS)}
    assert names == {CLASSIFICATION: ["header", "results"], HYPOTHESIS: ["class_id", "score"]}


@given(st.one_of(st.floats(0, 2), st.floats(0.5, 1.0)))
def test_the_score_is_a_lower_bound_of_the_explained_fraction(unexplained):
    score = Hypothesis("x", 0.0, 1.0, unexplained).score
    exact = 1 - Fraction(unexplained)
    assert 0 <= score <= 1
    assert Fraction(score) <= max(exact, 0)
    assert float(exact) - score <= 1e-15 or score == 0


@pytest.mark.parametrize(
    "numbers",
    [(0.2, 0.1, 1.0), (0.0, math.inf, 1.0), (0.0, 0.1, math.nan), (math.nan, 0.1, 1.0), (0.0, 0.1, -1.0)],
)
def test_numbers_that_prove_nothing_are_refused(numbers):
    with pytest.raises(InputError, match="finite lower <= upper"):
        Hypothesis("x", *numbers)


def test_a_time_that_no_header_holds_and_an_object_twice_are_refused(tmp_path):
    with ResultBag(tmp_path / "out") as bag:
        for time in (-1, 2**31 * 10**9):
            with pytest.raises(InputError, match="nanoseconds"):
                bag.write(time, FOUND)
        with pytest.raises(InputError, match="each object once"):
            bag.write(NOW, [*FOUND, FOUND[0]])
        bag.write(2**31 * 10**9 - 1, FOUND)


@pytest.mark.parametrize("name", ["out.mcap", "out"])
def test_after_an_error_nothing_is_left_behind(tmp_path, name):
    def fail():
        with ResultBag(tmp_path / name) as bag:
            bag.write(NOW, FOUND)
            raise RuntimeError("stop")

    with pytest.raises(RuntimeError, match="stop"):
        fail()
    assert not list(tmp_path.iterdir())


def test_a_file_is_replaced_and_kept_if_the_new_one_fails(tmp_path):
    path = tmp_path / "out.mcap"
    path.write_bytes(b"earlier")
    with pytest.raises(RuntimeError), ResultBag(path):
        raise RuntimeError
    assert path.read_bytes() == b"earlier"
    with ResultBag(path) as bag:
        bag.write(NOW, FOUND)
    assert len(read(path)[0]) == 2


def test_where_it_cannot_be_written_is_said_before_any_work(tmp_path):
    (tmp_path / "there").mkdir()
    for path in (tmp_path / "there", tmp_path / "absent" / "out.mcap", tmp_path / "absent" / "out"):
        with pytest.raises(InputError, match="output"):
            ResultBag(path)
