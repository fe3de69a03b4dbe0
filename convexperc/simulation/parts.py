"""Parts: the boxes, cylinders, ellipsoids and small meshes of which every model in a scene is made."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import atan2, degrees, hypot
from typing import Literal

Point = tuple[float, float, float]
Triangle = tuple[int, int, int]
Axis = Literal["x", "y", "z"]
Shape = Literal["box", "cylinder", "capsule", "ellipsoid", "mesh"]


@dataclass(frozen=True, slots=True)
class Part:
    """One piece of a model, in the model's coordinates.

    Attributes
    ----------
    shape : {"box", "cylinder", "capsule", "ellipsoid", "mesh"}
        Kind of body.
    material : str
        Name of the paint; see `convexperc.simulation.materials`.
    size : tuple of float
        Half sizes in metres: (x, y, z) of a box or an ellipsoid; (radius, half length) of a cylinder or
        a capsule, whose axis is z. Empty for a mesh.
    position : tuple of float
        Centre, in metres; not used for a mesh.
    rotation : tuple of float
        Euler angles about x, y and z, in degrees.
    vertices : tuple of points
        Corners of a mesh, in metres.
    faces : tuple of triangles
        Indices into `vertices`, anticlockwise seen from outside; empty for the convex hull.
    """

    shape: Shape
    material: str
    size: tuple[float, ...] = ()
    position: Point = (0.0, 0.0, 0.0)
    rotation: Point = (0.0, 0.0, 0.0)
    vertices: tuple[Point, ...] = ()
    faces: tuple[Triangle, ...] = ()


def box(material: str, size: Point, position: Point, rotation: Point = (0.0, 0.0, 0.0)) -> Part:
    """Return a box of full extents `size` (metres) centred at `position`, turned by `rotation` (degrees)."""
    return Part("box", material, (size[0] / 2, size[1] / 2, size[2] / 2), position, rotation)


def disc(material: str, radius: float, width: float, position: Point, axis: Axis = "x") -> Part:
    """Return a cylinder of the given radius and full width (metres) about an axis parallel to `axis`."""
    rotation = {"x": (0.0, 90.0, 0.0), "y": (90.0, 0.0, 0.0), "z": (0.0, 0.0, 0.0)}[axis]
    return Part("cylinder", material, (radius, width / 2), position, rotation)


def rod(material: str, radius: float, start: Point, end: Point) -> Part:
    """Return a cylinder of the given radius (metres) from `start` to `end`."""
    x, y, z = (b - a for a, b in zip(start, end, strict=True))
    middle = ((start[0] + end[0]) / 2, (start[1] + end[1]) / 2, (start[2] + end[2]) / 2)
    lean = (degrees(atan2(-y, z)), degrees(atan2(x, hypot(y, z))), 0.0)
    return Part("cylinder", material, (radius, hypot(x, y, z) / 2), middle, lean)


def blob(material: str, size: Point, position: Point, rotation: Point = (0.0, 0.0, 0.0)) -> Part:
    """Return an ellipsoid of full extents `size` (metres), turned by `rotation` (degrees)."""
    return Part("ellipsoid", material, (size[0] / 2, size[1] / 2, size[2] / 2), position, rotation)


def mirrored(part: Part) -> Part:
    """Return the mirror image of `part` in the plane x = 0; a skin of triangles still faces outwards."""
    x, y, z = part.position
    a, b, c = part.rotation
    corners = tuple((-p[0], p[1], p[2]) for p in part.vertices)
    faces = tuple((i, k, j) for i, j, k in part.faces)
    return Part(part.shape, part.material, part.size, (-x, y, z), (a, -b, -c), corners, faces)


def both_sides(parts: Sequence[Part]) -> Iterator[Part]:
    """Yield each part and its mirror image in the plane x = 0."""
    for part in parts:
        yield part
        yield mirrored(part)
