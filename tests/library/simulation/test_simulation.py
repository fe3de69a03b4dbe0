"""The committed sample, the way to OpenGL, and what a scene looks like when it is drawn."""

import ctypes.util
import hashlib
import importlib.resources
import importlib.util
import json
import pickle
from dataclasses import asdict, replace
from typing import Any

import cv2
import numpy as np
import pytest

from convexperc.errors import InputError, MissingExtraError
from convexperc.simulation import (
    GRAY_CAR,
    LIGHTS,
    OBJECTS_OF,
    SCENES,
    Camera,
    ImageSize,
    Obstacle,
    RenderingError,
    Request,
    Robot,
    Scene,
    SceneRenderer,
    scene_of_record,
    write_data_set,
)
from convexperc.simulation.backends import choose_backend
from convexperc.simulation.case_study import GOOD_VIEWS, is_good
from convexperc.simulation.effects import apply_effects
from convexperc.simulation.mujoco_xml import Group

SAMPLE = importlib.resources.files("convexperc") / "sample"
RECORD: dict[str, Any] = json.loads((SAMPLE / "manifest.json").read_text(encoding="utf-8"))
VIEWS = [*RECORD["references"], *(view for scene in RECORD["scenes"] for view in scene["views"])]
FILES = {view["file"]: view["sha256"] for view in VIEWS}
FILES |= {view["mask"]: view["mask_sha256"] for view in VIEWS}
FILES |= {scene["overhead"]: scene["overhead_sha256"] for scene in RECORD["scenes"]}

LARGEST_SAMPLE = 500_000
"""Bytes that the sample may add to the package."""

MEAN_TOLERANCE = 0.5
"""Mean difference in grey levels (of 255) of a picture drawn by another engine. Rasterisers place edges and
shadows a fraction of a sample apart: Mesa's softpipe differs from its llvmpipe by 0.25 at most, while turning
the object by one degree changes the references by 0.8 and more."""

SHARE_TOLERANCE = 0.01
"""Difference in the visible share on another engine, for the same reason."""

SMALL = ImageSize(64, 48)


def decode(content: bytes) -> np.ndarray:
    return cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_UNCHANGED)


def read(name: str) -> bytes:
    return SAMPLE.joinpath(*name.split("/")).read_bytes()


# The committed sample --------------------------------------------------------------------------------------


def test_the_sample_holds_exactly_the_recorded_pictures():
    with importlib.resources.as_file(SAMPLE) as folder:
        present = {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}
        size = sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())
    assert present == {"manifest.json", *FILES}
    assert size <= LARGEST_SAMPLE


@pytest.mark.parametrize("name", FILES)
def test_a_picture_has_its_recorded_hash_and_size(name):
    content = read(name)
    assert hashlib.sha256(content).hexdigest() == FILES[name]
    size = RECORD["overhead_image" if name.startswith("overhead/") else "image"]
    picture = decode(content)
    assert picture.shape[:2] == (size["height"], size["width"])
    assert picture.ndim == (2 if name.startswith("masks/") else 3)


@pytest.mark.parametrize("scene", RECORD["scenes"], ids=lambda scene: scene["name"])
def test_each_scene_has_three_good_views_of_five(scene):
    name = scene["name"]
    assert [view["file"] for view in scene["views"]] == [f"views/{name}/robot-{k}.png" for k in range(1, 6)]
    good = [is_good(scene["object"], view["azimuth"], view["obstruction"]) for view in scene["views"]]
    assert sum(good) == GOOD_VIEWS
    assert {view["obstruction"] for view in scene["views"]} == {"none", "partial", "full"}


@pytest.mark.parametrize("view", VIEWS, ids=lambda view: view["file"])
def test_a_mask_shows_as_much_of_the_object_as_is_said(view):
    mask = decode(read(view["mask"]))
    assert set(np.unique(mask).tolist()) <= {0, 255}
    assert bool(mask.any()) == (view.get("visible_share", 1.0) > 0.0)


def test_the_record_describes_the_scenes_as_they_are_now():
    for recorded, scene in zip(RECORD["scenes"], SCENES, strict=True):
        assert scene_of_record(recorded["description"], recorded["name"]) == scene
    assert RECORD["engine"].keys() == {"mujoco", "backend", "renderer", "opengl"}


def test_the_sample_can_be_made_again(opengl, tmp_path):
    request = Request("case-study", 0, 1, OBJECTS_OF["case-study"], ImageSize(192, 144))
    manifest = json.loads(json.dumps(write_data_set(tmp_path, request).manifest))
    # EGL and OSMesa hand out the same renderer, so the way to it does not matter.
    same = {**asdict(opengl), "backend": ""} == {**RECORD["engine"], "backend": ""}
    for name in FILES:
        here, there = decode((tmp_path / name).read_bytes()), decode(read(name))
        difference = np.abs(here.astype(int) - there.astype(int))
        assert difference.mean() <= (0.0 if same else MEAN_TOLERANCE), name
    for new, old in zip(manifest["scenes"], RECORD["scenes"], strict=True):
        assert new["description"] == old["description"]
        for a, b in zip(new["views"], old["views"], strict=True):
            gap = abs(a["visible_share"] - b["visible_share"])
            assert gap <= (0.0 if same else SHARE_TOLERANCE), (new["name"], a["name"])
            assert a["obstruction"] == b["obstruction"], (new["name"], a["name"])


# The way to OpenGL -----------------------------------------------------------------------------------------


def test_without_mujoco_the_error_names_the_extra(monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(MissingExtraError, match=r"convexperc\[sim\]"):
        SceneRenderer(GRAY_CAR, SMALL)


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


# Effects ---------------------------------------------------------------------------------------------------

CAMERA = Camera(azimuth=0.0, distance=1.0, height=0.2)
RAMP = np.linspace(0.0, 255.0, 60 * 80 * 3).reshape(60, 80, 3)


def test_a_camera_without_effects_only_rounds():
    np.testing.assert_array_equal(apply_effects(RAMP, CAMERA, "robot-1", 0), np.rint(RAMP).astype(np.uint8))


def test_noise_depends_on_the_seed_and_the_camera_and_is_as_strong_as_said():
    noisy = replace(CAMERA, noise=4.0)
    middle = np.full((60, 80, 3), 128.0)
    first = apply_effects(middle, noisy, "robot-1", 7)
    np.testing.assert_array_equal(first, apply_effects(middle, noisy, "robot-1", 7))
    assert (first != apply_effects(middle, noisy, "robot-2", 7)).any()
    assert (first != apply_effects(middle, noisy, "robot-1", 8)).any()
    assert first.std() == pytest.approx(4.0, rel=0.05)
    assert first.mean() == pytest.approx(128.0, abs=0.2)


def test_exposure_scales_the_light_and_blur_spreads_it():
    # Half of sRGB's greatest light is level 188; a stop more doubles it, a stop less halves it again.
    level = np.full((16, 16, 3), 187.516)
    assert (apply_effects(level, replace(CAMERA, exposure=1.0), "c", 0) == 255).all()
    assert (apply_effects(level, replace(CAMERA, exposure=-1.0), "c", 0) == 137).all()
    point = np.zeros((33, 33, 3))
    point[16, 16] = 255.0
    spread = apply_effects(point, replace(CAMERA, blur=1.5), "c", 0)
    assert (spread > 0).sum() > 27 * 3
    assert spread[16, 16, 0] == spread.max() < 255
    np.testing.assert_array_equal(spread, spread[::-1, ::-1])


# Pictures --------------------------------------------------------------------------------------------------


def watched(*obstacles: Obstacle, **changes: Any) -> Scene:
    """A traffic cone in the lab, one rover that looks at it and one behind it."""
    eyes = (Camera(azimuth=0.0, distance=1.0, height=0.2), Camera(azimuth=165.0, distance=1.3, height=0.25))
    return Scene(
        name="watched",
        object="traffic-cone",
        target_height=0.18,
        reference=Camera(azimuth=0.0, distance=1.0, height=0.2),
        robots=tuple(Robot("rover", eye) for eye in eyes),
        obstacles=obstacles,
        surroundings="lab",
        **changes,
    )


def wall(width: float, height: float = 0.9, azimuth: float = 0.0) -> Obstacle:
    return Obstacle("wall", azimuth=azimuth, distance=0.5, width=width, height=height)


def test_a_wall_in_front_hides_all_and_half_a_wall_about_half(opengl):
    with SceneRenderer(watched(), SMALL) as renderer:
        clear = renderer.view("robot-1", SMALL)
    with SceneRenderer(watched(wall(1.5)), SMALL) as renderer:
        hidden, behind = renderer.view("robot-1", SMALL), renderer.view("robot-2", SMALL)
    # The near edge of a wall of one metre, half a metre to one side, runs through the middle of the picture.
    half_wall = Obstacle("wall", azimuth=45.0, distance=0.5 * 2**0.5, width=1.0, height=0.9, turn=-45.0)
    with SceneRenderer(watched(half_wall), SMALL) as renderer:
        half = renderer.view("robot-1", SMALL)
    assert (clear.visible_share, hidden.visible_share, behind.visible_share) == (1.0, 0.0, 1.0)
    assert not hidden.mask.any()
    assert half.visible_share == pytest.approx(0.5, abs=0.12)
    kept = np.flatnonzero(half.mask.any(axis=0))
    assert np.ptp(kept) < 0.7 * np.ptp(np.flatnonzero(clear.mask.any(axis=0)))
    assert ((half.mask > 0) <= (clear.mask > 0)).all()


def test_the_mask_is_where_the_object_changes_the_picture(opengl):
    frame = ImageSize(64, 48, 3)
    # Without shadows and with light from everywhere, the object changes no pixel but its own.
    light = replace(LIGHTS["bright"], sun=(0.0, 0.0, 0.0), fill=(0.0, 0.0, 0.0), ambient=(0.9, 0.9, 0.9))
    with SceneRenderer(watched(light=light), frame) as renderer:
        view = renderer.view("robot-1", frame)
        empty = renderer.picture("robot-1", frame, (Group.SURROUNDINGS, Group.ROBOTS))
    difference = np.abs(view.picture.astype(int) - empty).max(axis=2)
    inside = cv2.erode(view.mask, np.ones((3, 3), np.uint8)) > 0
    outside = cv2.dilate(view.mask, np.ones((3, 3), np.uint8)) == 0
    assert inside.sum() > 100
    assert (difference[inside] > 8).mean() > 0.95
    assert difference[outside].max() == 0


def test_the_same_description_gives_the_same_pixels(opengl):
    scene = watched(wall(0.2, 0.2))
    noisy = replace(
        scene.robots[0], camera=replace(scene.robots[0].camera, noise=3.0, exposure=0.3, blur=0.4)
    )
    scene = replace(scene, robots=(noisy, scene.robots[1]))
    frame = ImageSize(80, 60)
    drawn = []
    for _ in range(2):
        with SceneRenderer(scene, frame) as renderer:
            drawn += [renderer.view("robot-1", frame), renderer.view("robot-1", frame)]
    assert all(np.array_equal(view.picture, drawn[0].picture) for view in drawn)
    assert all(np.array_equal(view.mask, drawn[0].mask) for view in drawn)
    with SceneRenderer(replace(scene, seed=1), frame) as renderer:
        other = renderer.view("robot-1", frame)
    assert (other.picture != drawn[0].picture).any()
    np.testing.assert_array_equal(other.mask, drawn[0].mask)


def test_robots_see_each_other_and_the_light_colours_the_scene(opengl):
    with SceneRenderer(watched(), SMALL) as renderer:
        bright = renderer.picture("robot-1", SMALL)
        alone = renderer.picture("robot-1", SMALL, (Group.OBJECT, Group.SURROUNDINGS))
    assert (bright != alone).any()
    means = {}
    for name in LIGHTS:
        with SceneRenderer(watched(light=LIGHTS[name]), SMALL) as renderer:
            means[name] = renderer.picture("robot-1", SMALL).reshape(-1, 3).mean(axis=0)
    red, green, blue = means["bright"]
    assert means["dim"].mean() < 0.65 * means["bright"].mean()
    assert means["warm"][0] / means["warm"][2] > 1.2 * red / blue
    assert means["green"][1] / means["green"][0] > 1.2 * green / red


def test_what_cannot_be_drawn_is_an_error(opengl):
    away = Robot("rover", Camera(azimuth=0.0, distance=1.0, height=0.2, pan=80.0))
    with SceneRenderer(replace(watched(), robots=(away,)), SMALL) as renderer:
        for camera, error, message in (
            ("robot-9", InputError, "camera must be one of reference, overhead, robot-1"),
            ("robot-1", RenderingError, "must contain a part of the object"),
        ):
            with pytest.raises(error, match=message):
                renderer.view(camera, SMALL)
    with pytest.raises(InputError, match="object must be one of red-car"):
        SceneRenderer(replace(watched(), object="unicorn"), SMALL)
