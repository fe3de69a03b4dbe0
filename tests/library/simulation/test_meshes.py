"""Objects made of a person's own meshes: where they stand, how large they are, and what is refused."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from convexperc.errors import InputError
from convexperc.simulation import (
    Camera,
    ImageSize,
    Request,
    Scene,
    SceneRenderer,
    read_meshes,
    write_data_set,
)
from convexperc.simulation.objects import OBJECTS

SIZE = ImageSize(64, 48)

CORNERS = [(x, y, z) for z in (0.0, 3.0) for y in (0.0, 2.0) for x in (0.0, 1.0)]
SIDES = [(1, 3, 4, 2), (5, 6, 8, 7), (1, 2, 6, 5), (3, 7, 8, 4), (1, 5, 7, 3), (2, 4, 8, 6)]


def block(folder: Path, *, colour: tuple[int, int, int] | None = (20, 220, 40), **settings: object) -> Path:
    """Write a block of 1 x 2 x 3 units with a corner at the origin, in blue, green, red of its texture."""
    folder.mkdir(parents=True)
    lines = ["mtllib block.mtl", *(f"v {x} {y} {z}" for x, y, z in CORNERS)]
    lines += ["vt 0.5 0.5", *(f"f {' '.join(f'{k}/1' for k in side)}" for side in SIDES)]
    (folder / "block.obj").write_text("\n".join(lines) + "\n")
    if colour is not None:
        cv2.imwrite(str(folder / "paint.png"), np.full((8, 8, 3), colour, np.uint8))
    if settings:
        (folder / "object.json").write_text(json.dumps(settings))
    return folder.parent


def watched(name: str, sha256: str) -> Scene:
    reference = Camera(azimuth=0.0, distance=1.0, height=0.15)
    return Scene(name, name, 0.15, reference, (), surroundings="lab", mesh_sha256=sha256)


def test_a_mesh_is_centred_set_on_the_ground_and_scaled_to_its_namesake(tmp_path):
    found = read_meshes(block(tmp_path / "meshes" / "teapot"))["teapot"]
    room = OBJECTS["teapot"]
    assert found.scale == pytest.approx(min(room.radius / (1.25**0.5), room.height / 3))
    assert found.height <= room.height * (1 + 1e-12)
    assert found.radius == pytest.approx(found.scale * 1.25**0.5)
    np.testing.assert_allclose(found.position, [-0.5 * found.scale, -found.scale, 0.0], atol=1e-12)


def test_a_scale_and_an_axis_can_be_given(tmp_path):
    found = read_meshes(block(tmp_path / "m" / "block", scale=0.1, up="y", turn=90))["block"]
    assert (found.scale, found.height) == (0.1, pytest.approx(0.2))
    assert found.radius == pytest.approx(0.1 * 10**0.5 / 2)
    plain = read_meshes(block(tmp_path / "n" / "block"))["block"]
    assert plain.sha256 != found.sha256
    assert read_meshes(tmp_path / "n")["block"] == plain


def test_a_mesh_is_drawn_where_it_stands_with_its_texture(opengl, tmp_path):
    objects = read_meshes(block(tmp_path / "meshes" / "block", scale=0.1, turn=90))
    with SceneRenderer(watched("block", objects["block"].sha256), SIZE, objects) as renderer:
        view = renderer.view("reference", SIZE)
    rows, columns = np.nonzero(view.mask)
    # One metre away and 36 degrees high, the picture shows 0.65 m: 74 pixels a metre. After a quarter turn
    # the camera sees the side that is one unit wide, and that is nearer by half the depth.
    assert np.ptp(rows) + 1 == pytest.approx(0.3 * 74 / 0.9, abs=2)
    assert np.ptp(columns) + 1 == pytest.approx(0.1 * 74 / 0.9, abs=2)
    assert np.mean(columns) == pytest.approx(31.5, abs=1)
    red, green, blue = view.picture[view.mask > 0].mean(axis=0)
    assert green > 2 * red
    assert green > 2 * blue


def test_a_mesh_replaces_an_object_in_a_data_set(opengl, tmp_path):
    meshes = read_meshes(block(tmp_path / "meshes" / "teapot", colour=None))
    request = Request("physical", 0, 1, ("teapot",), SIZE)
    manifest = write_data_set(tmp_path / "set", request, meshes=meshes, workers=2).manifest
    assert manifest["objects"] == {"teapot": meshes["teapot"].sha256}
    assert str(tmp_path) not in (tmp_path / "set" / "manifest.json").read_text()
    with pytest.raises(InputError, match="begun with the same objects"):
        write_data_set(tmp_path / "set", request)


@pytest.mark.parametrize("sha256", ["", "0" * 64])
def test_other_meshes_than_those_of_the_description_are_refused(tmp_path, sha256):
    objects = read_meshes(block(tmp_path / "meshes" / "block"))
    with pytest.raises(InputError, match="mesh_sha256 must be"):
        SceneRenderer(watched("block", sha256), SIZE, objects)


@pytest.mark.parametrize(
    ("file", "content", "message"),
    [
        ("block.obj", b"v 0 0 0\nv 1 0\nv 0 1 0\n", "must list three corners or more"),
        ("block.obj", b"v 0 0 nan\nv 1 0 0\nv 0 1 0\n", "must list three corners or more"),
        ("block.obj", b"\xff\xfe", "must list three corners or more"),
        ("block.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\n", "must have a width and a height"),
        ("second.png", b"", "at most one PNG file"),
        ("object.json", b'{"scale": -1}', "scale must lie in"),
        ("object.json", b'{"size": 1}', "no keys but scale, up and turn"),
        ("object.json", b'{"up": "x"}', "up must be 'y' or 'z'"),
        ("object.json", b'{"turn": "left"}', "turn must be a number"),
        ("object.json", b"{", "must be a readable JSON file"),
    ],
)
def test_a_mesh_folder_that_cannot_be_used_is_refused(tmp_path, file, content, message):
    folder = block(tmp_path / "meshes" / "block")
    (folder / "block" / file).write_bytes(content)
    with pytest.raises(InputError, match=message):
        read_meshes(folder)


def test_an_absent_an_empty_and_an_ill_named_folder_are_refused(tmp_path):
    with pytest.raises(InputError, match="must be a readable folder"):
        read_meshes(tmp_path / "absent")
    with pytest.raises(InputError, match="must hold a folder for each object"):
        read_meshes(tmp_path)
    (tmp_path / "My Mesh").mkdir()
    with pytest.raises(InputError, match="mesh folder must be letters"):
        read_meshes(tmp_path)


def test_a_mesh_without_faces_or_a_damaged_texture_is_an_error(opengl, tmp_path):
    for name, file, content in (
        ("faces", "block.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 1\nf 1 2 9\n"),
        ("paint", "paint.png", b"PNG"),
    ):
        folder = block(tmp_path / name / "block")
        (folder / "block" / file).write_bytes(content)
        objects = read_meshes(folder)
        with pytest.raises(InputError, match="must be such that MuJoCo can load it"):
            SceneRenderer(watched("block", objects["block"].sha256), SIZE, objects)
