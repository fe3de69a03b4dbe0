"""The models of which scenes are made: objects, robots, obstacles, surroundings."""

from collections import Counter
from dataclasses import replace
from itertools import chain

import numpy as np
import pytest

from convexperc.errors import InputError
from convexperc.simulation.extents import surface_points
from convexperc.simulation.lab import ROOM_SIDE
from convexperc.simulation.materials import MATERIALS, TEXTURED, Material, Pattern
from convexperc.simulation.objects import CASE_STUDY, OBJECTS, PHYSICAL, Model, model
from convexperc.simulation.obstacles import OBSTACLES
from convexperc.simulation.parts import Part, blob, box, disc, mirrored, rod
from convexperc.simulation.pose import placed
from convexperc.simulation.robots import ROBOTS
from convexperc.simulation.skins import hull, rounded, swept, turned
from convexperc.simulation.surroundings import SURROUNDINGS

SKINS = {
    "turned": turned("pot", [(0.1, 0.0), (0.1, 0.2), (0.1, 0.2), (0.0, 0.5)]),
    "turned-x": turned("pot", [(0.1, 0.0), (0.05, 0.2)], (1.0, 2.0, 3.0), axis="x"),
    "turned-y": turned("pot", [(0.0, 0.0), (0.1, 0.1), (0.0, 0.2)], axis="y"),
    "swept": swept("steel", [(0.0, 0.0, 0.0), (0.0, 0.1, 0.3), (0.2, 0.1, 0.4)], (0.02, 0.03, 0.01)),
    "rounded": rounded("duck", [(-0.1, 0.0, 0.0, 0.0), (0.0, 0.05, 0.2, 0.1), (0.2, 0.0, 0.1, 0.1)]),
}
EVERYTHING: dict[str, tuple[Part, ...]] = {
    **{name: one.parts for name, one in OBJECTS.items()},
    **{name: tuple(build(0.6)) for name, build in ROBOTS.items()},
    **{name: tuple(build(1.1, 1.3)) for name, build in OBSTACLES.items()},
    **{name: place.parts for name, place in SURROUNDINGS.items()},
}


def defects(skin: Part) -> list[str]:
    """Say what is wrong with a skin of triangles; corners at the same place count as one."""
    _, same = np.unique(np.round(skin.vertices, 9), axis=0, return_inverse=True)
    faces = same.reshape(-1)[np.array(skin.faces)]
    edges = Counter((face[k], face[(k + 1) % 3]) for face in faces.tolist() for k in range(3))
    found = []
    if set(edges.values()) != {1}:
        found.append("an edge is used twice in one direction")
    if not all((b, a) in edges for a, b in edges):
        found.append("there is a hole")
    if np.linalg.det(np.array(skin.vertices)[np.array(skin.faces)]).sum() <= 0:
        found.append("it faces inwards")
    return found


def turning(angles: tuple[float, float, float]) -> np.ndarray:
    """MuJoCo's default Euler angles: about x, then the turned y, then the turned z."""
    a, b, c = np.radians(angles)
    about_x = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
    about_y = np.array([[np.cos(b), 0, np.sin(b)], [0, 1, 0], [-np.sin(b), 0, np.cos(b)]])
    about_z = np.array([[np.cos(c), -np.sin(c), 0], [np.sin(c), np.cos(c), 0], [0, 0, 1]])
    return about_x @ about_y @ about_z


def reach(part: Part, direction: np.ndarray) -> np.ndarray:
    """Largest coordinate of a part along unit vectors, shape (n, 3), from the formula of its shape."""
    if part.shape == "mesh":
        return (direction @ np.array(part.vertices).T).max(axis=1)
    local, size = direction @ turning(part.rotation), np.array(part.size)
    along = np.abs(local[:, 2])
    across = np.hypot(local[:, 0], local[:, 1])
    own = {
        "box": lambda: np.abs(local) @ size,
        "ellipsoid": lambda: np.linalg.norm(local * size, axis=1),
        "cylinder": lambda: size[0] * across + size[1] * along,
        "capsule": lambda: size[0] + size[1] * along,
    }[part.shape]()
    return own + direction @ np.array(part.position)


def extent(parts: tuple[Part, ...], *direction: float) -> float:
    return float(max(reach(part, np.array([direction]))[0] for part in parts))


# Parts and skins -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", EVERYTHING)
def test_every_skin_is_closed_and_faces_outwards(name):
    assert [part for part in EVERYTHING[name] if part.faces and defects(part)] == []


@pytest.mark.parametrize("name", SKINS)
def test_a_skin_and_its_mirror_image_are_closed_and_face_outwards(name):
    skin = SKINS[name]
    assert defects(skin) == []
    assert defects(mirrored(skin)) == []
    assert mirrored(mirrored(skin)) == skin
    assert defects(replace(skin, faces=skin.faces[1:])) == ["there is a hole"]
    assert defects(replace(skin, faces=tuple((a, c, b) for a, b, c in skin.faces))) == ["it faces inwards"]


@pytest.mark.parametrize(
    "part",
    [
        box("steel", (0.1, 0.2, 0.3), (1.0, 2.0, 3.0), (10.0, 20.0, 30.0)),
        disc("rubber", 0.3, 0.2, (0.8, 1.0, 0.3)),
        blob("duck", (0.1, 0.2, 0.3), (0.1, 0.2, 0.3), (40.0, 10.0, 5.0)),
        hull("glass", [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)]),
    ],
)
def test_mirroring_swaps_the_sides_and_twice_changes_nothing(part: Part):
    assert mirrored(part) != part
    assert mirrored(mirrored(part)) == part
    ways = np.array([[1.0, 0.0, 0.0], [0.6, 0.0, 0.8], [0.48, 0.64, 0.6]])
    np.testing.assert_allclose(reach(mirrored(part), ways), reach(part, ways * [-1, 1, 1]), atol=1e-12)


def test_a_turned_body_lies_on_its_profile_and_has_its_volume():
    cone = turned("cone", [(0.3, 0.1), (0.0, 0.7)], (1.0, 2.0, 0.0), steps=256)
    corners = np.array(cone.vertices) - [1.0, 2.0, 0.0]
    radius = np.hypot(corners[:, 0], corners[:, 1])
    foot = np.isclose(corners[:, 2], 0.1)
    np.testing.assert_allclose(radius[~foot], 0.5 * (0.7 - corners[~foot, 2]), atol=1e-12)
    assert set(np.round(radius[foot], 9)) == {0.0, 0.3}
    volume = np.linalg.det(np.array(cone.vertices)[np.array(cone.faces)]).sum() / 6
    assert volume == pytest.approx(np.pi * 0.3**2 * 0.6 / 3, rel=1e-3)


def test_a_tube_ends_where_its_path_does_and_keeps_its_radius():
    tube = swept("steel", [(0.0, 0.0, 0.0), (0.0, 0.5, 0.0), (0.0, 1.0, 0.0)], 0.1, steps=48)
    corners = np.array(tube.vertices)
    assert np.ptp(corners[:, 1]) == pytest.approx(1.0)
    assert set(np.round(np.hypot(corners[:, 0], corners[:, 2]), 9)) == {0.0, 0.1}


@pytest.mark.parametrize("end", [(0.3, 0.4, 0.5), (0.0, 0.0, -1.0), (0.0, 1.0, 0.0), (-1.0, 0.2, 0.1)])
def test_a_rod_runs_from_its_start_to_its_end(end):
    start = np.array([0.1, -0.2, 0.3])
    one = rod("steel", 0.01, tuple(start.tolist()), tuple((start + end).tolist()))
    half = turning(one.rotation) @ [0.0, 0.0, one.size[1]]
    np.testing.assert_allclose(np.array(one.position) - half, start, atol=1e-12)
    np.testing.assert_allclose(np.array(one.position) + half, start + end, atol=1e-12)


@pytest.mark.parametrize("shape", ["box", "disc", "blob", "capsule", "mesh"])
@pytest.mark.parametrize("rotation", [(0.0, 0.0, 90.0), (0.0, 90.0, 0.0), (20.0, -50.0, 130.0)])
def test_a_placed_part_reaches_as_far_as_the_turned_original(shape, rotation):
    part = {
        "box": box("steel", (0.1, 0.2, 0.3), (1.0, 2.0, 3.0), (10.0, 20.0, 30.0)),
        "disc": disc("rubber", 0.3, 0.2, (0.8, 1.0, 0.3)),
        "blob": blob("duck", (0.1, 0.2, 0.3), (0.1, 0.2, 0.3), (0.0, -90.0, 25.0)),
        "capsule": Part("capsule", "steel", (0.1, 0.4), (0.1, 0.0, 0.5), (70.0, 10.0, 0.0)),
        "mesh": SKINS["swept"],
    }[shape]
    [moved] = placed([part], (0.5, -0.25, 1.0), rotation)
    ways = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.48, -0.64, 0.6]])
    expected = reach(part, ways @ turning(rotation)) + ways @ [0.5, -0.25, 1.0]
    np.testing.assert_allclose(reach(moved, ways), expected, atol=1e-9)
    np.testing.assert_allclose((surface_points(moved) @ ways.T).max(axis=0), expected, atol=2e-3)


@pytest.mark.parametrize("name", EVERYTHING)
def test_every_part_has_positive_extents_and_a_known_paint(name):
    for part in EVERYTHING[name]:
        assert (min(part.size) > 0) if part.shape != "mesh" else (len(part.vertices) > 3), part
        assert part.material in MATERIALS or part.material in TEXTURED, part.material


# Objects ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", OBJECTS)
def test_an_object_stands_on_the_floor_and_fills_its_cylinder(name):
    one = OBJECTS[name]
    angle = np.linspace(0.0, 2 * np.pi, 721)
    around = np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=-1)
    radius = max(reach(part, around).max() for part in one.parts)
    assert one.radius == pytest.approx(radius, rel=0.003)
    assert one.height == pytest.approx(extent(one.parts, 0.0, 0.0, 1.0), rel=0.002)
    assert extent(one.parts, 0.0, 0.0, -1.0) == pytest.approx(0.0, abs=0.004 * one.height)


def test_objects_are_known_by_distinct_names():
    names = [one.name for one in CASE_STUDY + PHYSICAL]
    assert list(OBJECTS) == names
    assert len(set(names)) == len(names) == 3 + 8
    assert all(OBJECTS[name].name == name for name in names)


@pytest.mark.parametrize("one", PHYSICAL, ids=lambda one: one.name)
def test_a_thing_in_the_lab_is_toy_sized_about_the_origin_and_made_of_few_parts(one):
    assert 0.12 <= one.height <= 0.6
    assert 0.12 <= 2 * one.radius <= 0.8
    assert len(one.parts) < 60
    for a, b in ((1.0, 0.0), (0.0, 1.0)):
        there, back = extent(one.parts, a, b, 0.0), extent(one.parts, -a, -b, 0.0)
        assert abs(there - back) <= 0.15 * (there + back), "it must stand in the middle"


@pytest.mark.parametrize(
    "make",
    [
        lambda: model("nothing", []),
        lambda: Model("nothing", (), 1.0, 1.0),
        lambda: replace(PHYSICAL[0], radius=float("inf")),
        lambda: replace(PHYSICAL[0], height=0.0),
        lambda: Material((0.5, 0.5, 1.2)),
        lambda: Material((0.5, 0.0, 0.5)),
        lambda: Material((0.5, 0.5, 0.5), specular=float("nan")),
        lambda: Pattern((0.5, 0.5, 0.5), (0.4, 0.4, 0.4), (0.3, 0.3, 2.0), (1.0, 1.0)),
        lambda: Pattern((0.5, 0.5, 0.5), (0.4, 0.4, 0.4), (0.3, 0.3, 0.3), (1.0, float("nan"))),
    ],
)
def test_an_absurd_model_or_paint_is_refused(make):
    with pytest.raises(InputError, match="must"):
        make()


# Robots, obstacles, surroundings ---------------------------------------------------------------------------


@pytest.mark.parametrize(("name", "heights"), [("husky", (0.7, 1.2)), ("rover", (0.12, 0.2, 0.3))])
def test_a_robot_stands_on_the_floor_and_does_not_see_itself(name, heights):
    for height in heights:
        parts = tuple(ROBOTS[name](height))
        assert min(chain.from_iterable(part.size for part in parts)) > 0
        assert extent(parts, 0.0, 0.0, -1.0) == pytest.approx(0.0, abs=1e-6)
        towards = np.concatenate([surface_points(part) for part in parts]) - [0.0, 0.0, height]
        ahead = towards[towards[:, 0] < 0]
        elevation = np.degrees(np.arctan2(np.abs(ahead[:, 2]), -ahead[:, 0]))
        assert elevation.min() > 40, "a part of the robot stands in front of its lens"


def test_a_rover_is_about_a_quarter_of_a_metre_long_and_carries_its_lens_on_top():
    parts = tuple(ROBOTS["rover"](0.2))
    assert extent(parts, 1.0, 0.0, 0.0) + extent(parts, -1.0, 0.0, 0.0) == pytest.approx(0.25, abs=0.04)
    assert extent(parts, 0.0, 0.0, 1.0) == pytest.approx(0.2, abs=0.03)


@pytest.mark.parametrize("kind", OBSTACLES)
@pytest.mark.parametrize(
    "size", [(0.05, 0.05), (0.2, 0.2), (0.2, 0.6), (0.32, 0.32), (1.0, 0.7), (20.0, 20.0)]
)
def test_an_obstacle_of_any_allowed_size_stands_on_the_floor_and_is_as_large_as_asked(kind, size):
    width, height = size
    parts = tuple(OBSTACLES[kind](width, height))
    assert min(chain.from_iterable(part.size for part in parts)) > 0
    assert extent(parts, 0.0, 0.0, -1.0) == pytest.approx(0.0, abs=1e-6)
    assert extent(parts, 0.0, 0.0, 1.0) == pytest.approx(height, abs=0.005)
    rim = 0.1 if kind == "wall" else 0.005
    for way in (-1.0, 1.0):
        assert width / 2 - 0.005 <= extent(parts, 0.0, way, 0.0) <= width / 2 + rim


def test_the_lab_leaves_the_floor_free_for_the_robots():
    floor, *furniture = SURROUNDINGS["lab"].parts
    assert extent((floor,), 0.0, 0.0, 1.0) == 0.0
    points = np.concatenate([surface_points(part) for part in furniture])
    assert np.abs(points[:, :2]).max(axis=1).min() > 1.75
    assert np.abs(points[:, :2]).max() <= ROOM_SIDE / 2 + 0.2
    assert points[:, 2].min() > -1e-6


def test_each_wall_of_the_lab_has_another_background():
    angle = np.degrees
    seen = {}
    for azimuth in (0, 90, 180, 270):
        paints: Counter[str] = Counter()
        for part in SURROUNDINGS["lab"].parts[1:]:
            x, y, _ = part.position
            if abs((angle(np.arctan2(y, x)) - azimuth + 180) % 360 - 180) < 45:
                paints[part.material] += 1
        seen[azimuth] = frozenset(paints)
    assert len(set(seen.values())) == 4
    walls = [{paint for paint in paints if paint.startswith("wall-")} for paints in seen.values()]
    assert sorted(map(len, walls)) == [1, 1, 1, 1]
    assert len(set.union(*walls)) == 4


def test_every_paint_is_used_and_the_ground_lies_under_the_floor():
    used = {part.material for parts in EVERYTHING.values() for part in parts}
    used |= {place.ground for place in SURROUNDINGS.values()}
    assert used == MATERIALS.keys() | TEXTURED.keys()
    assert all(place.ground_height < 0 for place in SURROUNDINGS.values())
    assert all(place.ground in TEXTURED for place in SURROUNDINGS.values())
