"""The files of counterexamples: read, checked, and written whole or not at all."""

import json
import os
from importlib.resources import files
from pathlib import Path
from typing import Any

from convexperc.errors import FileFormatError
from convexperc.files import json_bytes, write_atomic
from verification.counterexamples.record import Record, parse


def load(path: str | os.PathLike[str]) -> Record:
    """Read a record.

    Raises
    ------
    FileFormatError
        No such file, no JSON, or not as the schema says.
    """
    place = Path(path)
    try:
        data = json.loads(place.read_text(encoding="utf-8"))
    except OSError as fault:
        raise FileFormatError(place.name, value=fault.strerror, must="must be a readable file") from None
    except (ValueError, RecursionError) as fault:
        raise FileFormatError(place.name, value=str(fault), must="must be JSON") from None
    record = parse(data, place.name)
    if place.stem != record.id:
        raise FileFormatError(f"{place.name}: id", value=record.id, must="must be the name of its file")
    return record


def load_all(folder: str | os.PathLike[str]) -> tuple[Record, ...]:
    """Read every record of a folder, by id.

    Raises
    ------
    FileFormatError
        As `load`; also where there is no such folder.
    """
    place = Path(folder)
    if not place.is_dir():
        raise FileFormatError(os.fspath(folder), value="no folder", must="must be a folder of records")
    return tuple(load(path) for path in sorted(place.glob("*.json")))


def catalogue() -> tuple[Record, ...]:
    """Read the records that come with the verifier, by id."""
    folder = files("verification.counterexamples") / "catalogue"
    names = sorted(entry.name for entry in folder.iterdir() if entry.name.endswith(".json"))
    return tuple(parse(json.loads((folder / name).read_text(encoding="utf-8")), name) for name in names)


def schema() -> dict[str, Any]:
    """The JSON Schema of a record."""
    text = (files("verification.counterexamples") / "counterexample.schema.json").read_text(encoding="utf-8")
    return dict(json.loads(text))


def save(record: Record, folder: str | os.PathLike[str]) -> Path:
    """Write a record to `folder`/id.json, whole or not at all, and return its place.

    Raises
    ------
    FileFormatError
        The record is not what could be read back.
    InputError
        The folder cannot be written.
    """
    data = record.as_json()
    parse(data, record.id)
    place = Path(folder) / f"{record.id}.json"
    write_atomic(place, json_bytes(data))
    return place
