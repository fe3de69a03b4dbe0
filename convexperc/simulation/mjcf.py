"""Writes a scene as MJCF, MuJoCo's XML."""

import xml.etree.ElementTree as ET
from collections.abc import Iterable
from enum import IntEnum

from convexperc.simulation.materials import MATERIALS, TEXTURED
from convexperc.simulation.objects import OBJECTS
from convexperc.simulation.obstacles import OBSTACLES
from convexperc.simulation.parts import Part
from convexperc.simulation.robots import ROBOTS
from convexperc.simulation.scenes import Scene
from convexperc.simulation.surroundings import SURROUNDINGS


class Group(IntEnum):
    """MuJoCo's geometry group of each kind of thing, so that a renderer can leave it out."""

    OBJECT = 0
    PARK = 1
    OBSTACLES = 2
    ROBOTS = 3


def mjcf(scene: Scene) -> str:
    """Return the scene as an MJCF document whose geometry is grouped by `Group`.

    Parameters
    ----------
    scene : Scene
        What to write. Cameras keep their names; bodies are called ``object``, ``park``, ``obstacle-k``
        and ``robot-k``, k counted from 1.

    Returns
    -------
    str
        XML, without an XML declaration; lengths in metres, angles in degrees.
    """
    root = ET.Element("mujoco", model=scene.name)
    ET.SubElement(root, "compiler", angle="degree")
    _look(root)
    assets = ET.SubElement(root, "asset")
    _paints(assets)
    world = ET.SubElement(root, "worldbody")
    _ground(world)
    _body(world, assets, "park", SURROUNDINGS["park"].parts, Group.PARK)
    _body(world, assets, "object", OBJECTS[scene.name].parts, Group.OBJECT)
    for k, thing in enumerate(scene.obstacles, start=1):
        parts = OBSTACLES[thing.kind](thing.width, thing.height)
        place, turn = thing.position(), thing.azimuth + thing.turn
        _body(world, assets, f"obstacle-{k}", parts, Group.OBSTACLES, place, turn)
    for k, robot in enumerate(scene.robots, start=1):
        place, turn = robot.position() * (1.0, 1.0, 0.0), robot.azimuth + robot.pan
        _body(world, assets, f"robot-{k}", ROBOTS["husky"](robot.height), Group.ROBOTS, place, turn)
    for name, camera in scene.cameras().items():
        axes = camera.axes(scene.target_height).ravel()
        attributes = {"pos": _numbers(camera.position()), "xyaxes": _numbers(axes)}
        ET.SubElement(world, "camera", attributes, name=name, fovy=f"{camera.field_of_view:g}")
    ET.indent(root)
    return ET.tostring(root, encoding="unicode")


def _look(root: ET.Element) -> None:
    """Set the depth range, the haze at the horizon and the resolution of shadows."""
    ET.SubElement(root, "statistic", center="0 0 1", extent="10")
    visual = ET.SubElement(root, "visual")
    ET.SubElement(visual, "headlight", ambient="0.38 0.39 0.42", diffuse="0.2 0.2 0.2", specular="0 0 0")
    ET.SubElement(visual, "map", znear="0.005", zfar="16", haze="0.2", shadowclip="2", shadowscale="0.9")
    ET.SubElement(visual, "quality", shadowsize="4096", offsamples="0", numslices="32", numstacks="16")
    ET.SubElement(visual, "rgba", haze="0.82 0.88 0.93 1")


def _paints(assets: ET.Element) -> None:
    sky = {"rgb1": "0.32 0.55 0.85", "rgb2": "0.88 0.92 0.95", "width": "256", "height": "1536"}
    ET.SubElement(assets, "texture", sky, name="sky", type="skybox", builtin="gradient")
    for name, pattern in TEXTURED.items():
        colours = {"rgb1": _numbers(pattern.first), "rgb2": _numbers(pattern.second)}
        colours |= {"markrgb": _numbers(pattern.joint), "width": "256", "height": "256"}
        ET.SubElement(assets, "texture", colours, name=name, type="2d", builtin="checker", mark="edge")
        finish = {
            "texrepeat": _numbers(pattern.repeat),
            "texuniform": "true",
            "specular": "0.05",
            "shininess": "0.1",
        }
        ET.SubElement(assets, "material", finish, name=name, texture=name)
    for name, paint in MATERIALS.items():
        finish = {"specular": f"{paint.specular:g}", "shininess": f"{paint.shininess:g}"}
        ET.SubElement(assets, "material", finish, name=name, rgba=_numbers((*paint.colour, 1.0)))


def _ground(world: ET.Element) -> None:
    """Add the sun and the ground without end."""
    sun = {"pos": "7 3 14", "dir": "-0.42 -0.2 -0.8", "diffuse": "0.68 0.66 0.61", "specular": "0.5 0.5 0.5"}
    ET.SubElement(world, "light", sun, name="sun", directional="true", castshadow="true")
    flat = {"type": "plane", "group": f"{Group.PARK:d}", "contype": "0", "conaffinity": "0"}
    place = SURROUNDINGS["park"]
    height = _numbers((0.0, 0.0, place.ground_height))
    ET.SubElement(world, "geom", flat, name="ground", size="0 0 1", pos=height, material=place.ground)


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


def _numbers(values: Iterable[float]) -> str:
    return " ".join(f"{float(value):.7g}" for value in values)
