"""The journal of a run: plain data by name, so that a run that is killed goes on where it was.

The first line says what the outcome depends on. Each further line is one entry with the digest of its own
text; a line that was cut off, or does not match, is dropped and its work is done again.
"""

import hashlib
import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from convexperc.errors import FileFormatError
from convexperc.files import write_atomic
from verification.provenance import canonical

MARK = 16
"""Letters of the SHA-256 that begins a line."""
FINISHED = {"finished": True}
"""The last line of a journal that has everything."""


def read_head(file: Path) -> dict[str, Any]:
    """What the outcome of a journal depends on.

    Raises
    ------
    OSError
        The file cannot be read.
    FileFormatError
        It does not begin as a journal.
    """
    first = next(_lines(file), {})
    if "head" not in first:
        raise FileFormatError(file.name, value="no head", must="must be the journal of a run")
    head: dict[str, Any] = first["head"]
    return head


class Journal:
    """What a run has done so far, on disk.

    Parameters
    ----------
    file : Path
        Created with its folder. A journal of the same head that is not finished is continued; any other is
        set aside under the name ``FILE.old``.
    head : dict
        All that the outcome depends on, as plain data.
    reopen : bool
        Whether a finished journal of the same head is continued, too.

    Attributes
    ----------
    entries : dict of str to plain data
        By name, as read back.
    """

    def __init__(self, file: Path, head: dict[str, Any], *, reopen: bool = False) -> None:
        self._file, self.entries = file, dict[str, Any]()
        file.parent.mkdir(parents=True, exist_ok=True)
        lines = list(_lines(file)) if file.exists() else []
        same = bool(lines) and lines[0] == {"head": json.loads(canonical(head))}
        if same and (reopen or FINISHED not in lines):
            self.entries = {line["name"]: line["entry"] for line in lines[1:] if line != FINISHED}
        elif file.exists():
            file.replace(file.with_name(file.name + ".old"))
        kept = [{"head": head}, *({"name": name, "entry": entry} for name, entry in self.entries.items())]
        write_atomic(file, b"".join(_line(each) for each in kept))

    def put(self, name: str, entry: Any) -> None:
        """Keep one entry; it is on the disk before this returns."""
        self.entries[name] = entry
        self._append({"name": name, "entry": entry})

    def finish(self) -> None:
        """Say that nothing is left to do: the next run of the same head starts anew."""
        self._append(FINISHED)

    def _append(self, data: dict[str, Any]) -> None:
        with self._file.open("ab") as stream:
            stream.write(_line(data))
            stream.flush()
            os.fsync(stream.fileno())


def _line(data: dict[str, Any]) -> bytes:
    text = canonical(data)
    return _mark(text) + b" " + text + b"\n"


def _lines(file: Path) -> Iterator[dict[str, Any]]:
    """The lines that are whole."""
    for line in file.read_bytes().split(b"\n"):
        mark, _, text = line.partition(b" ")
        if _mark(text) == mark:
            yield json.loads(text)


def _mark(text: bytes) -> bytes:
    """The first letters of the text's SHA-256."""
    return hashlib.sha256(text).hexdigest()[:MARK].encode()
