"""`library`, `calibrate`, several references an object, and what is left out, on the command line."""

import json
import re
import shutil

import cv2
import numpy as np
import pytest
from typer.testing import CliRunner

from convexperc import TemplateLibrary
from convexperc.cli.main import app
from convexperc.features import FeatureConfiguration
from convexperc.files import write_json

QUICK = FeatureConfiguration(
    working_size=(32, 32), color_bins=8, hog_pixels_per_cell=(8, 8), lbp_points=8, lbp_radius=1.0, lbp_bins=10
)
RUNNER = CliRunner(env={"COLUMNS": "200", "TERM": "dumb", "NO_COLOR": "1"})
OBJECTS = ("cup", "box", "can")


def expect(code, *arguments):
    result = RUNNER.invoke(app, [str(argument) for argument in arguments])
    assert result.exit_code == code, (result.exit_code, result.output, result.exception)
    return result


def picture(place: int, seed: int) -> np.ndarray:
    """One look of an object: its own pattern and colour, with noise."""
    own, noise = np.random.default_rng(place), np.random.default_rng(1000 + seed)
    pattern = own.integers(0, 200, (8, 8, 3)).repeat(6, axis=0).repeat(6, axis=1)
    return (pattern + noise.integers(0, 55, pattern.shape)).astype(np.uint8)


def draw(path, place: int, seed: int) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    assert cv2.imwrite(str(path), picture(place, seed))


@pytest.fixture(scope="module")
def world(tmp_path_factory):
    """Three objects with references, and scenes of these and of a fourth."""
    folder = tmp_path_factory.mktemp("world")
    draw(folder / "known" / "cup.png", 0, 0)
    for place, name in enumerate(OBJECTS[1:], 1):
        for k in range(2):
            draw(folder / "known" / name / f"{k}.png", place, k)
    for place, name in enumerate((*OBJECTS, "hat")):
        for scene in range(4):
            for robot in range(3):
                draw(
                    folder / "scenes" / name / str(scene) / f"robot-{robot}.png",
                    place,
                    100 + 10 * scene + robot,
                )
    write_json(folder / "quick.json", QUICK.to_dict())
    return folder


def test_a_library_gives_the_outcome_of_its_folder(world, tmp_path):
    known, views = tmp_path / "known.safetensors", world / "scenes" / "can" / "0"
    made = expect(0, "library", world / "known", "--out", known, "--configuration", world / "quick.json")
    assert "5 references of 3 objects" in made.output
    assert TemplateLibrary.load(known).names == ("box/0", "box/1", "can/0", "can/1", "cup")
    records = []
    for references, more in ((world / "known", ["--configuration", world / "quick.json"]), (known, [])):
        out = tmp_path / "out.json"
        expect(0, "recognize", "--references", references, *more, "--views", views, "--json", out)
        records.append(json.loads(out.read_text()))
        records[-1]["solution"].pop("volatile")
    assert records[0] == records[1]
    assert (records[0]["label"], records[0]["ranked_for"]["object"]) == ("can", "can")
    assert [each["name"] for each in records[0]["objects"]] == ["box", "can", "cup"]
    assert records[0]["rules"]["vote"] == "can"
    assert records[0]["margin"]["lower"]["decimal"] > 0.0


def test_the_table_is_by_object_and_names_the_best_reference(world):
    views, quick = world / "scenes" / "box" / "1", ["--configuration", world / "quick.json"]
    said = expect(0, "recognize", "--references", world / "known", "--views", views, *quick).output
    assert "Objects by their best references" in said
    assert re.search(r"label +box, by its reference [01]\s", said), said
    assert re.search(r"acceptance +not judged", said), said
    assert re.search(r"explained +[\d.]+ to [\d.]+ % of", said), said
    assert "3 of 3 have a certified answer; so have 5 of their 5 references" in said
    assert "other rules" in said
    assert "margin" in said


def test_what_is_left_out_is_said_in_one_line_a_folder(world, tmp_path):
    for name in ("cup.png", "can.png"):
        draw(tmp_path / "known" / name, OBJECTS.index(name[:3]), 0)
    draw(tmp_path / "views" / "one.png", 0, 5)
    (tmp_path / "known" / "hat.HEIC").write_bytes(b"x")
    (tmp_path / "views" / "more").mkdir()
    quick = ["--configuration", world / "quick.json"]
    given = ["--references", tmp_path / "known", "--views", tmp_path / "views"]
    lines = expect(0, "recognize", *given, *quick).stderr.splitlines()
    assert lines == [
        f"left out of {tmp_path / 'known'}: hat.HEIC (HEIC is not read; convert it to PNG)",
        f"left out of {tmp_path / 'views'}: more (a folder)",
    ]


def test_of_many_that_are_left_out_the_line_names_the_first(world, tmp_path):
    for name in ("cup.png", "can.png"):
        draw(tmp_path / "known" / name, OBJECTS.index(name[:3]), 0)
    for number in range(40):
        (tmp_path / "known" / f"{number:02}.txt").write_bytes(b"x")
    quick = ["--configuration", world / "quick.json"]
    done = expect(0, "library", tmp_path / "known", "--out", tmp_path / "k.safetensors", *quick)
    (line,) = [line for line in done.stderr.splitlines() if line.startswith("left out of")]
    assert line.endswith(", 11.txt (no picture by its name), and 28 more"), line


def test_a_link_to_nothing_among_the_references_ends_the_command(world, tmp_path):
    draw(tmp_path / "known" / "cup.png", 0, 0)
    draw(tmp_path / "known" / "can.png", 2, 0)
    (tmp_path / "known" / "box.png").symlink_to(tmp_path / "missing.png")
    views = world / "scenes" / "box" / "0"
    failed = expect(2, "recognize", "--references", tmp_path / "known", "--views", views)
    assert "box.png" in failed.output
    assert "no such file" in failed.output


def test_what_is_left_out_is_said_also_where_nothing_is_left_to_recognise(world, tmp_path):
    draw(tmp_path / "known" / "cup.png", 0, 0)
    for name in ("box.gif", "can.HEIC"):
        (tmp_path / "known" / name).write_bytes(b"x")
    views = world / "scenes" / "box" / "0"
    failed = expect(2, "recognize", "--references", tmp_path / "known", "--views", views)
    lines = failed.stderr.splitlines()
    assert lines[0].startswith(f"left out of {tmp_path / 'known'}: box.gif (GIF"), lines
    assert "can.HEIC" in lines[0]
    assert "at least two objects" in lines[1]


def test_calibrate_says_what_of_the_scenes_it_leaves_out_and_which_views_show_nothing(world, tmp_path):
    shutil.copytree(world / "scenes", tmp_path / "scenes")
    draw(tmp_path / "scenes" / "loose.png", 0, 0)
    (tmp_path / "scenes" / "cup" / "1" / "robot-9.HEIC").write_bytes(b"x")
    dark = tmp_path / "scenes" / "can" / "2" / "robot-1.png"
    assert cv2.imwrite(str(dark), np.zeros((48, 48, 3), np.uint8))
    given = ["--references", world / "known", "--scenes", tmp_path / "scenes", "--out", tmp_path / "t.json"]
    lines = expect(
        0, "calibrate", *given, "--coverage", 0.8, "--configuration", world / "quick.json"
    ).stderr.splitlines()
    assert lines[0] == (
        f"left out of {tmp_path / 'scenes'}: loose.png (a picture outside of a scene), "
        "cup/1/robot-9.HEIC (HEIC is not read; convert it to PNG)"
    )
    assert [line for line in lines if line.startswith("warning: of one color are the views of robot-1:")]


@pytest.fixture(scope="module")
def thresholds(world):
    """What `calibrate` has written and printed."""
    out, quick = world / "thresholds.json", ["--configuration", world / "quick.json"]
    given = ["--references", world / "known", "--scenes", world / "scenes", *quick, "--out", out]
    return out, expect(0, "calibrate", *given, "--coverage", 0.8).output


def test_calibrate_counts_known_and_unknown_scenes(thresholds):
    out, said = thresholds
    record = json.loads(out.read_text())
    assert (record["schema"], record["scenes"], record["coverage"]) == ("convexperc/calibration/1", 12, 0.8)
    assert 0.0 <= record["share"] < 1.0
    assert "of 12 scenes, each judged by the others" in said
    assert "of 4 scenes" in said


def test_a_calibration_accepts_known_objects_and_refuses_an_unknown_one(world, thresholds, tmp_path):
    out, quick = thresholds[0], ["--configuration", world / "quick.json"]
    for name, code, verdict in (("can", 0, "recognised"), ("hat", 1, "unknown")):
        given = ["--references", world / "known", "--views", world / "scenes" / name / "2", *quick]
        made = ["--calibration", out, "--json", tmp_path / "r.json"]
        said = expect(code, "recognize", *given, *made).output
        assert f"{verdict}" in said
        record = json.loads((tmp_path / "r.json").read_text())
        assert record["acceptance"]["verdict"] == verdict
        assert record["verdict"] == "proved: lowest optimum"
        assert (
            0.0 <= record["explained"]["lower"]["decimal"] <= record["explained"]["upper"]["decimal"] <= 1.0
        )
        expect(0, "recognize", *given)


def test_the_references_themselves_may_set_the_thresholds(world, tmp_path):
    quick = ["--configuration", world / "quick.json"]
    given = ["--references", world / "known", *quick, "--out", tmp_path / "t.json"]
    said = expect(0, "calibrate", *given, "--robots", 1, "--coverage", 0.5).output
    record = json.loads((tmp_path / "t.json").read_text())
    assert (record["origin"], record["scenes"]) == ("held-out references", 4)  # of box and can; cup has one
    assert "these 4 held-out references" in said
    assert "known" not in said.replace("known objects", "")
    coverage = "--coverage", 0.5
    counted = expect(0, "calibrate", *given, "--robots", 1, "--scenes", world / "scenes", *coverage).output
    assert re.search(r"of 12 scenes: in \d+ the true object is accepted", counted), counted
    assert re.search(r"of 4 scenes of objects that are not known \(hat\) \d are refused", counted), counted
    few = expect(2, "calibrate", *given, "--robots", 1)
    assert "must be at least 19 for a coverage of 0.9; got 4" in few.output
    assert json.loads((tmp_path / "t.json").read_text())["scenes"] == 4
    failed = expect(2, "calibrate", *given, "--robots", 2)
    assert "more than 2 references" in failed.output
    assert "--robots" in expect(2, "calibrate", *given).output


def test_each_view_adds_its_own_sum(world, tmp_path):
    given = ["--references", world / "known", "--views", world / "scenes" / "can" / "2"]
    quick = ["--configuration", world / "quick.json", "--json", tmp_path / "r.json"]
    said = expect(0, "recognize", *given, *quick, "--each-view").output
    assert re.search(r"each view +can; proved: lowest sum", said), said
    record = json.loads((tmp_path / "r.json").read_text())["each_view"]
    assert (record["label"], set(record["labels"].values())) == ("can", {"can"})
    assert min(record["sums"], key=lambda name: record["sums"][name]["upper"]["decimal"]) == "can"
    expect(0, "recognize", *given, *quick)
    assert json.loads((tmp_path / "r.json").read_text())["each_view"] is None


def test_what_does_not_fit_is_refused_before_anything_is_written(world, thresholds, tmp_path):
    known, views = world / "known", world / "scenes" / "can" / "0"
    quick = ["--configuration", world / "quick.json"]
    library = tmp_path / "known.safetensors"
    expect(0, "library", known, "--out", library, *quick)
    again = expect(2, "recognize", "--references", library, "--views", views, *quick)
    assert "leave out --configuration" in again.output
    other = ["--lambda1", 0.5, "--calibration", thresholds[0]]
    failed = expect(2, "recognize", "--references", known, "--views", views, *quick, *other)
    assert "as the calibration was" in failed.output
    for coverage in (0, 1, 90):
        given = ["--references", known, "--scenes", world / "scenes", *quick, "--out", tmp_path / "t.json"]
        failed = expect(2, "calibrate", *given, "--coverage", coverage)
        assert "between 0 and 1" in failed.output
    assert not (tmp_path / "t.json").exists()
    failed = expect(
        2, "calibrate", "--references", known, "--scenes", known, *quick, "--out", tmp_path / "t.json"
    )
    assert "OBJECT/SCENE" in failed.output
    within = known / "can" / "new.json"
    failed = expect(2, "recognize", "--references", known, "--views", views, *quick, "--json", within)
    assert "must not lie in the folder" in failed.output
    assert "must not lie" in expect(2, "library", known, "--out", within, *quick).output
    assert not within.exists()
    scene = world / "scenes" / "can" / "0" / "t.json"
    given = ["--references", known, "--scenes", world / "scenes", *quick, "--out"]
    assert "must not lie" in expect(2, "calibrate", *given, scene).output
    assert "must not lie" in expect(2, "calibrate", *given, scene.parent.parent / "t.json").output
    failed = expect(2, "library", known, "--out", known / "cup.png", *quick)
    assert cv2.imread(str(known / "cup.png")) is not None
    failed = expect(
        2, "recognize", "--references", known, "--views", views, *quick, "--calibration", world / "quick.json"
    )
    assert "calibration" in failed.output
