"""The folder of a data set while it is being drawn: complete parts are kept, and no part is ever incomplete.

A part is one scene or one reference. Its files are written to a temporary folder and moved together, then its
entry is recorded. An interrupted run is continued with the parts that have no entry, or whose files do not
have the hashes of their entry. The manifest, which holds all entries, is written last.
"""

import json
import shutil
from collections.abc import Iterator, Mapping
from pathlib import Path, PurePosixPath
from typing import Any

from convexperc.errors import InputError
from convexperc.files import json_bytes, write_atomic
from convexperc.simulation.drawing import Drawn, sha256

# Names of files and temporary folders.
MANIFEST, REQUEST, RECORDS, DRAWING = "manifest.json", "request.json", ".records", ".drawing"

Entries = dict[str, dict[str, Any]]
"""Manifest entries by the names of their parts, see `part_name`."""


def part_name(entry: Mapping[str, Any]) -> str:
    """Return ``scenes/<scene>`` or ``references/<object>``."""
    return f"scenes/{entry['name']}" if "views" in entry else f"references/{entry['object']}"


def open_folder(folder: Path, head: Mapping[str, Any]) -> Entries:
    """Create the folder of a data set, or return the parts that exist in it.

    Parameters
    ----------
    folder : Path
        Absent, empty, or left by a run with the same head.
    head : mapping
        Head of the manifest.

    Returns
    -------
    dict of str to dict
        Manifest entries of the complete parts.

    Raises
    ------
    InputError
        The folder cannot be written, holds other files, or was begun with another head.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        present = sorted(path.name for path in folder.iterdir())
    except OSError as problem:
        raise _unwritable(folder, problem) from None
    if not present:
        return {}
    begun, entries = _begun(folder)
    if not begun:
        must, remedy = "must be empty or hold a data set that was begun", "Choose another folder."
        raise InputError(f"output {folder}", value=present[:5], must=must, remedy=remedy)
    differing = [key for key in sorted(head.keys() | begun.keys()) if head.get(key) != begun.get(key)]
    if differing:
        shown = {key: begun.get(key) for key in differing}
        must = f"must have been begun with the same {', '.join(differing)} as is asked for now"
        raise InputError(f"output {folder}", value=shown, must=must, remedy="Choose another folder.")
    return {name: entry for name, entry in entries.items() if _is_complete(folder, entry)}


def _begun(folder: Path) -> tuple[dict[str, Any], Entries]:
    """Return head and entries of a data set, complete or not; empty if there is none."""
    manifest = _load(folder / MANIFEST)
    if manifest:
        entries = [*manifest.pop("references", []), *manifest.pop("scenes", [])]
        return manifest, {part_name(entry): entry for entry in entries}
    records = (_load(path) for path in sorted((folder / RECORDS).rglob("*.json")))
    return _load(folder / REQUEST), {part_name(entry): entry for entry in records if "object" in entry}


def _load(path: Path) -> dict[str, Any]:
    """Read a record; empty if it is missing or not readable."""
    try:
        record = json.loads(path.read_bytes())
    except (OSError, ValueError):
        return {}
    return record if isinstance(record, dict) else {}


def _is_complete(folder: Path, entry: Mapping[str, Any]) -> bool:
    """Return whether all files of a part exist and have the hashes of its entry."""
    try:
        return all(sha256((folder / path).read_bytes()) == digest for path, digest in _hashes(entry))
    except OSError:
        return False


def _hashes(entry: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield each file of a part and its hash."""
    for view in entry.get("views", [entry]):
        yield view["file"], view["sha256"]
        yield view["mask"], view["mask_sha256"]
    if "overhead" in entry:
        yield entry["overhead"], entry["overhead_sha256"]


def begin(folder: Path, head: Mapping[str, Any], complete: Entries) -> None:
    """Record the request and the complete parts; they replace the manifest, if there is one.

    Raises
    ------
    InputError
        A file cannot be written.
    """
    write_atomic(folder / REQUEST, json_bytes(head))
    if (folder / MANIFEST).exists():
        for entry in complete.values():
            _record_entry(folder, entry)
        (folder / MANIFEST).unlink()


def _record_entry(folder: Path, entry: Mapping[str, Any]) -> None:
    path = folder / RECORDS / f"{part_name(entry)}.json"
    path.parent.mkdir(parents=True, exist_ok=True)
    write_atomic(path, json_bytes(entry))


def keep(folder: Path, drawn: Drawn) -> dict[str, Any]:
    """Move a part's files into the folder, record its entry and return it.

    Raises
    ------
    InputError
        A file cannot be written.
    """
    beside = folder / DRAWING / part_name(drawn.entry)
    try:
        shutil.rmtree(beside, ignore_errors=True)
        for path, content in drawn.files.items():
            (beside / path).parent.mkdir(parents=True, exist_ok=True)
            (beside / path).write_bytes(content)
        for parent in sorted({PurePosixPath(path).parent for path in drawn.files}):
            own = parent.name == drawn.entry.get("name") and len(parent.parts) > 1
            _move(beside / parent, folder / parent, shared=not own)
        shutil.rmtree(beside)
        _record_entry(folder, drawn.entry)
    except OSError as problem:
        raise _unwritable(folder, problem) from None
    return drawn.entry


def _move(source: Path, target: Path, shared: bool) -> None:
    """Move the folder of one scene, or the files of a folder that several scenes share."""
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
    """Write the manifest and remove the temporary files.

    Raises
    ------
    InputError
        The manifest cannot be written.
    """
    write_atomic(folder / MANIFEST, json_bytes(manifest))
    (folder / REQUEST).unlink(missing_ok=True)
    for name in (RECORDS, DRAWING):
        shutil.rmtree(folder / name, ignore_errors=True)


def _unwritable(folder: Path, problem: OSError) -> InputError:
    must = "must be a folder that can be written"
    return InputError(f"output {folder}", value=problem.strerror, must=must, remedy="Choose another place.")
