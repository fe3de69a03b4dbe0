"""The committed sample, the scenes as data, and, where MuJoCo is installed, the pictures themselves."""

import ctypes.util
import hashlib
import importlib.resources
import importlib.util
import json
import os
import pickle
import subprocess
import sys
import xml.etree.ElementTree as ET
from collections import Counter
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import typer
from convexperc.simulation.__main__ import main

from convexperc.errors import InputError, MissingExtraError
from convexperc.simulation import (
    GRAY_CAR,
    RED_CAR,
    SCENES,
    Camera,
    Obstacle,
    RenderingError,
    Scene,
    SceneRenderer,
    mjcf,
    write_sample,
)
from convexperc.simulation.backends import choose_backend
from convexperc.simulation.mjcf import Group

SAMPLE = importlib.resources.files("convexperc") / "sample"
RECORD: dict[str, Any] = json.loads((SAMPLE / "sample.json").read_text(encoding="utf-8"))
ENTRIES = [
    camera
    for scene in RECORD["scenes"]
    for camera in [scene["reference"], scene["overhead"], *scene["robots"]]
]

LARGEST_SAMPLE = 400_000
"""Bytes that the sample may add to the package."""

MEAN_TOLERANCE = 0.5
"""Mean difference in grey levels (of 255) of a picture drawn by another engine. Rasterisers place edges and
shadows a fraction of a sample apart: Mesa's softpipe differs from its llvmpipe by 0.25 at most, while turning
the object by one degree changes the references by 0.8 and more."""

FRACTION_TOLERANCE = 0.01
"""Difference in the visible fraction on another engine, for the same reason."""

needs_mujoco = pytest.mark.skipif(
    importlib.util.find_spec("mujoco") is None, reason="the extra 'sim' is not installed"
)


def decode(content: bytes) -> np.ndarray:
    return cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_COLOR)


def read(entry: dict[str, Any]) -> bytes:
    return SAMPLE.joinpath(*entry["file"].split("/")).read_bytes()


# The committed sample --------------------------------------------------------------------------------------


def test_the_sample_holds_exactly_the_recorded_pictures():
    with importlib.resources.as_file(SAMPLE) as folder:
        present = {path.relative_to(folder).as_posix() for path in folder.rglob("*.png")}
        size = sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())
    assert present == {entry["file"] for entry in ENTRIES}
    assert size <= LARGEST_SAMPLE


@pytest.mark.parametrize("entry", ENTRIES, ids=lambda entry: entry["file"])
def test_a_picture_has_its_recorded_hash_and_size(entry):
    content = read(entry)
    assert hashlib.sha256(content).hexdigest() == entry["sha256"]
    size = RECORD["overhead_image" if entry["name"] == "overhead" else "image"]
    assert decode(content).shape == (size["height"], size["width"], 3)


@pytest.mark.parametrize("scene", RECORD["scenes"], ids=lambda scene: scene["name"])
def test_each_scene_has_a_reference_and_five_views_of_which_some_are_hidden(scene):
    name = scene["name"]
    assert scene["reference"]["file"] == f"references/{name}.png"
    assert [robot["file"] for robot in scene["robots"]] == [
        f"views/{name}/robot-{k}.png" for k in range(1, 6)
    ]
    hidden = Counter(robot["obstruction"] for robot in scene["robots"])
    assert hidden["full"] >= 1, hidden
    assert hidden["partial"] >= 1, hidden
    near = [r for r in scene["robots"] if abs(r["azimuth"]) <= 30 and r["obstruction"] == "none"]
    assert len(near) >= 2, "two robots must have a good view from near the reference's side"


@pytest.mark.parametrize("robot", [robot for scene in RECORD["scenes"] for robot in scene["robots"]])
def test_the_obstruction_follows_from_the_visible_fraction(robot):
    visible = robot["visible_fraction"]
    expected = {0.0: "full", 1.0: "none"}.get(visible, "partial")
    assert 0.0 <= visible <= 1.0
    assert robot["obstruction"] == expected


def test_the_record_describes_the_scenes_as_they_are_now():
    for recorded, scene in zip(RECORD["scenes"], SCENES, strict=True):
        assert recorded["name"] == scene.name
        assert recorded["target_height"] == scene.target_height
        assert recorded["obstacles"] == [asdict(thing) for thing in scene.obstacles]
        cameras = [recorded["reference"], recorded["overhead"], *recorded["robots"]]
        for entry, (name, camera) in zip(cameras, scene.cameras().items(), strict=True):
            assert {"name": name, **asdict(camera)}.items() <= entry.items()
    assert RECORD["command"].startswith("python -m convexperc.simulation ")
    assert RECORD["engine"].keys() == {"mujoco", "backend", "renderer", "opengl"}


# Scenes as data --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("scene", SCENES, ids=lambda scene: scene.name)
def test_mjcf_is_well_formed_and_every_reference_in_it_resolves(scene):
    root = ET.fromstring(mjcf(scene))
    materials = {material.get("name") for material in root.iterfind("asset/material")}
    meshes = {mesh.get("name") for mesh in root.iterfind("asset/mesh")}
    assert {geom.get("material") for geom in root.iter("geom")} <= materials
    assert {geom.get("mesh") for geom in root.iter("geom") if geom.get("type") == "mesh"} == meshes
    bodies = [body.get("name") for body in root.iterfind("worldbody/body")]
    obstacles = [f"obstacle-{k}" for k in range(1, len(scene.obstacles) + 1)]
    assert bodies == ["park", "object", *obstacles, *(f"robot-{k}" for k in range(1, 6))]
    for size in (geom.get("size") for geom in root.iterfind("worldbody/body/geom") if geom.get("size")):
        assert min(map(float, size.split())) > 0, size


@pytest.mark.parametrize("scene", SCENES, ids=lambda scene: scene.name)
def test_mjcf_places_each_camera_on_its_ring(scene):
    root = ET.fromstring(mjcf(scene))
    written = {camera.get("name"): camera for camera in root.iterfind("worldbody/camera")}
    assert written.keys() == scene.cameras().keys()
    for name, camera in scene.cameras().items():
        x, y, z = map(float, written[name].get("pos").split())
        assert np.hypot(x, y) == pytest.approx(camera.distance, abs=1e-5)
        off = np.degrees(np.arctan2(y, x)) - camera.azimuth
        assert (off + 180) % 360 - 180 == pytest.approx(0, abs=1e-3)
        assert z == pytest.approx(camera.height)


@pytest.mark.parametrize("pan", [-30.0, 0.0, 12.5])
def test_a_camera_looks_at_the_object_but_for_its_pan(pan):
    camera = Camera(azimuth=130.0, distance=6.0, height=1.4, pan=pan)
    right, up = camera.axes(target_height=0.6)
    np.testing.assert_allclose([right @ right, up @ up, right @ up, right[2]], [1, 1, 0, 0], atol=1e-14)
    forward = np.cross(up, right)
    towards = np.array([0.0, 0.0, 0.6]) - camera.position()
    turn = np.degrees(np.arctan2(forward[1], forward[0]) - np.arctan2(towards[1], towards[0]))
    assert turn % 360 == pytest.approx(pan % 360)
    assert forward[2] == pytest.approx(towards[2] / np.linalg.norm(towards))


def clearance(robot: Camera, thing: Obstacle) -> float:
    """Distance in metres from an obstacle's rim to the line from a robot to the object's centre."""
    start, place = robot.position()[:2], thing.position()[:2]
    share = np.clip(start @ (start - place) / (start @ start), 0.0, 1.0)
    return float(np.linalg.norm(start + share * (0.0 - start) - place)) - thing.width / 2


@pytest.mark.parametrize("scene", SCENES, ids=lambda scene: scene.name)
def test_obstacles_stand_between_the_object_and_the_robots_recorded_as_hidden(scene):
    recorded = next(entry for entry in RECORD["scenes"] if entry["name"] == scene.name)
    half_object = 2.3
    for robot, entry in zip(scene.robots, recorded["robots"], strict=True):
        nearest = min(clearance(robot, thing) for thing in scene.obstacles if thing.distance < robot.distance)
        if entry["obstruction"] == "none":
            assert nearest > 0, entry["name"]
        else:
            assert nearest < (0 if entry["obstruction"] == "full" else half_object), entry["name"]


@pytest.mark.parametrize(
    "make",
    [
        lambda: Camera(azimuth=float("nan"), distance=6.0, height=1.0),
        lambda: Camera(azimuth=0.0, distance=0.0, height=1.0),
        lambda: Camera(azimuth=0.0, distance=6.0, height=0.2),
        lambda: Camera(azimuth=0.0, distance=6.0, height=1.0, field_of_view=180.0),
        lambda: Obstacle("crate", azimuth=0.0, distance=3.0, width=0.0, height=1.0),
        lambda: Obstacle("wall", azimuth=0.0, distance=3.0, width=1.0, height=float("inf")),
        lambda: Scene("red-car", 0.7, RED_CAR.reference, robots=()),
    ],
)
def test_an_absurd_scene_is_refused(make):
    with pytest.raises(InputError, match="must"):
        make()


# Errors ----------------------------------------------------------------------------------------------------


def test_without_mujoco_the_error_names_the_extra(monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(MissingExtraError, match=r"convexperc\[sim\]"):
        SceneRenderer(RED_CAR, 32, 24)


@pytest.mark.parametrize(
    ("asked", "installed", "chosen"),
    [
        ("", {"EGL", "OSMesa"}, "egl"),
        ("", {"OSMesa"}, "osmesa"),
        ("osmesa", {"EGL", "OSMesa"}, "osmesa"),
        (" EGL ", {"EGL"}, "egl"),
    ],
)
def test_the_backend_is_the_one_asked_for_or_the_first_installed(monkeypatch, asked, installed, chosen):
    monkeypatch.setenv("MUJOCO_GL", asked)
    monkeypatch.setattr(ctypes.util, "find_library", lambda name: name if name in installed else None)
    assert choose_backend() == chosen


@pytest.mark.parametrize(("asked", "installed"), [("", set()), ("osmesa", {"EGL"}), ("egl", {"OSMesa"})])
def test_without_a_library_the_error_names_the_system_package(monkeypatch, asked, installed):
    monkeypatch.setenv("MUJOCO_GL", asked)
    monkeypatch.setattr(ctypes.util, "find_library", lambda name: name if name in installed else None)
    with pytest.raises(
        RenderingError, match=r"apt-get install libegl1 libgl1-mesa-dri .* libosmesa6"
    ) as caught:
        choose_backend()
    assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)


def test_an_unknown_backend_is_refused_by_name(monkeypatch):
    monkeypatch.setenv("MUJOCO_GL", "glfw")
    with pytest.raises(RenderingError, match=r"MUJOCO_GL must be egl, osmesa or unset; got 'glfw'"):
        choose_backend()


def test_the_command_line_reports_an_error_on_stderr_and_fails(monkeypatch, capsys, tmp_path):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(typer.Exit) as caught:
        main(tmp_path)
    assert caught.value.exit_code == 1
    assert capsys.readouterr().err.startswith("error: mujoco must be installed")
    assert list(tmp_path.iterdir()) == []


# Pictures --------------------------------------------------------------------------------------------------


def opengl_starts() -> bool:
    """Ask MuJoCo itself, in a fresh process, whether the backend that this environment implies starts."""
    asked = os.environ.get("MUJOCO_GL", "").strip().lower()
    backend = asked or ("egl" if ctypes.util.find_library("EGL") else "osmesa")
    program = f"from mujoco.{backend} import GLContext; GLContext(1, 1).make_current()"
    environment = {**os.environ, "MUJOCO_GL": backend}
    run = subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, check=False)
    return run.returncode == 0


def same_engine(one: dict[str, str], other: dict[str, str]) -> bool:
    """EGL and OSMesa hand out the same renderer, so the way to it does not matter."""
    return all(one[key] == other[key] for key in ("mujoco", "renderer", "opengl"))


def compare_with_sample(folder: Path) -> None:
    record = json.loads((folder / "sample.json").read_text(encoding="utf-8"))
    exact = same_engine(record["engine"], RECORD["engine"])
    for entry in ENTRIES:
        here, there = decode((folder / entry["file"]).read_bytes()), decode(read(entry))
        difference = np.abs(here.astype(int) - there.astype(int))
        assert difference.mean() <= (0.0 if exact else MEAN_TOLERANCE), (entry["file"], record["engine"])
    for new, old in zip(record["scenes"], RECORD["scenes"], strict=True):
        for a, b in zip(new["robots"], old["robots"], strict=True):
            gap = abs(a["visible_fraction"] - b["visible_fraction"])
            assert gap <= (0.0 if exact else FRACTION_TOLERANCE), (new["name"], a["name"], record["engine"])
            assert a["obstruction"] == b["obstruction"], (new["name"], a["name"])


@needs_mujoco
def test_the_sample_can_be_made_again(tmp_path):
    if opengl_starts():
        files = write_sample(tmp_path)
        assert {file.relative_to(tmp_path).as_posix() for file in files} == {
            "sample.json",
            *(entry["file"] for entry in ENTRIES),
        }
        compare_with_sample(tmp_path)
    else:
        with pytest.raises(RenderingError, match="apt-get install"):
            write_sample(tmp_path)


@needs_mujoco
def test_only_what_is_present_is_drawn_and_hides():
    if not opengl_starts():
        with pytest.raises(RenderingError, match="apt-get install"):
            SceneRenderer(GRAY_CAR, 48, 36)
        return
    with SceneRenderer(GRAY_CAR, 48, 36) as renderer:
        hidden, clear = renderer.visible_fraction("robot-3"), renderer.visible_fraction("robot-2")
        everything = renderer.picture("robot-3")
        bare = renderer.picture("robot-3", (Group.OBJECT, Group.PARK))
        again = renderer.picture("robot-3")
        with pytest.raises(InputError, match=r"camera must be one of reference, overhead, robot-1"):
            renderer.picture("robot-9")
    with SceneRenderer(replace(GRAY_CAR, obstacles=()), 48, 36) as renderer:
        freed, open_view = renderer.visible_fraction("robot-3"), renderer.picture("robot-3")
    assert (hidden, clear, freed) == (0.0, 1.0, 1.0)
    np.testing.assert_array_equal(everything, again)
    assert np.abs(everything.astype(int) - bare).mean() > 10
    assert np.abs(open_view.astype(int) - bare).mean() < np.abs(everything.astype(int) - bare).mean()
