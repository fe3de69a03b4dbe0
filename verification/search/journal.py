"""The journal of a run: one line a finished shard, so that a run that is killed goes on where it was.

The first line says what the outcome depends on. Each further line is one shard with the hash of its own text;
a last line that was cut off, or does not match, is dropped and its shard is done again.
"""

import hashlib
import json
import os
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

from verification.search.shards import Case, Found, Tally


def canonical(data: Any) -> str:
    """One text for equal data."""
    return json.dumps(data, sort_keys=True, separators=(",", ":"), allow_nan=True)


class Journal:
    """What a run has done so far, on disk.

    Parameters
    ----------
    file : Path
        Created with its folder. A journal of the same head that is not finished is continued; any other is
        set aside under the name ``FILE.old``.
    head : dict
        All that the outcome depends on.

    Attributes
    ----------
    found : dict of str to Found
        By shard, as read back.
    """

    def __init__(self, file: Path, head: dict[str, Any]) -> None:
        self._file, self.found = file, dict[str, Found]()
        file.parent.mkdir(parents=True, exist_ok=True)
        lines = list(_lines(file)) if file.exists() else []
        if lines and lines[0] == {"head": head} and {"finished": True} not in lines:
            self.found = {line["found"]["key"]: _found(line["found"]) for line in lines[1:]}
        elif file.exists():
            file.replace(file.with_name(file.name + ".old"))
        kept = [{"head": head}, *({"found": asdict(each)} for each in self.found.values())]
        part = file.with_name(file.name + ".part")
        part.write_text("".join(_line(each) for each in kept), encoding="utf-8")
        part.replace(file)

    def add(self, found: Found) -> None:
        """Keep one shard, on the disk before this returns."""
        self.found[found.key] = found
        self._append({"found": asdict(found)})

    def finish(self) -> None:
        """Say that nothing is left to do: the next run of the same settings starts anew."""
        self._append({"finished": True})

    def _append(self, data: dict[str, Any]) -> None:
        with self._file.open("a", encoding="utf-8") as stream:
            stream.write(_line(data))
            stream.flush()
            os.fsync(stream.fileno())


def _line(data: dict[str, Any]) -> str:
    text = canonical(data)
    return f"{hashlib.sha256(text.encode()).hexdigest()[:16]} {text}\n"


def _lines(file: Path) -> Iterator[dict[str, Any]]:
    """The lines that are whole; nothing after the first that is not."""
    for line in file.read_text(encoding="utf-8", errors="replace").split("\n"):
        mark, _, text = line.partition(" ")
        if hashlib.sha256(text.encode()).hexdigest()[:16] != mark:
            return
        yield json.loads(text)


def _found(data: dict[str, Any]) -> Found:
    tallies = {part: _tally(tally) for part, tally in data["tallies"].items()}
    return Found(data["key"], data["problems"], tallies, list(data["broken"]))


def _tally(data: dict[str, Any]) -> Tally:
    case = data["smallest"]
    smallest = None if case is None else Case(**case | {"size": (case["size"][0], case["size"][1])})
    decades = {int(decade): count for decade, count in data["decades"].items()}
    return Tally(dict(data["outcomes"]), data["worst"], decades, smallest)
