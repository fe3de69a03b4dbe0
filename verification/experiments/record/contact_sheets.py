"""Contact sheets that lie beside a record of the experiments: JPEG pictures bound to it by its digest."""

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path

from convexperc.errors import FileFormatError
from convexperc.files import json_bytes

MANIFEST = "sheets.json"
REMEDY = "Make record and sheets again by `python -m verification experiments`."


def sheet_files(digest: str, sheets: Mapping[str, bytes]) -> dict[str, bytes]:
    """The files of a folder of sheets: the pictures, and a manifest that names the record.

    Parameters
    ----------
    digest : str
        Of the record.
    sheets : mapping of str to bytes
        JPEG by name, without an ending.
    """
    if not sheets:
        return {}
    named = {f"{name}.jpg": data for name, data in sheets.items()}
    hashes = {name: hashlib.sha256(data).hexdigest() for name, data in sorted(named.items())}
    return named | {MANIFEST: json_bytes({"record": digest, "files": hashes})}


def read_sheets(folder: Path, digest: str) -> dict[str, bytes]:
    """Read the sheets of a record, in the order of their names; empty if there is no folder of them.

    Raises
    ------
    FileFormatError
        They belong to another record, or one of them was changed.
    """
    place = folder / MANIFEST
    if not place.is_file():
        return {}
    try:
        manifest = json.loads(place.read_text(encoding="utf-8"))
        record, files = manifest["record"], dict(manifest["files"])
        found = {Path(name).stem: (folder / Path(name).name).read_bytes() for name in sorted(files)}
    except (OSError, ValueError, TypeError, LookupError) as problem:
        must = "must list the sheets beside it"
        raise FileFormatError(MANIFEST, value=str(problem), must=must, remedy=REMEDY) from None
    if record != digest:
        must = f"must be that of the record, {digest}"
        raise FileFormatError(f"record of {MANIFEST}", value=record, must=must, remedy=REMEDY)
    for name, expected in files.items():
        if (value := hashlib.sha256(found[Path(name).stem]).hexdigest()) != expected:
            raise FileFormatError(name, value=value, must=f"must have SHA-256 {expected}", remedy=REMEDY)
    return found
