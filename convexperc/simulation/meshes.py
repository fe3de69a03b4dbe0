"""Objects from the user's meshes: folders of OBJ files, with an optional texture.

``DIR/<object>/*.obj`` are the pieces of one object, ``*.png`` is their common texture (at most one), and
``object.json`` may hold ``scale`` (metres a unit of the files), ``up`` (``"z"`` or ``"y"``, the axis that
points up in the files) and ``turn`` (degrees anticlockwise from above; after it, the object's most
recognisable side must face +x). All are optional. Without a scale, the object is scaled to the size of the
package's object of the same name or, if there is none, to a radius of 0.25 m or a height of 0.3 m.
"""

import hashlib
import math
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation

from convexperc.errors import FileFormatError, InputError
from convexperc.files import json_bytes, read_json
from convexperc.simulation.checks import check_name, check_range
from convexperc.simulation.objects import OBJECTS

SETTINGS = "object.json"
"""Name of the file of settings."""
MAX_FILE_BYTES = 2**26
"""Largest mesh or texture file in bytes: 64 MiB."""
DEFAULT_RADIUS, DEFAULT_HEIGHT = 0.25, 0.3
"""Largest radius and height in metres of an object without a scale whose name is not in the package: the size
of the objects in the lab."""


@dataclass(frozen=True, slots=True)
class MeshModel:
    """An object made of mesh files, which stands on z = 0 at the origin once it is placed.

    Attributes
    ----------
    name : str
        Its folder's name.
    pieces : tuple of (str, bytes)
        Name and content of each OBJ file.
    texture : bytes or None
        Content of the PNG file that colours all pieces.
    scale : float
        Metres a unit of the files.
    rotation : tuple of float
        Unit quaternion (w, x, y, z) that is applied to the scaled pieces.
    position : tuple of float
        Translation of the rotated pieces, in metres.
    radius, height : float
        The upright cylinder about the origin that holds the object, in metres.
    sha256 : str
        Hash of the files and of the settings.
    """

    name: str
    pieces: tuple[tuple[str, bytes], ...]
    texture: bytes | None
    scale: float
    rotation: tuple[float, ...]
    position: tuple[float, ...]
    radius: float
    height: float
    sha256: str


@dataclass(frozen=True, slots=True)
class _Settings:
    """The settings of ``object.json``."""

    scale: float | None = None
    up: str = "z"
    turn: float = 0.0


def read_meshes(folder: str | os.PathLike[str]) -> dict[str, MeshModel]:
    """Read every object of a folder of folders, by name.

    Raises
    ------
    InputError
        The folder cannot be read, holds no folder with an OBJ file, or a file in it cannot be used.
    """
    try:
        places = sorted(path for path in Path(folder).iterdir() if path.is_dir())
    except OSError as problem:
        must = "must be a readable folder"
        raise InputError(f"meshes {os.fspath(folder)}", value=problem.strerror, must=must) from None
    found = {path.name: _read_object(path) for path in places}
    if not found:
        must, remedy = "must hold a folder for each object", "Put its OBJ files into DIR/<object>/."
        raise InputError(f"meshes {os.fspath(folder)}", value=[], must=must, remedy=remedy)
    return found


def _read_object(folder: Path) -> MeshModel:
    check_name("mesh folder", folder.name)
    pieces = tuple((path.name, _content(path)) for path in sorted(folder.glob("*.obj")))
    textures = sorted(folder.glob("*.png"))
    if not pieces or len(textures) > 1:
        value = sorted(path.name for path in folder.iterdir())
        must = "must hold one OBJ file or several, and at most one PNG file"
        raise InputError(f"mesh folder {folder.name}", value=value, must=must)
    texture = _content(textures[0]) if textures else None
    points = np.concatenate([_vertices(folder.name, *piece) for piece in pieces])
    settings = _settings(folder)
    tip = Rotation.from_euler("x", 90.0 if settings.up == "y" else 0.0, degrees=True)
    rotation = Rotation.from_euler("z", settings.turn, degrees=True) * tip
    turned = rotation.apply(points)
    low, high = turned.min(axis=0), turned.max(axis=0)
    centre = np.array([*(low + high)[:2] / 2, low[2]])
    radius, height = float(np.hypot(*(turned - centre)[:, :2].T).max()), float(high[2] - low[2])
    factor = _factor(folder.name, radius, height) if settings.scale is None else settings.scale
    x, y, z, w = (float(value) for value in rotation.as_quat())
    return MeshModel(
        name=folder.name,
        pieces=pieces,
        texture=texture,
        scale=factor,
        rotation=(w, x, y, z),
        position=tuple(float(value) for value in -factor * centre),
        radius=factor * radius,
        height=factor * height,
        sha256=_hash(pieces, texture, settings, factor),
    )


def _hash(
    pieces: tuple[tuple[str, bytes], ...], texture: bytes | None, settings: _Settings, factor: float
) -> str:
    """Return the hash of the files and of how they are placed."""
    said: dict[str, Any] = {"scale": factor, "up": settings.up, "turn": settings.turn}
    said["files"] = {name: hashlib.sha256(content).hexdigest() for name, content in pieces}
    said["texture"] = "" if texture is None else hashlib.sha256(texture).hexdigest()
    return hashlib.sha256(json_bytes(said)).hexdigest()


def _content(path: Path) -> bytes:
    try:
        size = path.stat().st_size
        if size > MAX_FILE_BYTES:
            raise InputError(
                f"file {path.name}", value=size, must=f"must have at most {MAX_FILE_BYTES} bytes"
            )
        return path.read_bytes()
    except OSError as problem:
        raise InputError(f"file {path.name}", value=problem.strerror, must="must be readable") from None


def _vertices(folder: str, name: str, content: bytes) -> Float[np.ndarray, "points 3"]:
    """Return the vertices of an OBJ file, in the units of the file."""
    rows = [line.split()[1:4] for line in content.splitlines() if line.startswith((b"v ", b"v\t"))]
    try:
        points = np.array(rows, dtype=np.float64)
    except ValueError:
        points = np.empty(0)
    if points.ndim != 2 or points.shape[1:] != (3,) or len(points) < 3 or not np.isfinite(points).all():
        must = "must list three corners or more, each as 'v x y z' with finite numbers"
        raise InputError(f"mesh {folder}/{name}", value=len(rows), must=must, remedy="Export it again.")
    return points


def _settings(folder: Path) -> _Settings:
    """Return the settings of ``object.json``, or the defaults."""
    path = folder / SETTINGS
    if not path.exists():
        return _Settings()
    _, record = read_json(path)
    place = f"{folder.name}/{SETTINGS}"
    if not isinstance(record, dict) or not record.keys() <= {"scale", "up", "turn"}:
        must = "must be an object with no keys but scale, up and turn"
        raise FileFormatError(place, value=record, must=must)
    numbers = {key: record[key] for key in ("scale", "turn") if key in record}
    for key, value in numbers.items():
        if type(value) not in (int, float):
            raise FileFormatError(f"{place}: {key}", value=value, must="must be a number")
    up = record.get("up", "z")
    if up not in ("y", "z"):
        raise FileFormatError(f"{place}: up", value=up, must="must be 'y' or 'z'")
    said = _Settings(up=up, **{key: float(value) for key, value in numbers.items()})
    if said.scale is not None:
        check_range(f"{place}: scale", said.scale, 1e-9, 1e9)
    check_range(f"{place}: turn", said.turn, -360.0, 360.0)
    return said


def _factor(name: str, radius: float, height: float) -> float:
    """Return the scale at which the object just fits into its namesake's cylinder, or the default one."""
    if not (radius > 0.0 and height > 0.0 and math.isfinite(radius * height)):
        raise InputError(f"mesh folder {name}", value=(radius, height), must="must have a width and a height")
    room = OBJECTS.get(name)
    across, upright = (DEFAULT_RADIUS, DEFAULT_HEIGHT) if room is None else (room.radius, room.height)
    return min(across / radius, upright / height)
