"""OBJ files: read so that MuJoCo draws all of them, and what of them is not drawn.

MuJoCo draws the faces of the first group alone, of one material, without the colours of an MTL file or of the
vertices; it cuts polygons into fans, which is wrong where they are not convex, draws the hull of vertices
without faces, and skips a first line behind a byte order mark. So a file is split into parts of one material
each, without groups, and what cannot be drawn right is refused or named.

Source: Wavefront, Object Files (.obj) and Material Template Library (.mtl).
"""

import os
import re
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float

from convexperc.errors import InputError

Colour = tuple[float, float, float]
"""Shares of red, green and blue in [0, 1]."""

_CONTINUED = re.compile(r"\\\r?\n")
_COORDINATE = re.compile(r"(?<= )(-?\d+)/-?\d+(?=[ /]|$)")
_MARK = b"\xef\xbb\xbf"
_NAMES, _DRAWN = ("g", "o", "s"), ("v", "vt", "vn", "f")
_OTHER_MAPS = ("map_", "bump", "disp", "decal", "refl")
"""Beginnings of the statements of textures other than that of the colour."""


@dataclass(frozen=True, slots=True)
class Part:
    """The faces of one material, as an OBJ file with all vertices; `material` is empty if none is named."""

    material: str
    content: bytes
    mixed: bool
    """Whether some of its faces have texture coordinates and others none; MuJoCo would drop those of all."""


@dataclass(frozen=True, slots=True)
class ObjFile:
    """An OBJ file.

    Attributes
    ----------
    points : ndarray, (points, 3)
        The vertices, in the units of the file.
    parts : tuple of Part
        At least one; the only one is the file as it is, where MuJoCo draws all of that.
    libraries : tuple of str
        The MTL files that it names.
    left_out : tuple of str
        What of it is not drawn.
    """

    points: Float[np.ndarray, "points 3"]
    parts: tuple[Part, ...]
    libraries: tuple[str, ...]
    left_out: tuple[str, ...]


@dataclass(slots=True)
class _Lines:
    """What the lines of a file hold, as far as they are read."""

    points: list[list[str]] = field(default_factory=list)
    faces: list[list[int]] = field(default_factory=list)
    kept: list[tuple[str | None, str]] = field(default_factory=list)
    """A line with the material of its face; None for what all faces share."""
    libraries: list[str] = field(default_factory=list)
    left_out: dict[str, None] = field(default_factory=dict)
    materials: dict[str, set[bool]] = field(default_factory=dict)
    """Whether the faces of each have texture coordinates."""
    coordinates: int = 0
    grouped: bool = False
    """Whether a group begins behind a face."""


def read_obj(content: bytes, place: str) -> ObjFile:
    """Read an OBJ file; `place` is how an error names it.

    Raises
    ------
    InputError
        Fewer than three vertices, numbers that are not finite, no face, a face of fewer than three corners or
        of vertices that there are not, or one that is not convex.
    """
    text = content.removeprefix(_MARK).decode("latin-1")
    lines = _read_lines(_CONTINUED.sub(" ", text), place)
    points = _points(lines.points, place)
    if not lines.faces:
        must, remedy = "must have a face ('f 1 2 3')", "Export it as a surface."
        raise InputError(f"mesh {place}", value=f"{len(points)} vertices", must=must, remedy=remedy)
    _check_faces(points, lines.faces, place)
    changed = content.startswith(_MARK) or _CONTINUED.search(text) is not None
    indented = re.search(r"^[ \t]+[vf]", text, re.MULTILINE) is not None
    bare = lines.coordinates > 0 and {True} not in lines.materials.values()
    if changed or indented or bare or lines.grouped or len(lines.materials) > 1:
        parts = tuple(_part(lines, material) for material in lines.materials)
    else:
        parts = (Part(next(iter(lines.materials)), content, mixed=False),)
    return ObjFile(points, parts, tuple(lines.libraries), tuple(lines.left_out))


def _part(lines: _Lines, material: str) -> Part:
    """Return the faces of a material, without texture coordinates where not all of them have some."""
    own = [line for owner, line in lines.kept if owner in (None, material)]
    if lines.materials[material] != {True}:
        own = [_COORDINATE.sub(r"\1/", line) for line in own if not line.startswith("vt ")]
        own = [line.replace("/ ", " ").rstrip("/") for line in own]
    return Part(material, ("\n".join(own) + "\n").encode("latin-1"), len(lines.materials[material]) > 1)


def _read_lines(text: str, place: str) -> _Lines:
    found, material, fresh = _Lines(), "", False
    for line in text.splitlines():
        kind, _, rest = line.strip().replace("\t", " ").partition(" ")
        words = rest.split()
        if kind in _DRAWN:
            found.kept.append((material if kind == "f" else None, f"{kind} {' '.join(words)}"))
            found.coordinates += kind == "vt"
        if kind == "v":
            found.points.append(words[:3])
            if len(words) >= 6:
                found.left_out["colours of vertices"] = None
        elif kind == "f":
            _add_face(found, words, material, place)
            found.grouped, fresh = found.grouped or fresh, False
        elif kind in ("g", "o"):
            fresh = bool(found.faces)
        elif kind == "usemtl":
            material = rest.strip()
        elif kind == "mtllib":
            found.libraries.append(_file_name(rest))
        elif kind and kind not in (*_DRAWN, *_NAMES) and not kind.startswith("#"):
            found.left_out[f"'{kind}'"] = None
    return found


def _add_face(found: _Lines, words: list[str], material: str, place: str) -> None:
    found.faces.append(_corners(words, len(found.points), place))
    painted = {_has_coordinate(word, found.coordinates, place) for word in words}
    found.materials.setdefault(material, set()).update(painted)


def _corners(words: list[str], count: int, place: str) -> list[int]:
    """Return the vertices of a face, from 0."""
    try:
        stated = [int(word.partition("/")[0]) for word in words]
    except ValueError:
        stated = []
    corners = [index - 1 if index > 0 else count + index for index in stated]
    if len(corners) < 3 or 0 in stated or min(corners) < 0:
        must = "must name three corners or more, by vertices that there are"
        raise InputError(f"a face of mesh {place}", value=" ".join(words), must=must)
    return corners


def _has_coordinate(word: str, count: int, place: str) -> bool:
    """Whether a corner has texture coordinates, which must be among those above it."""
    stated = word.split("/")[1:2]
    if stated in ([], [""]):
        return False
    if re.fullmatch(r"-?\d+", stated[0]) is None or not 0 < abs(int(stated[0])) <= count:
        must = f"must name texture coordinates that are above it, {count} in number"
        raise InputError(f"a face of mesh {place}", value=word, must=must)
    return True


def _points(rows: list[list[str]], place: str) -> Float[np.ndarray, "points 3"]:
    try:
        points = np.array(rows, dtype=np.float64)
    except ValueError:
        points = np.empty(0)
    if points.ndim != 2 or points.shape[1:] != (3,) or len(points) < 3 or not np.isfinite(points).all():
        must = "must list three corners or more, each as 'v x y z' with finite numbers"
        raise InputError(f"mesh {place}", value=len(rows), must=must, remedy="Export it again.")
    return points


def _check_faces(points: Float[np.ndarray, "points 3"], faces: list[list[int]], place: str) -> None:
    """Refuse faces of vertices that there are not, and polygons that are not convex."""
    most = max(map(max, faces))
    if most >= len(points):
        must = f"must name vertices that there are, at most {len(points)}"
        raise InputError(f"a face of mesh {place}", value=most + 1, must=must)
    for size in {len(face) for face in faces} - {3}:
        corners = points[np.array([face for face in faces if len(face) == size])]
        sides = np.roll(corners, -1, axis=1) - corners
        turns = np.cross(sides, np.roll(sides, -1, axis=1))
        normals = np.cross(corners, np.roll(corners, -1, axis=1)).sum(axis=1, keepdims=True)
        along = (turns * normals).sum(axis=2)
        if (along < -1e-6 * (normals**2).sum(axis=2)).any():
            remedy = "Cut its faces into triangles: they would be drawn wrong."
            raise InputError(f"a face of mesh {place}", value=size, must="must be convex", remedy=remedy)


@dataclass(frozen=True, slots=True)
class Material:
    """A material of an MTL file: its diffuse colour (Kd), and the file of its texture (map_Kd), or empty."""

    colour: Colour | None = None
    texture: str = ""


def read_mtl(content: bytes) -> tuple[dict[str, Material], tuple[str, ...]]:
    """Read an MTL file: the materials by name, and what of them is not drawn."""
    found, left_out, name = dict[str, Material](), dict[str, None](), ""
    text = content.removeprefix(_MARK).decode("latin-1")
    for line in text.splitlines():
        kind, _, rest = line.strip().replace("\t", " ").partition(" ")
        value = rest.strip()
        known = found.get(name, Material())
        if kind == "newmtl":
            name = value
            found[name] = Material()
        elif kind == "Kd":
            colour = _colour(value)
            if colour is None:
                left_out[f"'Kd {value}' of {name}"] = None
            found[name] = Material(colour, known.texture)
        elif kind == "map_Kd":
            found[name] = Material(known.colour, _file_name(value))
        elif kind.lower().startswith(_OTHER_MAPS) or (kind == "d" and value.strip("0.") != "1"):
            left_out[f"'{kind}' of {name}"] = None
    return found, tuple(left_out)


def _file_name(text: str) -> str:
    """Return a name that was read byte by byte, as the file system has it."""
    return os.fsdecode(text.strip().encode("latin-1"))


def _colour(value: str) -> Colour | None:
    try:
        red, green, blue = (min(max(float(word), 0.0), 1.0) for word in value.split()[:3])
    except ValueError:
        return None
    return red, green, blue
