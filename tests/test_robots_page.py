"""The page "On your robots": its node runs as it stands there, and its tables say what the program says."""

import array
import math
import re
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
import ros_stub
from made_up_robots import write_references

from convexperc import FeatureConfiguration, References, perceive
from convexperc.cli.main import app
from convexperc.cli.stream_options import RATE, SLOP
from convexperc.files import json_bytes
from convexperc.inputs import GRAMMAR, Hypothesis
from convexperc.recognition import Calibration, read_calibration, read_references, sample_scene
from convexperc.report import recognition_line

PAGE = (Path(__file__).parent.parent / "docs" / "robots.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
LAMBDAS = {"lambda1": 0.1, "lambda2": 1.0, "lambda3": 0.1}
NOW = 1_700_000_000 * 10**9
SEES = {"husky1": "robot-3", "husky2": "robot-4", "spot": "robot-1"}
"""Which of the sample's robots each is."""


def code(word: str) -> str:
    """The only example with this word."""
    (found,) = (block for block in BLOCKS if word in block)
    return found


def stored(robot: str, scene: str = "ica-sign") -> bytes:
    """What a robot sees, as JPEG."""
    done, data = cv2.imencode(".jpg", sample_scene(scene).views[SEES[robot]][..., ::-1])
    assert done
    return data.tobytes()


def message(data: bytes, nanoseconds: int) -> ros_stub.CompressedImage:
    seconds, rest = divmod(nanoseconds, 10**9)
    header = ros_stub.Header(stamp=ros_stub.Stamp(sec=seconds, nanosec=rest))
    return ros_stub.CompressedImage(
        header=header, format="bgr8; jpeg compressed bgr8", data=array.array("B", data)
    )


def topic(robot: str) -> str:
    return f"/{robot}/camera/image/compressed"


@pytest.fixture
def world(tmp_path, monkeypatch):
    """The node of the page, spinning; yields what drives it."""
    References.of(read_references(write_references(tmp_path / "known")), FeatureConfiguration()).save(
        tmp_path / "known.safetensors"
    )
    monkeypatch.chdir(tmp_path)
    write_thresholds()
    with ros_stub.installed() as driven:
        driven.now = NOW
        names: dict[str, object] = {}
        exec(compile(code("rclpy"), "docs/robots.md", "exec"), names)
        names["main"]()
        assert len(driven.nodes) == 1
        assert [period for period, _ in driven.timers] == [0.1]
        assert list(driven.callbacks) == list(map(topic, SEES))
        yield driven


def write_thresholds(**limits: float) -> None:
    """Thresholds by the scene that the node sees, wide enough for fewer robots, or other ones."""
    labelled = [(wanted(*robots), "ica-sign") for robots in (SEES, *((robot,) for robot in SEES))] * 10
    made = replace(Calibration.of(labelled, 0.9), **limits)
    Path("thresholds.json").write_bytes(json_bytes(made.to_dict()))


def logged(accepted: str, *robots: str) -> tuple[str, str]:
    """What the node logs."""
    return "info", f"{accepted}; proved: lowest optimum, ('ica-sign',); {robots}"


RECOGNISED = "recognised ('ica-sign',)"


def wanted(*robots: str):
    """What the library says of these robots' frames."""
    views = {
        robot: cv2.imdecode(np.frombuffer(stored(robot), np.uint8), cv2.IMREAD_COLOR)[..., ::-1]
        for robot in robots
    }
    return perceive(views, References.load("known.safetensors"), prune=False, **LAMBDAS)


def test_the_node_publishes_what_the_library_says(world):
    for robot in SEES:
        world.deliver(topic(robot), message(stored(robot), NOW - 50_000_000))
    world.tick()
    ((place, said),) = world.published
    assert place == "object"
    assert (said.header.stamp.sec, said.header.stamp.nanosec) == divmod(NOW, 10**9)
    ((name, score),) = [(each.class_id, each.score) for each in said.results]
    found = wanted(*SEES)
    best = found.template()
    assert (name, found.label) == ("ica-sign", "ica-sign")
    most = found.unexplained[1][best.index]
    assert score == pytest.approx(Hypothesis(name, *best.interval, float(most)).score, rel=1e-6)
    assert world.logged == [logged(RECOGNISED, *SEES)]


@pytest.mark.parametrize(
    ("limits", "verdict", "count"),
    [({"share": 0.0}, "unknown", 0), ({"share": 1.0, "excess": math.inf}, "ambiguous", 3)],
)
def test_the_node_publishes_what_the_thresholds_accept(world, limits, verdict, count):
    write_thresholds(**limits)
    world.nodes[0].thresholds = read_calibration("thresholds.json")
    for robot in SEES:
        world.deliver(topic(robot), message(stored(robot), NOW))
    world.tick()
    ((_, said),) = world.published
    assert len(said.results) == count
    assert said.results == [] or said.results[0].class_id == "ica-sign"
    ((_, text),) = world.logged
    assert text.startswith(f"{verdict} (")
    assert "; proved: lowest optimum, ('ica-sign',); " in text


def test_the_node_goes_on_without_a_robot_that_is_late_broken_or_silent(world):
    frames = {robot: stored(robot) for robot in SEES}
    world.tick()
    (level, text), *rest = world.logged
    assert (level, rest, world.published) == ("warning", [], [])
    assert "the frame of one robot" in text
    for robot in ("husky1", "husky2"):
        world.deliver(topic(robot), message(frames[robot], NOW))
    world.tick()
    assert world.logged[-1] == logged(RECOGNISED, "husky1", "husky2")
    world.deliver(topic("spot"), message(frames["spot"][:500], NOW))
    world.tick()
    assert world.logged[-2][0] == "warning"
    assert world.logged[-2][1].startswith("spot must be complete")
    assert world.logged[-1] == logged(RECOGNISED, "husky1", "husky2")
    world.deliver(topic("spot"), message(frames["spot"], NOW))
    world.now = NOW + 150_000_000
    world.tick()
    assert world.logged[-1] == logged(RECOGNISED, *SEES)
    world.now = NOW + 250_000_000
    world.deliver(topic("husky1"), message(frames["husky1"], world.now))
    world.deliver(topic("spot"), message(frames["spot"], world.now + 10**9))
    world.tick()
    assert world.logged[-1] == logged(RECOGNISED, "husky1")
    assert len(world.published) == 4


def test_the_stub_refuses_what_ros_refuses():
    with pytest.raises(AssertionError, match="has no field"):
        ros_stub.Classification().label = "cup"
    with pytest.raises(AssertionError, match="invalid arguments"):
        ros_stub.ObjectHypothesis(id="cup")
    with pytest.raises(AssertionError, match="score must be float"):
        ros_stub.ObjectHypothesis(class_id="cup", score=1)
    with ros_stub.installed() as world:
        with pytest.raises(AssertionError, match=r"init\(\) comes first"):
            ros_stub.Node("node")
        world.initialised = True
        with pytest.raises(TypeError):
            ros_stub.Node("node").create_subscription(ros_stub.Image, "x", lambda: None, 10)
        with pytest.raises(TypeError, match="two clocks"):
            ros_stub.Clock().now() - ros_stub.Time(nanoseconds=1)


def test_the_example_of_frames_runs(capsys):
    exec(compile(code("sample_scene"), "docs/robots.md", "exec"), {})
    said = capsys.readouterr().out
    wanted = "('robot-1', 'robot-3', 'robot-4', 'robot-5')"
    assert said == f"ica-sign {wanted} robot 'robot-2' is left out: it has no usable frame\n"


def rows(heading: str) -> dict[str, str]:
    """A table by its first column."""
    part = PAGE.split(f"| {heading} |")[1].split("\n\n")[0]
    return dict(re.findall(r"^\| (.+?) \| (.+) \|$", part, re.MULTILINE)[0:])


def test_the_sources_of_the_page_are_those_that_are_read():
    found = {name.strip("`"): text for name, text in rows("source").items() if name.startswith("`")}
    assert found == dict(GRAMMAR)


def test_the_options_of_the_page_are_those_of_the_command():
    names = {name.strip("`").split()[0] for name in rows("option") if name.startswith("`")}
    (command,) = (each for each in app.registered_groups[0].typer_instance.registered_commands
                  if each.callback.__name__ == "recognize")  # fmt: skip
    parameters = {
        "region": "--region", "mask": "--mask", "slop": "--slop", "every": "--every", "rate": "--rate",
        "strict": "--strict", "jsonl": "--jsonl", "results": "--results", "watch": "--watch",
    }  # fmt: skip
    assert set(parameters) <= set(command.callback.__wrapped__.__annotations__)
    assert names == set(parameters.values())
    assert f"({SLOP} s)" in rows("option")["`--slop SECONDS`"]
    assert f"({RATE:g})" in rows("option")["`--rate HZ`"]


def test_the_keys_of_the_page_are_those_of_a_line():
    named = [key for name in rows("key") for key in re.findall(r"`(\w+)`", name)]
    assert sorted(named) == sorted(recognition_line(0.0, 0, {}, {}, None))


def test_the_picture_of_the_live_view_is_small_and_shows_the_run():
    drawn = (Path(__file__).parent.parent / "docs" / "live.svg").read_text(encoding="utf-8")
    assert len(drawn) < 200_000
    for text in ("ica-sign", "gray-car", "husky-1", "husky-2", "spot", "missing", "proved"):
        assert text in drawn, text
    assert "@font-face" not in drawn
    assert "/tmp" not in drawn
