"""Scenes as data: their JSON, their MJCF, their geometry, and how they are proposed."""

import json
import re
import xml.etree.ElementTree as ET
from dataclasses import replace
from itertools import islice

import numpy as np
import pytest

from convexperc.errors import FileFormatError, InputError
from convexperc.files import json_bytes
from convexperc.simulation import (
    LIGHTS,
    OBJECTS_OF,
    RED_CAR,
    SCENES,
    Camera,
    ImageSize,
    Obstacle,
    Request,
    Robot,
    Scene,
    case_study,
    mjcf,
    physical,
    read_scene,
    scene_of_record,
    scene_record,
)
from convexperc.simulation.case_study import is_good
from convexperc.simulation.mujoco_xml import SHADOWS
from convexperc.simulation.objects import OBJECTS
from convexperc.simulation.placing import stand_apart
from convexperc.simulation.proposing import LIGHT_SHARES, Plan, obstruction
from convexperc.simulation.setting import LAB, PARK
from convexperc.simulation.surroundings import SURROUNDINGS

ROVER = Robot("rover", Camera(azimuth=-170.25, distance=0.9, height=0.2, noise=1.5, exposure=-0.1, blur=0.3))
IN_LAB = Scene(
    name="duck-7",
    object="rubber-duck",
    target_height=0.1,
    reference=Camera(azimuth=0.0, distance=0.8, height=0.2),
    robots=(ROVER,),
    obstacles=(Obstacle("box", azimuth=10.0, distance=0.4, width=0.2, height=0.3, turn=-3.0),),
    surroundings="lab",
    turn=33.0,
    light=replace(LIGHTS["green"], azimuth=1.0),
    seed=2**40,
)


@pytest.mark.parametrize("scene", [*SCENES, IN_LAB], ids=lambda scene: scene.name)
def test_a_description_comes_back_exactly_from_its_json(scene, tmp_path):
    path = tmp_path / "scene.json"
    path.write_bytes(json_bytes(scene_record(scene)))
    assert read_scene(path) == scene
    assert scene_of_record(scene_record(read_scene(path)), "again") == scene


def changed(record, keys, value):
    """The record with another value in the place that the keys lead to."""
    copy = json.loads(json.dumps(record))
    inner = copy
    for key in keys[:-1]:
        inner = inner[key]
    inner[keys[-1]] = value
    return copy


@pytest.mark.parametrize(
    ("keys", "value", "message"),
    [
        (["colour"], "red", "must have no keys but name, object"),
        (["robots", 0, "camera", "zoom"], 1.0, r"robots\[0\]: camera must have no keys but azimuth"),
        (["robots"], {}, "robots must be a list"),
        (["robots", 0, "camera", "azimuth"], "north", "azimuth must be a number; got 'north'"),
        (["robots", 0, "camera", "azimuth"], True, "azimuth must be a number; got True"),
        (["robots", 0, "camera", "height"], 0.2, "lens height of a husky must lie in"),
        (["robots", 0, "kind"], "drone", r"robots\[0\]: kind must be one of husky, rover"),
        (["obstacles", 0, "kind"], "hedge", r"obstacles\[0\]: kind must be one of crate"),
        (["light", "sun"], [1.0, 1.0], "sun must be a list of 3 entries"),
        (["light", "elevation"], -3.0, "elevation must lie in"),
        (["surroundings"], "moon", "surroundings must be one of park, lab"),
        (["seed"], 0.5, "seed must be of type int"),
        (["seed"], -1, "seed must lie in"),
        (["name"], "../up", "scene must be letters"),
        (["schema"], "convexperc/scene/0", "schema must be 'convexperc/scene/1'"),
    ],
)
def test_a_wrong_description_is_refused_with_the_place_in_it(keys, value, message):
    with pytest.raises(FileFormatError, match=message):
        scene_of_record(changed(scene_record(RED_CAR), keys, value), "scene.json")


@pytest.mark.parametrize("key", list(scene_record(RED_CAR)))
def test_a_missing_key_is_an_error(key):
    record = {name: value for name, value in scene_record(RED_CAR).items() if name != key}
    with pytest.raises(FileFormatError, match=key):
        scene_of_record(record, "scene.json")


@pytest.mark.parametrize(
    "make",
    [
        lambda: Camera(azimuth=float("nan"), distance=6.0, height=1.0),
        lambda: Camera(azimuth=0.0, distance=0.0, height=1.0),
        lambda: Camera(azimuth=0.0, distance=6.0, height=1.0, field_of_view=180.0),
        lambda: Camera(azimuth=0.0, distance=6.0, height=1.0, noise=-1.0),
        lambda: Robot("rover", Camera(azimuth=0.0, distance=6.0, height=1.0)),
        lambda: Obstacle("crate", azimuth=0.0, distance=3.0, width=0.0, height=1.0),
        lambda: Obstacle("wall", azimuth=0.0, distance=3.0, width=1.0, height=float("inf")),
        lambda: replace(LIGHTS["dim"], ambient=(0.1, 0.1, 9.0)),
        lambda: ImageSize(0, 10),
        lambda: ImageSize(4096, 10, 4),
        lambda: Request("physical", 0, 1, (), ImageSize(64, 48)),
        lambda: Request("physical", 0, 1, ("a", "a"), ImageSize(64, 48)),
        lambda: Request("physical", -1, 1, ("a",), ImageSize(64, 48)),
        lambda: Request("physical", 0, 0, ("a",), ImageSize(64, 48)),
    ],
)
def test_an_absurd_value_is_refused(make):
    with pytest.raises(InputError, match="must"):
        make()


@pytest.mark.parametrize("scene", [*SCENES, IN_LAB], ids=lambda scene: scene.name)
def test_mjcf_is_well_formed_and_every_reference_in_it_resolves(scene):
    root = ET.fromstring(mjcf(scene).xml)
    materials = {material.get("name") for material in root.iterfind("asset/material")}
    meshes = {mesh.get("name") for mesh in root.iterfind("asset/mesh")}
    assert {geom.get("material") for geom in root.iter("geom")} <= materials
    assert {geom.get("mesh") for geom in root.iter("geom") if geom.get("type") == "mesh"} == meshes
    bodies = [body.get("name") for body in root.iterfind("worldbody/body")]
    obstacles = [f"obstacle-{k}" for k in range(1, len(scene.obstacles) + 1)]
    assert bodies == ["surroundings", "object", *obstacles, *scene.views()]
    for size in (geom.get("size") for geom in root.iterfind("worldbody/body/geom") if geom.get("size")):
        assert min(map(float, size.split())) > 0, size


@pytest.mark.parametrize("scene", [*SCENES, IN_LAB], ids=lambda scene: scene.name)
def test_mjcf_places_each_camera_on_its_ring(scene):
    root = ET.fromstring(mjcf(scene).xml)
    written = {camera.get("name"): camera for camera in root.iterfind("worldbody/camera")}
    assert written.keys() == scene.cameras().keys()
    for name, camera in scene.cameras().items():
        x, y, z = map(float, written[name].get("pos").split())
        assert np.hypot(x, y) == pytest.approx(camera.distance, abs=1e-5)
        off = np.degrees(np.arctan2(y, x)) - camera.azimuth
        assert (off + 180) % 360 - 180 == pytest.approx(0, abs=1e-3)
        assert z == pytest.approx(camera.height)


def test_every_place_has_shadows_and_every_light_a_share():
    assert SHADOWS.keys() == SURROUNDINGS.keys()
    assert LIGHT_SHARES.keys() == LIGHTS.keys()
    assert sum(LIGHT_SHARES.values()) == pytest.approx(1.0)


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


@pytest.mark.parametrize(("azimuth", "bearing"), [(-180.0, 180.0), (190.0, -170.0), (360.0, 0.0), (7.5, 7.5)])
def test_a_bearing_lies_in_the_half_open_circle(azimuth, bearing):
    assert Camera(azimuth=azimuth, distance=1.0, height=1.0).bearing() == bearing


@pytest.mark.parametrize(
    ("share", "found"),
    [(0.0, "full"), (0.05, "full"), (0.051, "partial"), (0.899, "partial"), (0.9, "none"), (1.0, "none")],
)
def test_the_limits_of_obstruction(share, found):
    assert obstruction(share) == found


@pytest.mark.parametrize(
    ("name", "bearing", "hidden", "good"),
    [
        ("red-car", 40.0, "none", True),
        ("red-car", 41.0, "none", False),
        ("red-car", -141.0, "none", True),
        ("ica-sign", -141.0, "none", False),
        ("ica-sign", 0.0, "partial", False),
    ],
)
def test_a_good_view_is_a_clear_one_from_the_side_one_knows(name, bearing, hidden, good):
    assert is_good(name, bearing, hidden) is good


@pytest.mark.parametrize(
    ("propose", "name", "level", "setting"),
    [
        (physical.proposals, "helicopter", "two full, two partial", LAB),
        (physical.proposals, "teapot", "one full", LAB),
        (case_study.proposals, "ica-sign", "case study", PARK),
    ],
)
def test_proposals_are_determined_by_the_seed_and_keep_things_apart(propose, name, level, setting):
    thing = OBJECTS[name]
    first, again, other = (
        list(islice(propose(Plan("some-scene", 2, level, (0, seed)), thing), 25)) for seed in (1, 1, 2)
    )
    assert first == again
    assert first != other
    found = [proposal for proposal in first if proposal is not None]
    assert found
    for proposal in found:
        scene = proposal.scene
        assert len(proposal.wanted) == len(scene.robots)
        assert stand_apart(list(scene.views().values()), scene.obstacles, setting)
        assert not stand_apart([*scene.views().values(), scene.robots[0].camera], scene.obstacles, setting)


def test_the_levels_of_obstruction_are_those_that_are_asked_for():
    for level in physical.LEVELS:
        plan = Plan("cone-1", 1, level.name, (3, 4))
        found = islice(physical.proposals(plan, OBJECTS["traffic-cone"]), 20)
        for proposal in (one for one in found if one is not None):
            counts = [proposal.wanted.count(kind) for kind in ("partial", "full", "none")]
            assert counts == [level.partial, level.full, 6 - level.partial - level.full]


def test_a_plan_does_not_depend_on_what_else_is_asked_for():
    whole = dict(Request("physical", 5, 2, OBJECTS_OF["physical"], ImageSize(64, 48)).plans())
    part = Request("physical", 5, 2, ("teapot",), ImageSize(160, 120)).plans()
    assert dict(part)["teapot"] == whole["teapot"]
    titles = [
        plan.name for _, plan in Request("physical", 0, 6, OBJECTS_OF["physical"], ImageSize(64, 48)).plans()
    ]
    assert len(set(titles)) == len(titles) == 8 * 5 * 6
    assert all(re.fullmatch(r"[a-z-]+-[1-5]-0[1-6]", title) for title in titles)
