"""Scenes as MJCF, MuJoCo's XML."""

import xml.etree.ElementTree as ET
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import IntEnum

from convexperc.simulation.catalogue import Catalogue, object_of
from convexperc.simulation.light import Light
from convexperc.simulation.materials import MATERIALS, TEXTURED, Colour
from convexperc.simulation.meshes import MeshModel, Piece
from convexperc.simulation.objects import OBJECTS
from convexperc.simulation.obstacles import OBSTACLES
from convexperc.simulation.parts import Part
from convexperc.simulation.robots import ROBOTS
from convexperc.simulation.scenes import Scene
from convexperc.simulation.surroundings import SURROUNDINGS, Surroundings

SHADOWS: Mapping[str, tuple[float, int]] = {"park": (10.0, 2048), "lab": (2.0, 1024)}
"""Shadow map by surroundings: half the side in metres of the square that it covers around the object, and its
texels on a side. It takes most of the time of a picture."""

SKY: tuple[Colour, Colour] = ((0.32, 0.55, 0.85), (0.88, 0.92, 0.95))
"""Colours of the sky at its top and at the horizon."""


class Group(IntEnum):
    """MuJoCo's geometry groups, by which a renderer selects what it draws."""

    OBJECT = 0
    SURROUNDINGS = 1
    OBSTACLES = 2
    ROBOTS = 3


@dataclass(frozen=True, slots=True)
class Document:
    """A scene in MJCF.

    Attributes
    ----------
    xml : str
        MJCF, without an XML declaration; lengths in metres, angles in degrees.
    assets : mapping of str to bytes
        Content of each file that `xml` names.
    """

    xml: str
    assets: Mapping[str, bytes]


def mjcf(scene: Scene, objects: Catalogue = OBJECTS) -> Document:
    """Return the scene as an MJCF document whose geometry is grouped by `Group`.

    Parameters
    ----------
    scene : Scene
        What to write. Cameras keep their names; bodies are called ``object``, ``surroundings``,
        ``obstacle-k`` and ``robot-k``, k counted from 1.
    objects : mapping of str to Model or MeshModel
        The known objects by name.

    Raises
    ------
    InputError
        The scene's object is not among them, or has other meshes.
    """
    thing, around = object_of(scene, objects), SURROUNDINGS[scene.surroundings]
    root = ET.Element("mujoco", model=scene.name)
    ET.SubElement(root, "compiler", angle="degree")
    reach, texels = SHADOWS[scene.surroundings]
    _look(root, scene.light, reach, texels)
    assets = ET.SubElement(root, "asset")
    _paints(assets, scene.light)
    world = ET.SubElement(root, "worldbody")
    _ground(world, scene.light, around, reach)
    _body(world, assets, "surroundings", around.parts, Group.SURROUNDINGS, turn=scene.turn)
    files: dict[str, bytes] = {}
    if isinstance(thing, MeshModel):
        files = _mesh_body(world, assets, thing)
    else:
        _body(world, assets, "object", thing.parts, Group.OBJECT)
    _movables(world, assets, scene)
    ET.indent(root)
    return Document(ET.tostring(root, encoding="unicode"), files)


def _movables(world: ET.Element, assets: ET.Element, scene: Scene) -> None:
    """Add obstacles, robots and cameras."""
    for k, obstacle in enumerate(scene.obstacles, start=1):
        parts = OBSTACLES[obstacle.kind](obstacle.width, obstacle.height)
        place, turn = obstacle.position(), obstacle.azimuth + obstacle.turn
        _body(world, assets, f"obstacle-{k}", parts, Group.OBSTACLES, place, turn)
    for k, robot in enumerate(scene.robots, start=1):
        camera = robot.camera
        place, turn = camera.position() * (1.0, 1.0, 0.0), camera.azimuth + camera.pan
        _body(world, assets, f"robot-{k}", ROBOTS[robot.kind](camera.height), Group.ROBOTS, place, turn)
    for name, camera in scene.cameras().items():
        axes = camera.axes(scene.target_height).ravel()
        attributes = {"pos": _numbers(camera.position()), "xyaxes": _numbers(axes)}
        ET.SubElement(world, "camera", attributes, name=name, fovy=f"{camera.field_of_view:g}")


def _look(root: ET.Element, light: Light, reach: float, texels: int) -> None:
    """Set the depth range, the haze at the horizon and the resolution of shadows."""
    ET.SubElement(root, "statistic", center="0 0 0", extent=f"{reach:g}")
    visual = ET.SubElement(root, "visual")
    glow = {"ambient": _numbers(light.ambient), "diffuse": _numbers(light.fill), "specular": "0 0 0"}
    ET.SubElement(visual, "headlight", glow)
    depth = {"znear": f"{0.02 / reach:g}", "zfar": f"{160 / reach:g}", "haze": "0.2"}
    ET.SubElement(visual, "map", depth, shadowclip="1", shadowscale="0.9")
    fine = {"offsamples": "0", "numslices": "20", "numstacks": "8"}
    ET.SubElement(visual, "quality", fine, shadowsize=str(texels))
    ET.SubElement(visual, "rgba", haze=_numbers((*_lit((0.82, 0.88, 0.93), light.sky), 1.0)))


def _paints(assets: ET.Element, light: Light) -> None:
    top, horizon = (_numbers(_lit(colour, light.sky)) for colour in SKY)
    sky = {"rgb1": top, "rgb2": horizon, "width": "128", "height": "768"}
    ET.SubElement(assets, "texture", sky, name="sky", type="skybox", builtin="gradient")
    for name, pattern in TEXTURED.items():
        colours = {"rgb1": _numbers(pattern.first), "rgb2": _numbers(pattern.second)}
        colours |= {"markrgb": _numbers(pattern.joint), "width": "256", "height": "256"}
        ET.SubElement(assets, "texture", colours, name=name, type="2d", builtin="checker", mark="edge")
        finish = {"texrepeat": _numbers(pattern.repeat), "texuniform": "true"}
        ET.SubElement(assets, "material", finish, name=name, texture=name, specular="0.05", shininess="0.1")
    for name, paint in MATERIALS.items():
        finish = {"specular": f"{paint.specular:g}", "shininess": f"{paint.shininess:g}"}
        ET.SubElement(assets, "material", finish, name=name, rgba=_numbers((*paint.colour, 1.0)))


def _ground(world: ET.Element, light: Light, around: Surroundings, reach: float) -> None:
    """Add the sun and the infinite ground plane."""
    direction = light.direction()
    sun = {"pos": _numbers(-1.5 * reach * direction), "dir": _numbers(direction)}
    sun |= {"diffuse": _numbers(light.sun), "specular": _numbers(0.75 * value for value in light.sun)}
    ET.SubElement(world, "light", sun, name="sun", directional="true", castshadow="true")
    flat = {"type": "plane", "group": f"{Group.SURROUNDINGS:d}", "contype": "0", "conaffinity": "0"}
    height = _numbers((0.0, 0.0, around.ground_height))
    ET.SubElement(world, "geom", flat, name="ground", size="0 0 1", pos=height, material=around.ground)


def _body(
    world: ET.Element,
    assets: ET.Element,
    name: str,
    parts: Iterable[Part],
    group: Group,
    place: Iterable[float] = (0.0, 0.0, 0.0),
    turn: float = 0.0,
) -> None:
    body = ET.SubElement(world, "body", name=name, pos=_numbers(place), euler=_numbers((0.0, 0.0, turn)))
    for k, part in enumerate(parts, start=1):
        geom = ET.SubElement(body, "geom", type=part.shape, material=part.material, group=f"{group:d}")
        geom.attrib.update(contype="0", conaffinity="0")
        if part.shape == "mesh":
            geom.set("mesh", f"{name}-{k}")
            mesh = ET.SubElement(assets, "mesh", name=f"{name}-{k}", inertia="shell")
            mesh.set("vertex", _numbers(x for vertex in part.vertices for x in vertex))
            if part.faces:
                mesh.set("face", " ".join(str(index) for face in part.faces for index in face))
        else:
            geom.attrib.update(
                size=_numbers(part.size), pos=_numbers(part.position), euler=_numbers(part.rotation)
            )


def _mesh_body(world: ET.Element, assets: ET.Element, thing: MeshModel) -> dict[str, bytes]:
    """Add an object made of mesh files; return their contents by their names in the document."""
    files = {f"object-{k}.obj": piece.content for k, piece in enumerate(thing.pieces, start=1)}
    body = ET.SubElement(world, "body", name="object")
    if any(piece.colour is None and piece.texture is None for piece in thing.pieces):
        files |= _paint(assets, "mesh-paint", "mesh-texture", "object.png", Piece(b"", None, thing.texture))
    for k, piece in enumerate(thing.pieces, start=1):
        name, paint = f"object-{k}", "mesh-paint"
        if piece.colour is not None or piece.texture is not None:
            paint = f"mesh-paint-{k}"
            files |= _paint(assets, paint, f"mesh-texture-{k}", f"{name}.png", piece)
        scale = _numbers([thing.scale] * 3)
        ET.SubElement(assets, "mesh", name=name, file=f"{name}.obj", inertia="shell", scale=scale)
        geom = {"type": "mesh", "mesh": name, "material": paint, "group": f"{Group.OBJECT:d}"}
        geom |= {"pos": _numbers(thing.position), "quat": _numbers(thing.rotation)}
        ET.SubElement(body, "geom", geom, contype="0", conaffinity="0")
    return files


def _paint(assets: ET.Element, name: str, texture: str, file: str, piece: Piece) -> dict[str, bytes]:
    """Add the material of a piece; return the content of its texture by its name in the document."""
    finish = {"name": name, "specular": "0.2", "shininess": "0.3"}
    if piece.texture is None:
        colour = MATERIALS["gray"].colour if piece.colour is None else piece.colour
        ET.SubElement(assets, "material", finish, rgba=_numbers((*colour, 1.0)))
        return {}
    ET.SubElement(assets, "texture", name=texture, type="2d", file=file)
    ET.SubElement(assets, "material", finish, texture=texture)
    return {file: piece.texture}


def _lit(colour: Colour, light: Colour) -> tuple[float, ...]:
    return tuple(min(share * strength, 1.0) for share, strength in zip(colour, light, strict=True))


def _numbers(values: Iterable[float]) -> str:
    return " ".join(f"{float(value):.7g}" for value in values)
