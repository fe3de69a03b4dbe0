"""Data sets in folders: form, resumption, and the same bytes in any number of processes."""

import hashlib
import json
import shutil
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from convexperc.errors import InputError
from convexperc.recognition.references import read_pictures
from convexperc.simulation import (
    RED_CAR,
    ImageSize,
    Request,
    SceneRenderer,
    Written,
    drawing,
    scene_of_record,
    write_data_set,
    write_scene,
)
from convexperc.simulation import datasets as data_sets
from convexperc.simulation.folder import part_name
from convexperc.simulation.physical import LEVELS

SIZE = ImageSize(64, 48)
REQUEST = Request("physical", 3, 1, ("teapot",), SIZE)


def contents(folder: Path) -> dict[str, str]:
    """Hash of each file by its path."""
    files = (path for path in sorted(folder.rglob("*")) if path.is_file())
    return {
        path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest() for path in files
    }


@pytest.fixture(scope="module")
def made(opengl, tmp_path_factory) -> tuple[Path, Written]:
    folder = tmp_path_factory.mktemp("data") / "set"
    return folder, write_data_set(folder, REQUEST)


def recorded(folder: Path) -> dict[str, Any]:
    record: dict[str, Any] = json.loads((folder / "manifest.json").read_text(encoding="utf-8"))
    return record


def test_the_folder_holds_what_the_manifest_says_and_nothing_else(made):
    folder, written = made
    manifest, found = recorded(folder), contents(folder)
    assert manifest == json.loads(json.dumps(written.manifest))
    assert written.drawn_pictures == written.pictures == 1 + 5 * 6
    said = {"manifest.json": found["manifest.json"]}
    for scene in manifest["scenes"]:
        said[scene["overhead"]] = scene["overhead_sha256"]
    for view in [*manifest["references"], *(view for scene in manifest["scenes"] for view in scene["views"])]:
        said |= {view["file"]: view["sha256"], view["mask"]: view["mask_sha256"]}
    assert found == said
    assert manifest["objects"] == {"teapot": ""}


def test_each_level_has_as_many_obstructed_views_as_it_says_by_measure(made):
    folder, _ = made
    scenes = recorded(folder)["scenes"]
    assert [scene["level"] for scene in scenes] == [level.name for level in LEVELS]
    for scene, level in zip(scenes, LEVELS, strict=True):
        shares = [view["visible_share"] for view in scene["views"]]
        assert sum(share <= 0.05 for share in shares) == level.full, scene["name"]
        assert sum(0.05 < share < 0.9 for share in shares) == level.partial, scene["name"]
        for view in scene["views"]:
            mask = cv2.imread(str(folder / view["mask"]), cv2.IMREAD_UNCHANGED)
            assert mask.shape == (48, 64)
            assert set(np.unique(mask).tolist()) <= {0, 255}


def test_a_scene_can_be_drawn_again_from_its_description(made):
    folder, _ = made
    entry = recorded(folder)["scenes"][4]
    scene = scene_of_record(entry["description"], "manifest")
    drawn = drawing.draw_scene(scene, SIZE, data_sets.catalogue(), entry["level"])
    assert drawn.entry == entry
    assert all((folder / path).read_bytes() == content for path, content in drawn.files.items())


def test_the_pictures_are_what_recognize_reads(made):
    folder, _ = made
    assert list(read_pictures(folder / "references")) == ["teapot"]
    views = read_pictures(folder / "views" / "teapot-5-01")
    assert list(views) == [f"robot-{k}" for k in range(1, 7)]
    assert {view.shape for view in views.values()} == {(48, 64, 3)}


def test_a_broken_folder_is_mended_by_several_processes_to_the_same_bytes(made, tmp_path):
    folder, _ = made
    broken = tmp_path / "set"
    shutil.copytree(folder, broken)
    shutil.rmtree(broken / "views" / "teapot-2-01")
    spoilt = broken / "masks" / "views" / "teapot-3-01" / "robot-4.png"
    spoilt.write_bytes(spoilt.read_bytes()[:-1])
    (broken / "references" / "teapot.png").unlink()
    steps: list[tuple[str, int]] = []
    written = write_data_set(
        broken, REQUEST, workers=2, progress=lambda part, count: steps.append((part, count))
    )
    assert written.drawn == {"scenes/teapot-2-01", "scenes/teapot-3-01", "references/teapot"}
    assert written.drawn_pictures == 13
    assert sorted(part for part, _ in steps) == sorted(
        part_name(entry) for entry in [*written.manifest["references"], *written.manifest["scenes"]]
    )
    assert {count for _, count in steps} == {6}
    assert contents(broken) == contents(folder)


def test_a_run_that_was_stopped_goes_on_where_it_was(made, monkeypatch, tmp_path):
    folder, _ = made
    target, drawn = tmp_path / "set", []
    keep = data_sets.keep

    def stop_later(place: Path, part: drawing.Drawn) -> dict[str, Any]:
        if len(drawn) == 2:
            # What a kill leaves: files beside their places, no entry on record, no manifest.
            (place / ".drawing" / part_name(part.entry)).mkdir(parents=True)
            raise KeyboardInterrupt
        drawn.append(part_name(part.entry))
        return keep(place, part)

    monkeypatch.setattr(data_sets, "keep", stop_later)
    with pytest.raises(KeyboardInterrupt):
        write_data_set(target, REQUEST)
    assert not (target / "manifest.json").exists()
    monkeypatch.setattr(data_sets, "keep", keep)
    written = write_data_set(target, REQUEST)
    assert written.drawn.isdisjoint(drawn)
    assert len(written.drawn) == 4
    assert contents(target) == contents(folder)


@pytest.mark.parametrize(
    ("other", "key"),
    [
        (Request("physical", 4, 1, REQUEST.objects, SIZE), "seed"),
        (Request("physical", 3, 2, REQUEST.objects, SIZE), "scenes_each"),
        (Request("physical", 3, 1, ("chair",), SIZE), "objects"),
        (Request("physical", 3, 1, REQUEST.objects, ImageSize(80, 60)), "image"),
        (Request("case-study", 3, 1, REQUEST.objects, SIZE), "set"),
    ],
)
def test_another_request_in_the_same_folder_is_refused(made, other, key):
    folder, _ = made
    before = contents(folder)
    with pytest.raises(InputError, match=rf"must have been begun with the same .*{key}"):
        write_data_set(folder, other)
    assert contents(folder) == before


def test_a_folder_of_other_things_is_left_alone(opengl, tmp_path):
    (tmp_path / "diary.txt").write_text("mine")
    with pytest.raises(InputError, match="must be empty or hold a data set"):
        write_data_set(tmp_path, REQUEST)
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="must be a folder that can be written"):
        write_data_set(tmp_path / "file", REQUEST)
    with pytest.raises(InputError, match="objects must be among red-car"):
        write_data_set(tmp_path / "new", Request("physical", 0, 1, ("unicorn",), SIZE))
    with pytest.raises(InputError, match="workers must be at least 1"):
        write_data_set(tmp_path / "new", REQUEST, workers=0)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["diary.txt", "file"]


def test_a_level_that_cannot_be_reached_is_an_error(opengl, monkeypatch, tmp_path):
    monkeypatch.setattr(drawing, "MAX_DRAWS", 3)
    monkeypatch.setattr(SceneRenderer, "visible_share", lambda *_: 0.85)
    with pytest.raises(
        InputError, match=r"scene teapot-[12345]-01: level 'none' must be attainable; got 'none in 3 draws'"
    ):
        write_data_set(tmp_path / "new", REQUEST)
    assert not (tmp_path / "new" / "manifest.json").exists()


def test_one_scene_can_be_drawn_alone(opengl, tmp_path):
    written = write_scene(tmp_path / "one", RED_CAR, SIZE)
    assert recorded(tmp_path / "one")["set"] == "scene"
    assert [scene["name"] for scene in written.manifest["scenes"]] == ["red-car"]
    before = contents(tmp_path / "one")
    assert len(before) == 1 + 2 + 1 + 10
    write_scene(tmp_path / "one", RED_CAR, SIZE)
    assert contents(tmp_path / "one") == before
