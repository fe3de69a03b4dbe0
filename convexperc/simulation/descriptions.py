"""Exact conversion of scenes to JSON and back: the keys are the fields."""

import os
from collections.abc import Mapping
from dataclasses import asdict, fields, is_dataclass
from typing import Any, Literal, get_args, get_origin, get_type_hints

from convexperc.errors import FileFormatError, InputError
from convexperc.files import read_json
from convexperc.simulation.scenes import Scene

FORMAT = "convexperc/scene/1"
"""Name and version of the schema."""


def scene_record(scene: Scene) -> dict[str, Any]:
    """Return the scene as plain JSON values, which `scene_of_record` turns back into the same scene."""
    plain: dict[str, Any] = _plain(asdict(scene))
    return {"schema": FORMAT, **plain}


def scene_of_record(record: object, place: str) -> Scene:
    """Return the scene that a record describes.

    Parameters
    ----------
    record : object
        A scene as plain JSON values.
    place : str
        How an error names the record, for example its file.

    Raises
    ------
    FileFormatError
        A key is missing or unknown, or a value has the wrong type or is out of range.
    """
    if not isinstance(record, Mapping) or record.get("schema") != FORMAT:
        found = record.get("schema") if isinstance(record, Mapping) else record
        raise FileFormatError(f"{place}: schema", value=found, must=f"must be {FORMAT!r}")
    scene = _build(Scene, {key: value for key, value in record.items() if key != "schema"}, place)
    assert isinstance(scene, Scene)
    return scene


def read_scene(path: str | os.PathLike[str]) -> Scene:
    """Read a scene from a file.

    Raises
    ------
    FileFormatError
        The file is not readable or not JSON, or see `scene_of_record`.
    """
    file, record = read_json(path)
    return scene_of_record(record, file)


def _plain(value: Any) -> Any:
    """Turn the tuples of a record into lists, as JSON has them."""
    if isinstance(value, dict):
        return {key: _plain(entry) for key, entry in value.items()}
    return [_plain(entry) for entry in value] if isinstance(value, tuple) else value


def _build(kind: Any, value: Any, place: str) -> Any:
    """Return `value` as an instance of a field's type."""
    if is_dataclass(kind) and isinstance(kind, type):
        return _dataclass(kind, value, place)
    if get_origin(kind) is tuple:
        return _tuple(get_args(kind), value, place)
    if get_origin(kind) is Literal:
        if value not in get_args(kind):
            must = f"must be one of {', '.join(get_args(kind))}"
            raise FileFormatError(place, value=value, must=must)
        return value
    accepted = (int, float) if kind is float else (kind,)
    if type(value) not in accepted:
        must = "must be a number" if kind is float else f"must be of type {kind.__name__}"
        raise FileFormatError(place, value=value, must=must)
    return kind(value)


def _dataclass(kind: type[Any], value: Any, place: str) -> Any:
    names = [field.name for field in fields(kind)]
    if not isinstance(value, Mapping):
        raise FileFormatError(place, value=value, must=f"must be an object with the keys {', '.join(names)}")
    for found, must in (
        ([key for key in value if key not in names], f"must have no keys but {', '.join(names)}"),
        ([name for name in names if name not in value], "must not lack a key"),
    ):
        if found:
            remedy = "`convexperc simulate example` prints a complete description."
            raise FileFormatError(place, value=found, must=must, remedy=remedy)
    hints = get_type_hints(kind)
    parts = {name: _build(hints[name], value[name], f"{place}: {name}") for name in names}
    try:
        return kind(**parts)
    except FileFormatError:
        raise
    except InputError as error:
        raise FileFormatError(
            f"{place}: {error.what}", value=error.value, must=error.must, remedy=error.remedy
        ) from None


def _tuple(kinds: tuple[Any, ...], value: Any, place: str) -> tuple[Any, ...]:
    endless = len(kinds) == 2 and kinds[1] is Ellipsis
    if not isinstance(value, list) or not (endless or len(value) == len(kinds)):
        must = "must be a list" if endless else f"must be a list of {len(kinds)} entries"
        raise FileFormatError(place, value=value, must=must)
    each = [kinds[0]] * len(value) if endless else kinds
    return tuple(
        _build(kind, entry, f"{place}[{k}]") for k, (kind, entry) in enumerate(zip(each, value, strict=True))
    )
