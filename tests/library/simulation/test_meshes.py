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
    unread_meshes,
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


NOTCHED = b"v 1 0 0\nv 1 2 0\nv 1 2 3\nv 1 1 .5\nv 1 0 3\nf 3 4 5 1 2\n"
"""A polygon with a notch: cut into a fan from its first corner, it would be filled."""


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
    with pytest.raises(
        InputError, match=r"mesh_sha256 must be .* copy the hash into the description if these"
    ):
        SceneRenderer(watched("block", sha256), SIZE, objects)


@pytest.mark.parametrize(
    ("file", "content", "message"),
    [
        ("block.obj", b"v 0 0 0\nv 1 0\nv 0 1 0\n", "must list three corners or more"),
        ("block.obj", b"v 0 0 nan\nv 1 0 0\nv 0 1 0\n", "must list three corners or more"),
        ("block.obj", b"\xff\xfe", "must list three corners or more"),
        ("block.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "must have a width and a height"),
        ("block.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 1\n", r"must have a face .*got '3 vertices'"),
        ("block.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 1\nl 1 2\np 3\n", "must have a face"),
        ("block.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 1\nf 1 2 9\n", "vertices that there are, at most 3; got 9"),
        ("block.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 1\nf 1 2 -4\n", "by vertices that there are; got '1 2 -4'"),
        ("block.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 1\nf 0 1 2\n", "by vertices that there are"),
        ("block.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 1\nf 1 2\n", "must name three corners"),
        ("block.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 1\nf 1 2 x\n", "must name three corners"),
        ("block.obj", NOTCHED, "a face of mesh block/block.obj must be convex; got 5"),
        ("block.obj", b"v 0,0 0 0\nv 1 0 0\nv 0 1 1\nf 1 2 3\n", "must list three corners or more"),
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
    with pytest.raises(InputError, match=r"named by letters .*got \['My Mesh'\]"):
        read_meshes(tmp_path)


def test_a_folder_that_is_not_named_like_an_object_is_left_out_with_the_reason(tmp_path):
    block(tmp_path / "meshes" / "block")
    (tmp_path / "meshes" / "My Mesh").mkdir()
    assert list(read_meshes(tmp_path / "meshes")) == ["block"]
    said = "My Mesh (its name must be letters a-z and digits, joined by single hyphens, at most 64)"
    assert unread_meshes(tmp_path / "meshes") == (said,)


def test_a_damaged_texture_is_an_error(opengl, tmp_path):
    folder = block(tmp_path / "paint" / "block")
    (folder / "block" / "paint.png").write_bytes(b"PNG")
    objects = read_meshes(folder)
    with pytest.raises(InputError, match="must be such that MuJoCo can load it"):
        SceneRenderer(watched("block", objects["block"].sha256), SIZE, objects)


# Forms of OBJ files: what is drawn is what the file says, by its silhouette and its colours -------------

VERTICES = "".join(f"v {x} {y} {z}\n" for x, y, z in CORNERS)
FACES = [f"f {' '.join(map(str, side))}\n" for side in SIDES]
PAINTED = "vt .5 .5\n" + "".join(f"f {' '.join(f'{k}/1' for k in side)}\n" for side in SIDES)
MTL = (
    "newmtl red\nKd 0.9 0.05 0.05\nKs 1 1 1\nNs 9\nd 1.000\n"
    "newmtl blue\nKd 0.05 0.05 0.9\n"
    "newmtl photo\nKd 0 0 0\nmap_Kd skin.jpg\n"
)
FRONT = 5
"""The side towards +x, which the reference camera sees."""
GREEN = (20, 220, 40)


def picture(suffix, colour):
    """A file of one colour, blue first."""
    return cv2.imencode(suffix, np.full((8, 8, 3), colour, np.uint8))[1].tobytes()


def seen(folder, files):
    """What the reference camera sees of the files of one object: its pixels and its model."""
    place = folder / "m" / "thing"
    place.mkdir(parents=True)
    for name, content in {"object.json": '{"scale": 0.1}', **files}.items():
        (place / name).write_bytes(content if isinstance(content, bytes) else content.encode())
    objects = read_meshes(folder / "m")
    with SceneRenderer(watched("thing", objects["thing"].sha256), SIZE, objects) as renderer:
        return renderer.view("reference", SIZE), objects["thing"]


WHOLE = {
    "as it is": VERTICES + "".join(FACES),
    "one group": "o all\ng part\n" + VERTICES + "".join(FACES),
    "groups": VERTICES + "g one\n" + "".join(FACES[:3]) + "g two\n" + "".join(FACES[3:]),
    "objects": VERTICES + "o one\n" + "".join(FACES[:3]) + "o two\n" + "".join(FACES[3:]),
    "negative": VERTICES + "".join(f"f {' '.join(str(k - 9) for k in side)}\n" for side in SIDES),
    "triangles": VERTICES + "".join(f"f {a} {b} {c}\nf {a} {c} {d}\n" for a, b, c, d in SIDES),
    "a mark": "\ufeff" + VERTICES + "".join(FACES),
    "carriage returns": (VERTICES + "".join(FACES)).replace("\n", "\r\n"),
    "continued": VERTICES + "".join(FACES).replace(" ", " \\\n "),
    "indented": ("\n" + VERTICES).replace("\nv ", "\n  v\t") + "".join(FACES),
    "normals": VERTICES
    + "vn 1 0 0\n"
    + "".join(f"f {' '.join(f'{k}//1' for k in side)}\n" for side in SIDES),
    "a vertex more": VERTICES + "v 0.5 0.5 1\n" + "".join(FACES),
}


HALF = VERTICES + "vt .5 .5\nvt .2 .2\n" + "".join(FACES[:3])
HALF += "".join(f"f {' '.join(f'{k}/-1' for k in side)}\n" for side in SIDES[3:])
WHOLE["some with texture coordinates"] = HALF
WHOLE["texture coordinates of no face"] = VERTICES + "vt .5 .5\n" + "".join(FACES)


def test_texture_coordinates_of_some_faces_are_refused_where_there_is_a_texture(tmp_path):
    place = tmp_path / "thing"
    place.mkdir()
    (place / "a.obj").write_text(HALF)
    assert [piece.content.count(b"/-1") for piece in read_meshes(tmp_path)["thing"].pieces] == [0]
    (place / "paint.png").write_bytes(picture(".png", GREEN))
    with pytest.raises(InputError, match="texture coordinates on all its faces or on none"):
        read_meshes(tmp_path)
    (place / "a.obj").write_text(PAINTED.replace("vt .5 .5\n", VERTICES))
    with pytest.raises(InputError, match="must name texture coordinates that are above it, 0 in number"):
        read_meshes(tmp_path)


@pytest.mark.parametrize("form", WHOLE)
@pytest.mark.parametrize("name", ["thing.obj", "THING.OBJ"])
def test_every_face_of_an_obj_file_is_drawn(opengl, tmp_path, form, name):
    view, model = seen(tmp_path, {name: WHOLE[form]})
    rows, columns = np.nonzero(view.mask)
    size = np.count_nonzero(view.mask), np.ptp(rows) + 1, np.ptp(columns) + 1
    assert size == (384, 24, 16), (form, size)  # as a block of 0.1 x 0.2 x 0.3 m is seen from its side
    assert model.left_out == ()


def test_groups_behind_the_first_are_drawn_where_they_stand(opengl, tmp_path):
    second = "".join(f"v {x} {y + 4} {z}\n" for x, y, z in CORNERS)
    faces = "".join(f"f {' '.join(str(k + 8) for k in side)}\n" for side in SIDES)
    view, _ = seen(tmp_path, {"a.obj": f"{VERTICES}g one\n{''.join(FACES)}{second}g two\n{faces}"})
    columns = np.flatnonzero(view.mask.any(axis=0))
    # Two blocks of 16, and as much between them, where their sides are seen from between.
    assert 32 <= columns.size <= 36, columns
    assert np.ptp(columns) + 1 == 48, columns


def test_each_face_has_the_colour_or_the_texture_of_its_material(opengl, tmp_path):
    for k, (front, wanted) in enumerate({"red": 0, "blue": 2, "photo": 1}.items()):
        other = "blue" if front == "red" else "red"
        rest = "".join(FACES[:FRONT])
        mesh = f"mtllib a.mtl\n{VERTICES}vt .5 .5\nusemtl {other}\n{rest}usemtl {front}\n"
        mesh += FACES[FRONT] if front != "photo" else PAINTED.splitlines()[-1] + "\n"
        files = {"a.obj": mesh, "a.mtl": MTL, "skin.jpg": picture(".jpg", GREEN)}
        view, model = seen(tmp_path / str(k), files)
        colour = view.picture[view.mask > 0].mean(axis=0)
        assert colour.argmax() == wanted, (front, colour)
        assert colour[wanted] > 3 * np.delete(colour, wanted).max(), (front, colour)
        unused = ["thing/skin.jpg (not used)"] if front != "photo" else []
        assert list(model.left_out) == unused, model.left_out


def test_a_common_png_colours_what_has_no_texture_of_its_own(opengl, tmp_path):
    mesh = f"mtllib a.mtl\n{VERTICES}usemtl red\n{PAINTED}"
    view, _ = seen(tmp_path, {"a.obj": mesh, "a.mtl": MTL, "Paint.PNG": picture(".png", GREEN)})
    red, green, blue = view.picture[view.mask > 0].mean(axis=0)
    assert green > 3 * max(red, blue), (red, green, blue)


def test_a_texture_that_is_missing_or_no_picture_is_refused(tmp_path):
    for name, content in (("absent", None), ("text", b"no picture")):
        place = tmp_path / name / "thing"
        place.mkdir(parents=True)
        (place / "a.obj").write_text(f"mtllib a.mtl\n{VERTICES}usemtl photo\n{''.join(FACES)}")
        (place / "a.mtl").write_text(MTL)
        if content is not None:
            (place / "skin.jpg").write_bytes(content)
        with pytest.raises(InputError, match=r"skin\.jpg must be (readable|a picture)"):
            read_meshes(tmp_path / name)


def test_what_of_a_mesh_is_not_drawn_is_named(tmp_path):
    place = tmp_path / "thing"
    place.mkdir()
    coloured = VERTICES.replace("\n", " 1 0 0\n")
    (place / "a.obj").write_text(
        f"mtllib a.mtl\nmtllib b.mtl\n{coloured}usemtl gold\n{''.join(FACES)}l 1 2\n"
    )
    (place / "a.mtl").write_text("newmtl glass\nKd 1 1 1\nd 0.5\nmap_Bump b.png\nKd spectral x.rfl\n")
    for name in ("b.stl", "skin.jpg", ".hidden"):
        (place / name).write_bytes(b"x")
    (tmp_path / "loose.obj").write_text("x")
    assert set(read_meshes(tmp_path)["thing"].left_out) == {
        "thing/a.obj: colours of vertices",
        "thing/a.obj: 'l'",
        "thing/b.mtl (named by an OBJ file, but not there)",
        "thing/a.mtl: 'd' of glass",
        "thing/a.mtl: 'map_Bump' of glass",
        "thing/a.mtl: 'Kd spectral x.rfl' of glass",
        "thing/the colour of material gold, which no MTL file defines",
        "thing/b.stl (not used)",
        "thing/skin.jpg (not used)",
    }
    assert unread_meshes(tmp_path) == ("loose.obj (not in the folder of an object)",)
