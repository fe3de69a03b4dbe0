"""Writes a scene as MJCF, MuJoCo's XML."""

import xml.etree.ElementTree as ET
from collections.abc import Iterable
from enum import IntEnum

from convexperc.simulation.cars import ESTATE, SALOON, car
from convexperc.simulation.parts import Part
from convexperc.simulation.props import PAVED, husky, obstacle, park, sign
from convexperc.simulation.scenes import ObjectKind, Scene


class Group(IntEnum):
    """MuJoCo's geometry group of each kind of thing, so that a renderer can leave it out."""

    OBJECT = 0
    PARK = 1
    OBSTACLES = 2
    ROBOTS = 3


MATERIALS: dict[str, tuple[str, float, float]] = {
    "red": ("0.62 0.03 0.04", 0.5, 0.8),
    "gray": ("0.45 0.47 0.49", 0.6, 0.8),
    "glass": ("0.05 0.07 0.09", 0.9, 0.9),
    "rubber": ("0.06 0.06 0.065", 0.1, 0.2),
    "seam": ("0.10 0.10 0.11", 0.2, 0.3),
    "chrome": ("0.75 0.76 0.78", 0.9, 0.9),
    "rim": ("0.68 0.69 0.71", 0.8, 0.7),
    "lamp": ("0.95 0.95 0.86", 0.9, 0.9),
    "tail-lamp": ("0.55 0.02 0.02", 0.7, 0.7),
    "plate": ("0.92 0.92 0.88", 0.1, 0.1),
    "steel": ("0.55 0.57 0.59", 0.4, 0.4),
    "navy": ("0.03 0.08 0.30", 0.2, 0.3),
    "board": ("0.94 0.94 0.92", 0.1, 0.2),
    "husky": ("0.93 0.70 0.05", 0.4, 0.5),
    "wood": ("0.62 0.44 0.24", 0.05, 0.1),
    "beam": ("0.74 0.56 0.34", 0.05, 0.1),
    "drum": ("0.05 0.22 0.52", 0.5, 0.5),
    "drum-rib": ("0.04 0.16 0.40", 0.5, 0.5),
    "drum-band": ("0.88 0.88 0.85", 0.4, 0.4),
    "concrete": ("0.70 0.69 0.66", 0.05, 0.1),
    "brick": ("0.60 0.29 0.21", 0.05, 0.1),
    "mortar": ("0.74 0.70 0.65", 0.05, 0.1),
    "plaster": ("0.80 0.77 0.70", 0.05, 0.1),
    "bark": ("0.30 0.21 0.13", 0.0, 0.1),
    "leaf": ("0.30 0.45 0.18", 0.0, 0.1),
    "leaf-dark": ("0.23 0.37 0.15", 0.0, 0.1),
    "hill": ("0.42 0.54 0.40", 0.0, 0.1),
}
"""Colour (red, green, blue in 0..1), specular share and shininess of each plain paint."""

TEXTURED: dict[str, tuple[str, str, str, str]] = {
    "paving": ("0.60 0.59 0.57", "0.57 0.56 0.54", "0.44 0.44 0.43", "0.5 0.5"),
    "grass": ("0.36 0.47 0.24", "0.34 0.45 0.22", "0.35 0.46 0.23", "0.1 0.1"),
}
"""Two colours of the squares, colour of the joints, repeats a metre (of two squares a side)."""


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
    _body(world, assets, "park", park(), Group.PARK)
    _body(world, assets, "object", _object(scene.name), Group.OBJECT)
    for k, thing in enumerate(scene.obstacles, start=1):
        parts = obstacle(thing.kind, thing.width, thing.height)
        place, turn = thing.position(), thing.azimuth + thing.turn
        _body(world, assets, f"obstacle-{k}", parts, Group.OBSTACLES, place, turn)
    for k, robot in enumerate(scene.robots, start=1):
        place, turn = robot.position() * (1.0, 1.0, 0.0), robot.azimuth + robot.pan
        _body(world, assets, f"robot-{k}", husky(robot.height), Group.ROBOTS, place, turn)
    for name, camera in scene.cameras().items():
        axes = camera.axes(scene.target_height).ravel()
        attributes = {"pos": _numbers(camera.position()), "xyaxes": _numbers(axes)}
        ET.SubElement(world, "camera", attributes, name=name, fovy=f"{camera.field_of_view:g}")
    ET.indent(root)
    return ET.tostring(root, encoding="unicode")


def _object(name: ObjectKind) -> Iterable[Part]:
    if name == "ica-sign":
        return sign()
    return car(SALOON, "red") if name == "red-car" else car(ESTATE, "gray")


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
    for name, (first, second, joint, repeat) in TEXTURED.items():
        colours = {"rgb1": first, "rgb2": second, "markrgb": joint, "width": "256", "height": "256"}
        ET.SubElement(assets, "texture", colours, name=name, type="2d", builtin="checker", mark="edge")
        finish = {"texrepeat": repeat, "texuniform": "true", "specular": "0.05", "shininess": "0.1"}
        ET.SubElement(assets, "material", finish, name=name, texture=name)
    for name, (colour, specular, shininess) in MATERIALS.items():
        finish = {"specular": f"{specular:g}", "shininess": f"{shininess:g}"}
        ET.SubElement(assets, "material", finish, name=name, rgba=f"{colour} 1")


def _ground(world: ET.Element) -> None:
    """Add the sun, a meadow without end and the paved square."""
    sun = {"pos": "7 3 14", "dir": "-0.42 -0.2 -0.8", "diffuse": "0.68 0.66 0.61", "specular": "0.5 0.5 0.5"}
    ET.SubElement(world, "light", sun, name="sun", directional="true", castshadow="true")
    flat = {"type": "plane", "group": f"{Group.PARK:d}", "contype": "0", "conaffinity": "0"}
    ET.SubElement(world, "geom", flat, name="meadow", size="0 0 1", pos="0 0 -0.03", material="grass")
    ET.SubElement(world, "geom", flat, name="square", size=f"{PAVED / 2} {PAVED / 2} 1", material="paving")


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
