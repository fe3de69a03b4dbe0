"""`recognize --view`: named sources, pictures and streams, and what is told of them."""

import json
import math
import os
import pty
import select
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import cv2
import made_up_robots as robots
import numpy as np
import pytest
from test_known_objects import QUICK, RUNNER, draw, expect, picture, world  # noqa: F401 - a fixture

import convexperc.cli.streams
from convexperc import FeatureConfiguration
from convexperc.cli.main import app
from convexperc.cli.streams import _Tally
from convexperc.cli.watching import Watch
from convexperc.files import json_bytes
from convexperc.recognition import Calibration, References, perceive, read_references, sample_scene
from convexperc.report import recognition_line

LAMBDAS = {"lambda1": 0.1, "lambda2": 1.0, "lambda3": 0.1}
KEYS = {
    "schema", "time", "nanoseconds", "decision", "verdict", "label", "certified", "acceptance", "candidates",
    "best", "optimum", "runner_up", "margin", "explained", "views", "missing", "ranked_views",
    "ranked_modalities", "rules", "reason", "warnings", "milliseconds",
}  # fmt: skip
"""Of every line."""
FRAMES = 6


@pytest.fixture(scope="module")
def run(world, tmp_path_factory):  # noqa: F811
    """Folders of pictures, by robot: all of them look at the can."""
    folder = tmp_path_factory.mktemp("run")
    for k in range(FRAMES):
        draw(folder / "husky-1" / f"{k:03}.png", 2, 10 * k)
        draw(folder / "husky-2" / f"{k:03}.png", 2, 10 * k + 1)
        draw(folder / "short" / f"{k:03}.png", 2, 10 * k + 2) if k < 3 else None
    draw(folder / "still.png", 2, 99)
    return folder


def given(world, run, *names):  # noqa: F811
    """The arguments up to the views."""
    known = ["--references", world / "known", "--configuration", world / "quick.json", "--rate", 10]
    return ["recognize", *known, *(part for robot in names for part in ("--view", f"{robot}={run / robot}"))]


def lines(text):
    """The lines of a stream, each of which is JSON of finite numbers with the same keys."""

    def refuse(constant):
        raise AssertionError(constant)

    found = [json.loads(line, parse_constant=refuse) for line in text.splitlines()]
    assert all(set(line) == KEYS for line in found), found
    return found


def test_a_stream_has_a_line_for_each_moment(world, run):  # noqa: F811
    done = expect(0, *given(world, run, "husky-1", "husky-2"))
    found = lines(done.stdout)
    assert [line["time"] for line in found] == pytest.approx([k / 10 for k in range(FRAMES)])
    assert [line["nanoseconds"] for line in found] == [k * 10**8 for k in range(FRAMES)]
    known = References.of(read_references(world / "known"), QUICK)
    for k, line in enumerate(found):
        seen = {f"husky-{1 + i}": picture(2, 10 * k + i)[..., ::-1] for i in range(2)}
        wanted = perceive(seen, known, prune=False, **LAMBDAS)
        assert (line["verdict"], line["label"], line["certified"]) == ("proved: lowest optimum", "can", True)
        lower, upper = wanted.template().interval
        assert line["optimum"]["lower"] <= upper
        assert lower <= line["optimum"]["upper"]
        assert line["best"] == wanted.template().name
        assert line["runner_up"] == wanted.runner_up
        assert line["margin"]["lower"] == pytest.approx(wanted.margin[0], rel=1e-6)
        assert line["margin"]["lower"] <= line["margin"]["upper"]
        assert list(line["views"]) == ["husky-1", "husky-2"]
        assert line["missing"] == {}
        ranked = {each["name"]: each for each in line["ranked_views"]}
        for each in wanted.ranked_views():
            assert ranked[each.name]["weight"] == pytest.approx(each.weight, abs=1e-4)
        assert sum(each["share"] for each in line["ranked_views"]) == pytest.approx(1.0)
        assert [each["name"] for each in line["ranked_modalities"]] == [
            each.name for each in wanted.ranked_modalities()
        ]
        assert line["rules"]["vote"] == wanted.rules.vote
        assert line["rules"]["disagreeing"] == list(wanted.rules.disagreeing)
        assert line["acceptance"] is None
        assert line["milliseconds"] > 0.0
    assert done.stderr.splitlines()[0] == f"{FRAMES} moments: the lowest optimum is proved in {FRAMES}"


def test_a_robot_that_ends_is_missing_by_name_and_said_once(world, run, tmp_path):  # noqa: F811
    out = tmp_path / "lines.jsonl"
    out.write_text("an earlier output\n")
    done = expect(0, *given(world, run, "husky-1", "short"), "--jsonl", out)
    found = lines(out.read_text())
    assert done.stdout == ""
    assert [list(line["views"]) for line in found] == [["husky-1", "short"]] * 3 + [["husky-1"]] * 3
    assert [list(line["missing"]) for line in found] == [[]] * 3 + [["short"]] * 3
    assert all(line["label"] == "can" for line in found)
    (said,) = (line for line in done.stderr.splitlines() if line.startswith("short: missing"))
    assert said.startswith(
        "short: missing in 3 of 6 moments; last: no picture within 0.05 s: the nearest is "
    )


def test_strict_ends_at_a_missing_picture(world, run, tmp_path):  # noqa: F811
    done = expect(2, *given(world, run, "husky-1", "short"), "--strict")
    assert "short" in done.output
    assert len(lines(done.stdout)) == 3


def test_each_moment_starts_from_the_one_before(world, run, monkeypatch):  # noqa: F811
    starts = []

    def perceived(views, known, *, start, **options):
        starts.append((start, known))
        return perceive(views, known, start=start, **options)

    monkeypatch.setattr(convexperc.recognition, "perceive", perceived)
    expect(0, *given(world, run, "husky-1"))
    assert starts[0][0] is None
    assert all(start is not None for start, _ in starts[1:])
    assert len({id(known) for _, known in starts}) == 1


@pytest.fixture(scope="module")
def thresholds(world):  # noqa: F811
    out = world / "stream-thresholds.json"
    scenes = ["--scenes", world / "scenes", "--coverage", 0.8, "--out", out]
    expect(0, "calibrate", "--references", world / "known", "--configuration", world / "quick.json", *scenes)
    return out


def test_the_exit_status_of_a_stream(world, run, thresholds, tmp_path):  # noqa: F811
    """Three robots, as in the scenes that set the thresholds."""

    def three(name, places):
        """A robot's frames, one a moment, each of the object of this place."""
        for robot in range(3):
            for k, place in enumerate(places):
                draw(tmp_path / name / f"robot-{robot}" / f"{k}.png", place, 100 + 10 * k + robot)
        folders = sorted((tmp_path / name).iterdir())
        return [*given(world, run), *(part for each in folders for part in ("--view", f"{each.name}={each}"))]

    judge = ["--calibration", thresholds]
    good = expect(0, *three("good", (2, 2, 2)), *judge)
    accepted = {"verdict": "recognised", "accepted": ["can"], "reason": "it alone is accepted"}
    assert [line["acceptance"] for line in lines(good.stdout)] == [accepted] * 3
    part = expect(1, *three("part", (2, 3, 2)), *judge)
    assert [line["acceptance"]["verdict"] for line in lines(part.stdout)] == [
        "recognised",
        "unknown",
        "recognised",
    ]
    said = "3 moments: the lowest optimum is proved in 3, and accepted by the calibration in 2 of these"
    assert part.stderr.splitlines()[0] == said
    expect(0, *three("part", (2, 3, 2)))
    draw(tmp_path / "known" / "can.png", 2, 0)
    draw(tmp_path / "known" / "copy.png", 2, 0)
    twins = ["recognize", "--references", tmp_path / "known", "--configuration", world / "quick.json"]
    tied = expect(1, *twins, "--view", f"a={run / 'husky-1'}")
    assert {(line["verdict"], line["label"]) for line in lines(tied.stdout)} == {("tie", None)}
    assert f"{FRAMES} moments: the lowest optimum is proved in 0" in tied.stderr


def test_reasons_are_counted_by_kind():
    tally = _Tally()
    line = {"verdict": "undecided", "label": None, "certified": True, "acceptance": None}
    near = "no picture within 0.05 s: the nearest is {} s later"
    for reason in (near.format("0.06"), "broken", near.format("1e-05"), "broken", near.format("0.106")):
        tally.add(line | {"missing": {"a": reason}})
    _, said = tally.lines(0)
    assert said == f"a: missing in 5 of 5 moments; in 3 of these, last: {near.format('0.106')}"


def test_one_moment_is_no_moments():
    tally = _Tally()
    tally.add(
        {"verdict": None, "label": None, "certified": None, "acceptance": None, "missing": {"a": "dark"}}
    )
    assert tally.lines(1) == [
        "1 moment: the lowest optimum is proved in 0; no robot has a view in 1",
        "a: missing in 1 of 1 moment; dark",
    ]
    assert tally.lines(4)[0].endswith("; no robot has a view in 1, nor in 3 moments without a line")


def test_a_region_outside_of_the_first_picture_is_2(world, run):  # noqa: F811
    for name in ("husky-1", "still.png"):
        done = expect(2, *given(world, run), "--view", f"a={run / name}", "--region", "a=500,0,40,40")
        assert "robot 'a', its first picture: region" in done.stderr
        assert "got '500,0,40,40'" in done.stderr


def broken(folder, count):
    """Pictures that cannot be read."""
    for k in range(count):
        folder.mkdir(exist_ok=True)
        (folder / f"{k}.png").write_bytes(b"\x89PNG\r\n\x1a\n broken")
    return folder


def test_a_moment_without_a_picture_is_a_line_and_is_not_0(world, run, tmp_path):  # noqa: F811
    done = expect(1, *given(world, run), "--view", f"a={broken(tmp_path / 'broken', 3)}")
    found = lines(done.stdout)
    assert len(found) == 3
    for line in found:
        assert (line["verdict"], line["label"], line["optimum"], line["milliseconds"]) == (None,) * 4
        assert "checksum" in line["missing"]["a"] or "must be complete" in line["missing"]["a"]
        assert line["reason"] == "no robot has a view"
    assert "3 moments: the lowest optimum is proved in 0; no robot has a view in 3" in done.stderr
    assert done.stderr.count("no robot") + done.stderr.count("any robot") == 1, "said once"
    draw(tmp_path / "broken" / "9.png", 2, 0)
    some = expect(1, *given(world, run), "--view", f"a={tmp_path / 'broken'}")
    assert [line["label"] for line in lines(some.stdout)] == [None, None, None, "can"]


def test_no_moment_at_all_is_2(world, run, tmp_path, monkeypatch):  # noqa: F811
    class Nothing:
        remarks, empty = ("a: 0 frames",), 0

        def __enter__(self):
            return self

        def __exit__(self, *_):
            return None

        def __iter__(self):
            return iter(())

    monkeypatch.setattr(convexperc.cli.streams.inputs, "moments", lambda *_, **__: Nothing())
    out = tmp_path / "lines.jsonl"
    out.write_text("an earlier output\n")
    done = expect(2, *given(world, run, "husky-1"), "--jsonl", out)
    assert "at least one moment with a picture" in done.output
    assert out.read_text() == "an earlier output\n", "lost without a line in its place"


def test_pictures_alone_are_one_recognition(world, run, tmp_path):  # noqa: F811
    plain = world / "scenes" / "can" / "1"
    named = [part for k in range(3) for part in ("--view", f"robot-{k}={plain / f'robot-{k}.png'}")]
    for options, out in ((["--views", plain], "folder.json"), (named, "named.json")):
        done = expect(
            0, *given(world, run), *options, "--json", tmp_path / out, "--picture", tmp_path / "p.svg"
        )
        assert "Ranking by robot for can" in done.stdout
    records = [json.loads((tmp_path / name).read_text()) for name in ("folder.json", "named.json")]
    for record in records:
        record["solution"].pop("volatile")
    assert records[0] == records[1]
    both = expect(
        0,
        *given(world, run),
        "--views",
        plain,
        "--view",
        f"spot={run / 'still.png'}",
        "--json",
        tmp_path / "b.json",
    )
    assert json.loads((tmp_path / "b.json").read_text())["views"] == ["robot-0", "robot-1", "robot-2", "spot"]
    assert "4 named views" in both.stdout


def test_a_broken_picture_is_left_out_by_name_unless_strict(world, run, tmp_path):  # noqa: F811
    bad = broken(tmp_path / "bad", 1) / "0.png"
    named = ["--view", f"good={run / 'still.png'}", "--view", f"bad={bad}"]
    done = expect(0, *given(world, run), *named, "--json", tmp_path / "r.json")
    record = json.loads((tmp_path / "r.json").read_text())
    assert record["views"] == ["good"]
    assert record["warnings"] == ["robot 'bad' is left out: it has no usable frame"]
    assert [line.startswith("bad: left out; ") for line in done.stderr.splitlines()] == [True, False]
    assert "robot 'bad' is left out" in done.stdout
    expect(2, *given(world, run), *named, "--strict", "--json", tmp_path / "s.json")
    assert not (tmp_path / "s.json").exists()
    failed = expect(2, *given(world, run), "--view", f"bad={bad}")
    assert "at least one moment with a picture" in failed.output


def test_a_still_beside_a_stream_is_in_every_moment(world, run):  # noqa: F811
    done = expect(0, *given(world, run, "husky-1"), "--view", f"mast={run / 'still.png'}")
    assert [list(line["views"]) for line in lines(done.stdout)] == [["husky-1", "mast"]] * FRAMES


def test_regions_and_masks_select_what_is_described(world, run, tmp_path):  # noqa: F811
    framed = np.full((80, 100, 3), 255, np.uint8)
    framed[16:64, 30:78] = picture(2, 5)
    assert cv2.imwrite(str(tmp_path / "framed.png"), framed)
    mask = np.zeros((80, 100), np.uint8)
    mask[16:64, 30:78] = 255
    assert cv2.imwrite(str(tmp_path / "mask.png"), mask)
    assert cv2.imwrite(str(tmp_path / "plain.png"), picture(2, 5))
    bounds = []
    for name, more in (
        ("plain", []), ("framed", ["--region", "a=30,16,48,48"]),
        ("framed", ["--mask", f"a={tmp_path / 'mask.png'}"]), ("framed", []),
    ):  # fmt: skip
        out = tmp_path / "r.json"
        arguments = [*given(world, run), "--view", f"a={tmp_path / name}.png", *more, "--json", out]
        done = RUNNER.invoke(app, list(map(str, arguments)))
        assert done.exit_code in (0, 1), done.output
        bounds.append([each["lower"]["hex"] for each in json.loads(out.read_text())["templates"]])
    assert bounds[0] == bounds[1] == bounds[2] != bounds[3]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--view", "husky"], "give it as NAME="),
        (["--view", "=x"], "give it as NAME="),
        (["--view", "a={run}/husky-1", "--view", "a={run}/husky-2"], "give it once"),
        (["--view", "a={run}/nothing"], "source"),
        (["--view", "a={run}/husky-1", "--region", "b=0,0,9,9"], "no --view has that name"),
        (["--view", "a={run}/husky-1", "--region", "a=0,0,9"], "x,y,width,height"),
        (["--view", "a={run}/husky-1", "--mask", "a={run}/still.png", "--region", "a=0,0,9,9"],
         "there is a --mask"),
        (["--view", "a={run}/husky-1", "--json", "{out}/x.json"], "--json is for one recognition"),
        (["--view", "a={run}/husky-1", "--picture", "{out}/x.png"], "--picture is for one recognition"),
        (["--view", "a={run}/still.png", "--jsonl", "{out}/x.jsonl"], "--jsonl is for streams"),
        (["--view", "a={run}/still.png", "--watch"], "--watch is for streams"),
        (["--view", "a={run}/husky-1", "--jsonl", "{run}/husky-1/x.jsonl"],
         "must not lie in the folder of --view a"),
        (["--view", "a={run}/husky-1", "--jsonl", "{out}/none/x.jsonl"], "no such folder"),
        (["--view", "a={run}/husky-1", "--slop", "-1"], "slop"),
        (["--views", "{run}/husky-1", "--watch"], "--watch goes with --view"),
        (["--views", "{run}/husky-1", "--view", "000={run}/still.png"], "of --views has that name"),
        (["--sample", "--view", "a={run}/still.png"], "or --sample"),
    ],
)  # fmt: skip
def test_what_does_not_go_together_is_2_and_writes_nothing(world, run, tmp_path, arguments, said):  # noqa: F811
    shown = [each.format(run=run, out=tmp_path) for each in arguments]
    done = expect(2, *given(world, run), *shown)
    assert said in done.output
    assert list(tmp_path.iterdir()) == []
    assert len(list((run / "husky-1").iterdir())) == FRAMES


@pytest.mark.parametrize(
    ("source", "option", "out", "said"),
    [
        ("p/*.png", "--jsonl", "p/1.png", "another file than --view a"),
        ("p/**", "--jsonl", "p/deep/2.png", "another file than --view a"),
        ("links", "--jsonl", "p/1.png", "must not lie in the folder of --view a"),
        ("#.png", "--jsonl", "#.png", "another file than --view a"),
        ("a#b/run.mcap#/t", "--jsonl", "a#b/run.mcap", "another file than --view a"),
        ("a#b/run.mcap#/t", "--results", "a#b/run.mcap", "another file than --view a"),
        ("a#/b/run.mcap#/t", "--results", "a#/b/run.mcap", "another file than --view a"),
        ("p/*.png", "--results", "p", "neither contain --view a nor lie in it"),
    ],
)
def test_no_source_is_written_to(world, tmp_path, monkeypatch, source, option, out, said):  # noqa: F811
    """However it is named: by a pattern, by a link in its folder, or as a bag with a # in its path."""
    for name in ("p/1.png", "p/deep/2.png", "#.png"):
        draw(tmp_path / name, 2, 0)
    for name in ("a#b/run.mcap", "a#/b/run.mcap"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_bytes(b"no bag")
    (tmp_path / "links").mkdir()
    (tmp_path / "links" / "0.png").symlink_to(tmp_path / "p" / "1.png")
    monkeypatch.chdir(tmp_path)
    held = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    done = expect(2, *given(world, tmp_path), "--view", f"a={source}", option, out)
    assert said in done.output
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == held


def test_the_pictures_of_an_object_are_not_written_to(world, run):  # noqa: F811
    deep = next(path for path in (world / "known").rglob("*.png") if path.parent != world / "known")
    held = deep.read_bytes()
    done = expect(2, *given(world, run, "husky-1"), "--jsonl", deep)
    assert "--jsonl must not lie in the folder of --references, " in done.output
    assert deep.read_bytes() == held


def test_what_is_left_out_of_a_folder_is_said_once(world, run, tmp_path):  # noqa: F811
    for k in range(2):
        draw(tmp_path / "a" / f"{k}.png", 2, k)
    (tmp_path / "a" / "notes.txt").write_text("no picture")
    done = expect(0, *given(world, run), "--view", f"a={tmp_path / 'a'}")
    assert len([line for line in done.stderr.splitlines() if "notes.txt" in line]) == 1


def command(*arguments):
    return [sys.executable, "-m", "convexperc", *map(str, arguments)]


CHANGING = {"NO_COLOR", "FORCE_COLOR", "PYTHONUNBUFFERED"}
"""Variables that would hide what is tested."""


def environment(**more):
    plain = {name: value for name, value in os.environ.items() if name not in CHANGING}
    return plain | {"PYTHONPATH": str(Path(convexperc.__file__).parent.parent), "COLUMNS": "100"} | more


def test_watch_without_a_terminal_prints_lines_alone(world, run):  # noqa: F811
    """Even where something asks for colours."""
    done = subprocess.run(
        command(*given(world, run, "husky-1"), "--watch"), capture_output=True, text=True, check=False,
        env=environment(FORCE_COLOR="1", TERM="xterm-256color"),
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert len(lines(done.stdout)) == FRAMES
    assert "\x1b" not in done.stdout + done.stderr
    assert done.stderr.splitlines()[0] == f"{FRAMES} moments: the lowest optimum is proved in {FRAMES}"


def in_terminal(arguments, term="xterm-256color", seconds=60.0):
    """What a command shows in a terminal, and how it ends."""
    main, side = pty.openpty()
    process = subprocess.Popen(
        arguments, stdin=side, stdout=side, stderr=side, close_fds=True, env=environment(TERM=term)
    )
    os.close(side)
    shown, end = b"", time.monotonic() + seconds
    while time.monotonic() < end:
        if select.select([main], [], [], 0.1)[0]:
            try:
                part = os.read(main, 65536)
            except OSError:
                break
            if not part:
                break
            shown += part
        elif process.poll() is not None:
            break
    code = process.wait(timeout=10)
    os.close(main)
    return code, shown.decode("utf-8", "replace")


def test_watch_shows_object_bounds_margin_robots_and_who_is_missing(world, run):  # noqa: F811
    code, shown = in_terminal(command(*given(world, run, "husky-1", "short"), "--watch"))
    assert code == 0, shown
    assert '"schema"' not in shown, "lines in the terminal that shows the view"
    last = shown[shown.rindex("\N{BOX DRAWINGS LIGHT ARC DOWN AND RIGHT}") :]
    for text in (
        "can",
        "proved",
        "<= F* <=",
        "% below the F* of",
        "husky-1",
        "missing",
        "moments a second",
        "short: ",
    ):
        assert text in last, (text, last)
    assert shown.rindex("\x1b[?25h") > shown.rindex("\x1b[?25l"), "the cursor stays hidden"


def test_watch_on_a_terminal_that_cannot_move_prints_lines_alone(world, run):  # noqa: F811
    code, shown = in_terminal(command(*given(world, run, "husky-1"), "--watch"), term="dumb")
    assert code == 0, shown
    assert shown.count('"schema"') == FRAMES
    assert "\x1b" not in shown


@pytest.fixture
def endless(world, tmp_path):  # noqa: F811
    """A stream of pictures that takes minutes."""
    data = tmp_path / "frame.png"
    draw(data, 2, 0)
    folder = tmp_path / "endless"
    folder.mkdir()
    for k in range(20_000):
        (folder / f"{k:05}.png").hardlink_to(data)
    return folder


SLOW = """
import sys, time
import convexperc.recognition
from convexperc.__main__ import main

perceive, calls = convexperc.recognition.perceive, []

def slow(*arguments, **options):
    calls.append(None)
    if len(calls) == 4:
        time.sleep(120)
    return perceive(*arguments, **options)

convexperc.recognition.perceive = slow
main()
"""
"""The command, of which the fourth moment takes two minutes."""


def test_each_line_comes_at_once_and_an_interruption_is_130(world, run):  # noqa: F811
    process = subprocess.Popen(
        [sys.executable, "-c", SLOW, *map(str, given(world, run, "husky-1"))], stdout=subprocess.PIPE,
        stderr=subprocess.PIPE, env=environment(), start_new_session=True,
    )  # fmt: skip
    assert process.stdout is not None
    came, end = b"", time.monotonic() + 60.0
    while came.count(b"\n") < 3 and time.monotonic() < end:
        if select.select([process.stdout], [], [], 0.1)[0]:
            came += os.read(process.stdout.fileno(), 65536)
    process.send_signal(signal.SIGINT)
    rest, said = process.communicate(timeout=60)
    assert process.returncode == 130, (process.returncode, said)
    assert came.count(b"\n") == 3, "lines are kept back"
    assert len(lines((came + rest).decode())) == 3
    assert said.decode().splitlines()[0] == "3 moments: the lowest optimum is proved in 3"
    assert said.decode().splitlines()[-1] == "interrupted"


def test_an_interruption_gives_the_terminal_back(world, run, endless):  # noqa: F811
    main, side = pty.openpty()
    process = subprocess.Popen(
        command(*given(world, run), "--view", f"a={endless}", "--watch"), stdin=side, stdout=side,
        stderr=side, close_fds=True, env=environment(TERM="xterm"), start_new_session=True,
    )  # fmt: skip
    os.close(side)
    shown, asked = "", False
    while True:
        try:
            part = os.read(main, 65536).decode("utf-8", "replace")
        except OSError:
            break
        if not part:
            break
        shown += part
        if not asked and shown.count("proved") >= 2:
            process.send_signal(signal.SIGINT)
            asked = True
    assert process.wait(timeout=60) == 130, shown[-500:]
    os.close(main)
    assert shown.rindex("\x1b[?25h") > shown.rindex("\x1b[?25l"), "the cursor stays hidden"
    assert shown.rstrip().endswith("interrupted")
    assert "Traceback" not in shown


def test_a_reader_that_ends_is_141(world, run, endless):  # noqa: F811
    process = subprocess.Popen(
        command(*given(world, run), "--view", f"a={endless}"), stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        text=True, env=environment(),
    )  # fmt: skip
    assert process.stdout is not None
    assert process.stderr is not None
    process.stdout.readline()
    process.stdout.close()
    assert process.wait(timeout=60) == 141, process.stderr.read()
    process.stderr.close()


def test_the_rate_is_that_of_the_last_moments(monkeypatch):
    clock = iter(float(k) / 4 for k in range(1000))
    monkeypatch.setattr("convexperc.cli.watching.time.monotonic", lambda: next(clock))
    watch = Watch(["a"])
    assert watch.rate is None
    for _ in range(40):
        watch.show({})
    assert watch.rate == pytest.approx(4.0)


def test_numbers_that_json_has_not_are_null():
    known = References.of({"a": picture(0, 0), "b": picture(1, 0)}, QUICK)
    found = perceive({"one": picture(0, 1)}, known, **LAMBDAS)
    line = recognition_line(float("inf"), 0, {"one": float("nan")}, {}, found)
    assert line["time"] is None
    assert line["views"] == {"one": None}
    lines(json.dumps(line | {"milliseconds": None}))


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    pytest.importorskip("rosbags", reason="bags need the extra ros")
    folder = tmp_path_factory.mktemp("robots")
    return robots.write_references(folder / "known"), robots.write_bag(folder / "run")


def test_three_robots_of_a_bag(bag, tmp_path):
    known, run = bag
    out = tmp_path / "results.mcap"
    done = expect(0, "recognize", "--references", known, *robots.views(run), "--results", out, "--watch")
    found = lines(done.stdout)
    assert [line["nanoseconds"] - robots.START for line in found] == [
        k * robots.STEP for k in range(robots.MOMENTS)
    ]
    for k, line in enumerate(found):
        absent = [name for name in robots.OFFSETS if k in {**robots.SILENT, **robots.DARK}.get(name, ())]
        assert (line["label"], list(line["missing"])) == (robots.scene_at(k), absent)
        for robot, seen in line["views"].items():
            assert seen - line["time"] == pytest.approx(robots.OFFSETS[robot] / 1e9, abs=1e-6)
    said = done.stderr.splitlines()
    assert said[0] == "12 moments: the lowest optimum is proved in 12"
    assert [line for line in said if line.startswith("spot: missing in 3 of 12 moments")]
    assert [line for line in said if line.startswith("husky-2: missing in 2 of 12 moments")]
    check_results(out, found)


@pytest.mark.parametrize(
    ("asked", "said_last"), [("SIGINT", "interrupted"), ("SIGTERM", "terminated"), ("SIGHUP", "terminated")]
)
def test_an_interruption_leaves_lines_and_bag_complete_up_to_there(bag, tmp_path, asked, said_last):
    """By Ctrl-C, by `kill`, `timeout` and systemd, and by the end of a terminal."""
    number = getattr(signal, asked)
    known, run = bag
    out, results = tmp_path / "lines.jsonl", tmp_path / "results.mcap"
    given = ["recognize", "--references", known, *robots.views(run), "--jsonl", out, "--results", results]
    process = subprocess.Popen(
        [sys.executable, "-c", SLOW, *map(str, given)], stderr=subprocess.PIPE, env=environment(),
        start_new_session=True,
    )  # fmt: skip
    end = time.monotonic() + 60.0
    while not (out.exists() and out.read_text().count("\n") == 3) and time.monotonic() < end:
        time.sleep(0.1)
    process.send_signal(number)
    _, said = process.communicate(timeout=60)
    assert process.returncode == 128 + number, said
    assert said.decode().splitlines()[-1] == said_last
    assert b"not used" not in said, "frames that were read ahead"
    assert [path.name for path in tmp_path.iterdir() if path not in (out, results)] == []
    found = lines(out.read_text())
    assert len(found) == 3
    check_results(results, found)


def test_a_moment_is_in_lines_and_bag_before_an_interruption_is_followed(bag, tmp_path, monkeypatch):
    known, run = bag
    plain = convexperc.inputs.ResultBag.write

    def interrupted(self, nanoseconds, *rest):
        if nanoseconds == robots.START + 2 * robots.STEP:
            signal.raise_signal(signal.SIGINT)
        plain(self, nanoseconds, *rest)

    monkeypatch.setattr(convexperc.inputs.ResultBag, "write", interrupted)
    results = tmp_path / "results.mcap"
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        done = expect(130, "recognize", "--references", known, *robots.views(run), "--results", results)
    finally:
        signal.signal(signal.SIGINT, before)
    found = lines(done.stdout)
    assert len(found) == 3
    check_results(results, found)


FULL = """
import resource, signal, sys
from convexperc.__main__ import main

signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (5000, 5000))
main()
"""
"""The command, where no file may have more than 5000 bytes."""


def test_what_cannot_be_written_on_is_2_by_name_and_has_no_half_line(bag, tmp_path):
    known, run = bag
    for option, name in (("--jsonl", "x.jsonl"), ("--results", "x.db3"), ("--results", "x.mcap")):
        out = tmp_path / name
        given = ["recognize", "--references", known, *robots.views(run), option, out]
        done = subprocess.run(
            [sys.executable, "-c", FULL, *map(str, given)], capture_output=True, text=True, check=False,
            env=environment(),
        )  # fmt: skip
        assert done.returncode == 2, done.stderr
        assert f"error: output {out} must be a" in done.stderr.splitlines()[-1]
        if option == "--jsonl":
            assert 1 <= len(lines(out.read_text())) < robots.MOMENTS
            assert out.read_text().endswith("\n")
            out.unlink()
        assert list(tmp_path.iterdir()) == []


def test_a_topic_without_messages_is_named(bag, tmp_path):
    from rosbags.rosbag2 import StoragePlugin, Writer  # noqa: PLC0415
    from rosbags.typesys import Stores, get_typestore  # noqa: PLC0415

    with Writer(tmp_path / "run", version=8, storage_plugin=StoragePlugin.MCAP) as made:
        made.add_connection("/a", "sensor_msgs/msg/Image", typestore=get_typestore(Stores.ROS2_HUMBLE))
    done = expect(2, "recognize", "--references", bag[0], "--view", f"a={tmp_path / 'run'}#/a")
    assert "got 'a: it has no picture'" in done.stderr


def test_a_stream_that_fails_leaves_no_half_bag(bag, tmp_path):
    known, run = bag
    given = ["recognize", "--references", known, *robots.views(run), "--results", tmp_path / "results"]
    done = expect(2, *given, "--strict")
    assert len(lines(done.stdout)) == 3, "until spot falls silent"
    assert list(tmp_path.iterdir()) == []


def test_the_bag_holds_what_the_calibration_accepts(bag, tmp_path):
    known, run = bag
    scene = sample_scene("ica-sign")
    seen = perceive(
        {robot: scene.views[name] for robot, name in robots.VIEWS["ica-sign"].items()},
        References.of(scene.references, FeatureConfiguration()),
        prune=False, **LAMBDAS,
    )  # fmt: skip
    made = replace(Calibration.of([(seen, "ica-sign")] * 30, 0.9), share=1.0)
    chosen = {"one": {"excess": 0.0}, "none": {"share": 0.0}, "all": {"excess": math.inf}}
    for name, limit in chosen.items():
        judge = replace(made, **limit)
        thresholds, out = tmp_path / f"{name}.json", tmp_path / f"{name}.mcap"
        thresholds.write_bytes(json_bytes(judge.to_dict()))
        given = ["recognize", "--references", known, *robots.views(run), "--calibration", thresholds]
        done = RUNNER.invoke(app, list(map(str, [*given, "--results", out])))
        assert done.exit_code in (0, 1), done.output
        found = lines(done.stdout)
        counts = {len(line["acceptance"]["accepted"]) for line in found}
        assert counts == {{"one": 1, "none": 0, "all": 3}[name]}
        check_results(out, found)


def check_results(out, found):
    """The bag of results says what the lines say, by rosbags' own reader."""
    from rosbags.highlevel import AnyReader  # noqa: PLC0415
    from rosbags.typesys import Stores, get_typestore  # noqa: PLC0415

    with AnyReader([out], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
        said = [
            (stamp, reader.deserialize(raw, connection.msgtype))
            for connection, stamp, raw in reader.messages()
            if connection.msgtype == "vision_msgs/msg/Classification"
        ]
    assert [stamp for stamp, _ in said] == [line["nanoseconds"] for line in found]
    for (_, message), line in zip(said, found, strict=True):
        judged = line["acceptance"]
        published = line["candidates"] if judged is None else judged["accepted"]
        assert {each.class_id for each in message.results} == set(published)
        assert all(0.0 < each.score < 1.0 for each in message.results)
