"""What a run has finished, one file a reading, so that one that is killed goes on where it was."""

import json
from hashlib import sha256
from pathlib import Path
from typing import Any

from convexperc.files import write_atomic


def canonical(data: Any) -> bytes:
    """One text for equal data."""
    return json.dumps(data, sort_keys=True, separators=(",", ":"), allow_nan=False).encode()


def digest(data: Any) -> str:
    """SHA-256 of the canonical text."""
    return sha256(canonical(data)).hexdigest()


class Journal:
    """A folder of finished tasks.

    Parameters
    ----------
    folder : Path
        Of all journals; made when missing.
    head : dict
        All that an outcome depends on, beside the task's own name.
    """

    def __init__(self, folder: Path, head: dict[str, Any]) -> None:
        self._head = digest(head)
        self._folder = folder / self._head[:16]
        self._folder.mkdir(parents=True, exist_ok=True)

    def get(self, name: str) -> dict[str, Any] | None:
        """What was kept, or None where there is nothing, or nothing whole of the same head."""
        try:
            kept = json.loads(self._place(name).read_text(encoding="utf-8"))
            whole = kept["head"] == self._head and kept["digest"] == digest(kept["found"])
        except (OSError, ValueError, LookupError, TypeError):
            return None
        return dict(kept["found"]) if whole else None

    def put(self, name: str, found: dict[str, Any]) -> None:
        """Keep one; it is on the disk before this returns."""
        data = {"head": self._head, "digest": digest(found), "found": found}
        write_atomic(self._place(name), canonical(data) + b"\n")

    def _place(self, name: str) -> Path:
        return self._folder / f"{name}.json"
