"""The folder of a data set while it is being made: what is whole stays, and nothing is ever half there.

A scene's files are written beside their places and moved there together, and then its record in
``scenes/``: whoever is stopped goes on later with the scenes that lack a record, or whose files are not
those of it. The manifest is written last.
"""

import json
import shutil
from collections.abc import Mapping
from pathlib import Path, PurePosixPath
from typing import Any

from convexperc.errors import InputError
from convexperc.records import json_bytes, write_whole
from convexperc.simulation.drawing import Drawn, sha256

MANIFEST, REQUEST, RECORDS, DRAWING = "manifest.json", "request.json", "scenes", ".drawing"


def _unwritable(folder: Path, problem: OSError) -> InputError:
    must = "must be a folder that can be written"
    return InputError(f"output {folder}", value=problem.strerror, must=must, remedy="Choose another place.")


def open_folder(folder: Path, request: Mapping[str, Any]) -> None:
    """Make the folder of a data set, or go on with the one that is there.

    Parameters
    ----------
    folder : Path
        Absent, empty, or what a run of the same request left.
    request : mapping
        The manifest's head.

    Raises
    ------
    InputError
        The folder cannot be written, holds other things, or was begun with another request.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        present = sorted(path.name for path in folder.iterdir())
    except OSError as problem:
        raise _unwritable(folder, problem) from None
    if REQUEST not in present:
        if present:
            must, remedy = "must be empty or hold a data set that was begun", "Choose another folder."
            raise InputError(f"output {folder}", value=present[:5], must=must, remedy=remedy)
        write_whole(folder / REQUEST, json_bytes(request))
        return
    begun = _load(folder / REQUEST)
    differing = [key for key in sorted(request.keys() | begun.keys()) if request.get(key) != begun.get(key)]
    if differing:
        shown = {key: begun.get(key) for key in differing}
        must = f"must have been begun with the same {', '.join(differing)} as is asked for now"
        raise InputError(f"output {folder}", value=shown, must=must, remedy="Choose another folder.")


def _load(path: Path) -> dict[str, Any]:
    """Read a record; empty if there is none that can be read."""
    try:
        record = json.loads(path.read_bytes())
    except (OSError, ValueError):
        return {}
    return record if isinstance(record, dict) else {}


def kept_entry(folder: Path, name: str) -> dict[str, Any] | None:
    """Return the record of a part that is there as a whole: its files have the hashes of the record."""
    record = _load(folder / RECORDS / f"{name}.json")
    files = record.get("files")
    if not isinstance(files, dict) or not isinstance(record.get("entry"), dict):
        return None
    for path, digest in files.items():
        try:
            if sha256((folder / path).read_bytes()) != digest:
                return None
        except OSError:
            return None
    entry: dict[str, Any] = record["entry"]
    return entry


def keep(folder: Path, name: str, drawn: Drawn) -> dict[str, Any]:
    """Put a part's files and its record in their places; return its entry.

    Raises
    ------
    InputError
        A file cannot be written.
    """
    beside = folder / DRAWING / name
    try:
        (folder / RECORDS / f"{name}.json").unlink(missing_ok=True)
        shutil.rmtree(beside, ignore_errors=True)
        for path, content in drawn.files.items():
            (beside / path).parent.mkdir(parents=True, exist_ok=True)
            (beside / path).write_bytes(content)
        for parent in sorted({PurePosixPath(path).parent for path in drawn.files}):
            own = parent.name == name and len(parent.parts) > 1
            _move(beside / parent, folder / parent, shared=not own)
        shutil.rmtree(beside)
        (folder / RECORDS).mkdir(exist_ok=True)
    except OSError as problem:
        raise _unwritable(folder, problem) from None
    files = {path: sha256(content) for path, content in sorted(drawn.files.items())}
    write_whole(folder / RECORDS / f"{name}.json", json_bytes({"files": files, "entry": drawn.entry}))
    return drawn.entry


def _move(source: Path, target: Path, shared: bool) -> None:
    """Move a folder of one scene as a whole, or the files of one that several scenes share."""
    if shared:
        target.mkdir(parents=True, exist_ok=True)
        for path in sorted(source.iterdir()):
            path.replace(target / path.name)
        return
    target.parent.mkdir(parents=True, exist_ok=True)
    if target.exists():
        shutil.rmtree(target)
    source.rename(target)


def close_folder(folder: Path, manifest: Mapping[str, Any]) -> None:
    """Write the manifest and remove what is no longer needed.

    Raises
    ------
    InputError
        The manifest cannot be written.
    """
    shutil.rmtree(folder / DRAWING, ignore_errors=True)
    write_whole(folder / MANIFEST, json_bytes(manifest))
