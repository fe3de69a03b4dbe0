"""The command `accuracy`: what it reads and writes; its record, and what the documents say of that."""

import importlib.util
import json
import re
from pathlib import Path

import cv2
import numpy as np
import pytest
from made_up_pictures import COLOURS, drawn, picture_set, write_folder
from typer.testing import CliRunner

from convexperc import FeatureConfiguration
from verification.__main__ import app
from verification.accuracy.scenes import simulated_albums
from verification.accuracy.tables import pages
from verification.experiments.scenes.folder import read_physical

RUNNER = CliRunner(env={"COLUMNS": "140", "TERM": "dumb", "NO_COLOR": "1"})
ROOT = Path(__file__).parents[3]
RECORD = ROOT / "reports" / "accuracy.json"
NEEDS_SKLEARN = pytest.mark.skipif(
    importlib.util.find_spec("sklearn") is None, reason="scikit-learn (extra `bench`) is not installed"
)
FEW = ("--references", 2, "--scenes", 1, "--draws", 1, "--resamples", 50)


def run(*arguments):
    return RUNNER.invoke(app, ["accuracy", *map(str, arguments)])


@pytest.fixture(scope="module")
def photos(tmp_path_factory) -> Path:
    folder, rng = tmp_path_factory.mktemp("of somebody") / "photos", np.random.default_rng(0)
    for colour in COLOURS:
        (folder / colour / "masks").mkdir(parents=True)
        for k in range(14):
            picture, mask = drawn(colour, "none", rng)
            cv2.imwrite(str(folder / colour / f"{k:02d}.png"), picture[..., ::-1])
            cv2.imwrite(str(folder / colour / "masks" / f"{k:02d}.png"), mask.astype(np.uint8) * 255)
    return folder


@NEEDS_SKLEARN
def test_two_runs_write_the_same_and_nothing_of_the_machine(photos, tmp_path):
    narrow = tmp_path / "narrow.json"
    narrow.write_text(json.dumps(FeatureConfiguration(color_bins=4).to_dict()))
    wide = tmp_path / "wide.json"
    wide.write_text(json.dumps(FeatureConfiguration().to_dict()))
    given = ("--photos", photos, "--configuration", narrow, "--configuration", wide, *FEW)
    texts = []
    for name in ("one", "two"):
        file, page = tmp_path / f"{name}.json", tmp_path / f"{name}.md"
        done = run(*given, "--json", file, "--markdown", page)
        assert done.exit_code == 0, done.output
        texts.append((file.read_text(), page.read_text()))
    assert texts[0] == texts[1]
    record, page = json.loads(texts[0][0]), texts[0][1]
    assert page == pages(record)
    assert "somebody" not in texts[0][0]
    assert record["command"] == (
        "convexperc-verification accuracy --photos PHOTOS --configuration narrow.json"
        " --configuration wide.json --references 2 --scenes 1 --draws 1 --seed 0 --resamples 50"
    )
    assert record["schema"] == "convexperc/accuracy/1"
    assert record["made"]["versions"]["scikit-learn"] != "not installed"
    assert [each["configuration name"] for each in record["results"]] == ["narrow", "wide"]
    assert record["results"][0]["pictures"] == record["results"][1]["pictures"]
    other = run("--photos", photos, *FEW, "--seed", 1, "--json", tmp_path / "three.json")
    assert other.exit_code == 0, other.output
    assert "objects x 2 references" in other.output


def test_a_simulated_set_gives_its_clear_views(tmp_path):
    folder = write_folder(tmp_path, picture_set(tuple(COLOURS), levels=True))
    pictures = read_physical(folder)
    for album in simulated_albums(pictures):
        clear = sum(
            view.obstruction == "none"
            for scene in pictures.layout.scenes
            if scene.object == album.object
            for view in scene.views
        )
        assert len(album.others) == clear
        assert all(photo.mask.any() for photo in album.others)


@NEEDS_SKLEARN
def test_misuse_is_said_before_anything_is_measured(photos, tmp_path):
    assert "must be given" in run(*FEW).output
    for wrong in (
        (*FEW,),
        ("--photos", photos, "--json", tmp_path / "a", "--markdown", tmp_path / "a"),
        ("--photos", photos, "--references", 13),
        ("--photos", tmp_path),
        ("--simulation", photos),
    ):
        done = run(*wrong)
        assert done.exit_code == 2, (wrong, done.output)
    assert not (tmp_path / "a").exists()


def test_the_committed_page_is_that_of_the_record():
    record = json.loads(RECORD.read_text(encoding="utf-8"))
    assert (ROOT / "reports" / "accuracy.md").read_text(encoding="utf-8") == pages(record)
    assert re.fullmatch("[0-9a-f]{40}", record["made"]["commit"]), "made from no clean clone"


def test_the_document_tells_what_the_record_says():
    """Each row of its tables, but those that are named otherwise, stands in the generated page."""
    page = (ROOT / "reports" / "accuracy.md").read_text(encoding="utf-8").splitlines()
    text = (ROOT / "docs" / "accuracy.md").read_text(encoding="utf-8")
    rows = [line for line in text.splitlines() if re.match(r"\| (six|two|unknown)", line)]
    assert len(rows) > 20
    assert not [row for row in rows if row not in page]
