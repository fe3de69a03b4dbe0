"""Objects from the user's meshes: folders of OBJ files, with the colours and textures of MTL files.

``DIR/<object>/*.obj`` are the pieces of one object. Their faces have the colour (``Kd``) or the texture
(``map_Kd``) of their material in the MTL file that they name. A ``*.png`` that no MTL file names (at most
one) is the common texture of all pieces without one of their own. ``object.json`` may hold ``scale`` (metres
a unit of the files), ``up`` (``"z"`` or ``"y"``, the axis that points up in the files) and ``turn`` (degrees
anticlockwise from above; after it, the object's most recognisable side must face +x). All are optional.
Without a scale, the object is scaled to the size of the package's object of the same name or, if there is
none, to a radius of 0.25 m or a height of 0.3 m.
"""

import hashlib
import math
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

from convexperc.errors import FileFormatError, InputError
from convexperc.files import json_bytes, read_json
from convexperc.simulation.checks import check_name, check_range
from convexperc.simulation.obj_files import Colour, Material, ObjFile, read_mtl, read_obj
from convexperc.simulation.objects import OBJECTS

SETTINGS = "object.json"
"""Name of the file of settings."""
_READ = (".obj", ".png")
MAX_FILE_BYTES = 2**26
"""Largest mesh or texture file in bytes: 64 MiB."""
DEFAULT_RADIUS, DEFAULT_HEIGHT = 0.25, 0.3
"""Largest radius and height in metres of an object without a scale whose name is not in the package: the size
of the objects in the lab."""


@dataclass(frozen=True, slots=True)
class Piece:
    """Faces of one material.

    Attributes
    ----------
    content : bytes
        An OBJ file.
    colour : tuple of float, or None
        Shares of red, green and blue; None for gray, or the common texture.
    texture : bytes or None
        Content of the PNG file of its own.
    """

    content: bytes
    colour: Colour | None = None
    texture: bytes | None = None


@dataclass(frozen=True, slots=True)
class MeshModel:
    """An object made of mesh files, which stands on z = 0 at the origin once it is placed.

    Attributes
    ----------
    name : str
        Its folder's name.
    pieces : tuple of Piece
        What is drawn.
    texture : bytes or None
        Content of the PNG file that colours all pieces without a texture of their own.
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
    left_out : tuple of str
        What of its folder is not drawn, and why.
    """

    name: str
    pieces: tuple[Piece, ...]
    texture: bytes | None
    scale: float
    rotation: tuple[float, ...]
    position: tuple[float, ...]
    radius: float
    height: float
    sha256: str
    left_out: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class _Settings:
    """The settings of ``object.json``."""

    scale: float | None = None
    up: str = "z"
    turn: float = 0.0


def read_meshes(folder: str | os.PathLike[str]) -> dict[str, MeshModel]:
    """Read every object of a folder of folders, by name.

    A folder whose name is none of an object is left out; see `unread_meshes`.

    Raises
    ------
    InputError
        The folder cannot be read, holds no folder that can be an object's, or a file in it cannot be used.
    """
    try:
        places = sorted(path for path in Path(folder).iterdir() if path.is_dir())
    except OSError as problem:
        must = "must be a readable folder"
        raise InputError(f"meshes {os.fspath(folder)}", value=problem.strerror, must=must) from None
    found = {path.name: _read_object(path) for path in places if not _misnamed(path.name)}
    if not found:
        must = "must hold a folder for each object, named by letters a-z and digits with single hyphens"
        value, remedy = [path.name for path in places], "Put its OBJ files into DIR/<object>/."
        raise InputError(f"meshes {os.fspath(folder)}", value=value, must=must, remedy=remedy)
    return found


def unread_meshes(folder: str | os.PathLike[str]) -> tuple[str, ...]:
    """Name what of a folder of objects is not read, and why; hidden entries are not named."""
    entries = sorted(path for path in Path(folder).iterdir() if not path.name.startswith("."))
    said = [
        (path, _misnamed(path.name) if path.is_dir() else "not in the folder of an object")
        for path in entries
    ]
    return tuple(f"{path.name} ({why})" for path, why in said if why)


def _misnamed(name: str) -> str:
    """Why a folder's name is none of an object; empty if it is one."""
    try:
        check_name("mesh folder", name)
    except InputError as error:
        return f"its name {error.must}"
    return ""


def _read_object(folder: Path) -> MeshModel:
    entries = sorted(path for path in folder.iterdir() if not path.name.startswith("."))
    files = {path.name: _content(path) for path in entries if path.suffix.lower() in _READ}
    objs = {name: content for name, content in files.items() if name.lower().endswith(".obj")}
    meshes = {name: read_obj(content, f"{folder.name}/{name}") for name, content in objs.items()}
    materials = _Materials.of(folder, meshes)
    textures = [name for name in files if name.lower().endswith(".png") and name not in materials.textures]
    if not meshes or len(textures) > 1:
        value = sorted(path.name for path in folder.iterdir())
        must = "must hold one OBJ file or several, and at most one PNG file that no MTL file names"
        raise InputError(f"mesh folder {folder.name}", value=value, must=must)
    texture = files[textures[0]] if textures else None
    pieces = tuple(
        Piece(part.content, *materials.paint(part.material, plain=texture is None))
        for mesh in meshes.values()
        for part in mesh.parts
    )
    for part in (part for mesh in meshes.values() for part in mesh.parts):
        if part.mixed and (texture is not None or materials.paint(part.material, plain=True)[1] is not None):
            must = "must have texture coordinates on all its faces or on none"
            raise InputError(
                f"mesh folder {folder.name}: material {part.material!r}", value="some", must=must
            )
    points = np.concatenate([mesh.points for mesh in meshes.values()])
    settings = _settings(folder)
    tip = Rotation.from_euler("x", 90.0 if settings.up == "y" else 0.0, degrees=True)
    rotation = Rotation.from_euler("z", settings.turn, degrees=True) * tip
    turned = rotation.apply(points)
    low, high = turned.min(axis=0), turned.max(axis=0)
    centre = np.array([*(low + high)[:2] / 2, low[2]])
    radius, height = float(np.hypot(*(turned - centre)[:, :2].T).max()), float(high[2] - low[2])
    factor = _factor(folder.name, radius, height) if settings.scale is None else settings.scale
    x, y, z, w = (float(value) for value in rotation.as_quat())
    named = (Path(name).parts[0] for name in (*materials.libraries, *materials.textures))
    known = {*objs, *textures, *named, SETTINGS}
    said = [f"{name}: {what}" for name, mesh in meshes.items() for what in mesh.left_out]
    said += [*materials.left_out, *(f"{path.name} (not used)" for path in entries if path.name not in known)]
    return MeshModel(
        name=folder.name,
        pieces=pieces,
        texture=texture,
        scale=factor,
        rotation=(w, x, y, z),
        position=tuple(float(value) for value in -factor * centre),
        radius=factor * radius,
        height=factor * height,
        sha256=_hash(objs, texture, pieces, settings, factor),
        left_out=tuple(f"{folder.name}/{each}" for each in said),
    )


@dataclass(frozen=True, slots=True)
class _Materials:
    """The materials that the MTL files of a folder define.

    Attributes
    ----------
    by_name : dict of str to Material
    libraries : tuple of str
        The files.
    textures : dict of str to bytes
        Content, as PNG, of each texture that they name.
    left_out : tuple of str
    """

    by_name: dict[str, Material]
    libraries: tuple[str, ...]
    textures: dict[str, bytes]
    left_out: tuple[str, ...]

    @classmethod
    def of(cls, folder: Path, meshes: Mapping[str, ObjFile]) -> "_Materials":
        by_name, said = dict[str, Material](), list[str]()
        named = tuple(dict.fromkeys(name for mesh in meshes.values() for name in mesh.libraries))
        for name in named:
            if not (folder / name).is_file():
                said.append(f"{name} (named by an OBJ file, but not there)")
                continue
            found, left_out = read_mtl(_content(folder / name))
            by_name |= found
            said += [f"{name}: {what}" for what in left_out]
        used = dict.fromkeys(part.material for mesh in meshes.values() for part in mesh.parts)
        textures = dict[str, bytes]()
        for material in used:
            if material and material not in by_name and named:
                said.append(f"the colour of material {material}, which no MTL file defines")
            texture = by_name.get(material, Material()).texture
            if texture:
                textures[texture] = _as_png(folder / texture)
        return cls(by_name, named, textures, tuple(said))

    def paint(self, name: str, *, plain: bool) -> tuple[Colour | None, bytes | None]:
        """Return colour and texture of a material; without a colour where there is a common texture."""
        material = self.by_name.get(name, Material())
        texture = self.textures.get(material.texture)
        return (material.colour if plain and texture is None else None), texture


def _as_png(path: Path) -> bytes:
    """Return a texture as PNG, which alone MuJoCo reads."""
    content = _content(path)
    if content.startswith(b"\x89PNG"):
        return content
    pixels = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_COLOR) if content else None
    if pixels is None:
        must = "must be a picture, such as PNG or JPEG"
        raise InputError(f"texture {path.name}", value=content[:8], must=must)
    return bytes(cv2.imencode(".png", pixels)[1])


def _hash(
    objs: Mapping[str, bytes],
    texture: bytes | None,
    pieces: tuple[Piece, ...],
    settings: _Settings,
    factor: float,
) -> str:
    """Return the hash of the files and of how they are placed and painted."""
    said: dict[str, Any] = {"scale": factor, "up": settings.up, "turn": settings.turn}
    said["files"] = {name: hashlib.sha256(content).hexdigest() for name, content in objs.items()}
    said["texture"] = "" if texture is None else hashlib.sha256(texture).hexdigest()
    if any(piece.colour or piece.texture for piece in pieces):
        said["pieces"] = [
            [piece.colour, piece.texture and hashlib.sha256(piece.texture).hexdigest()] for piece in pieces
        ]
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
