"""Files of machine code: where they lie, and whether one may be used.

A file is named by the digest of all that it was compiled from, so that code that is older than its source is
never found. It begins with the hash of its content: a damaged file is not used. A file is only trusted if it
belongs to this user, to the owner of the package, or to the administrator.
"""

import contextlib
import hashlib
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path

FOLDER_VARIABLE = "CONVEXPERC_CACHE_DIR"
"""Environment variable: the only folder to be used."""
SUFFIX = ".machine-code"
HASH_BYTES = 32
KEPT = 4
"""Files of one kernel that are kept beside the sources: several versions of Python may share these."""
BESIDE_SOURCES = Path(__file__).resolve().parent / "__pycache__"


def folders() -> Iterator[Path]:
    """Where machine code may lie, the best place first: beside the sources, or in the user's cache."""
    chosen = os.environ.get(FOLDER_VARIABLE)
    if chosen:
        yield Path(chosen)
        return
    if BESIDE_SOURCES.parent.is_dir():  # not in an archive
        yield BESIDE_SOURCES
    home = os.environ.get("XDG_CACHE_HOME") or os.environ.get("LOCALAPPDATA")
    if home:
        yield Path(home) / "convexperc"
    else:
        with contextlib.suppress(RuntimeError):  # no home is known
            yield Path.home() / ".cache" / "convexperc"


def places(name: str) -> list[Path]:
    """The files of this name that may be used, in any form; their content is not looked at."""
    return [path for folder in folders() for path in _files(folder, f"{name}-*")]


def read(name: str, form: str) -> bytes | None:
    """What was written; None if there is nothing, or nothing that is whole and may be used."""
    for folder in folders():
        for path in _files(folder, f"{name}-{form}"):
            with contextlib.suppress(OSError):
                content = path.read_bytes()
                head, rest = content[:HASH_BYTES], content[HASH_BYTES:]
                if rest and hashlib.sha256(rest).digest() == head:
                    return rest
    return None


def write(name: str, form: str, content: bytes) -> Path | None:
    """Keep the content in the first folder that can be written, whole or not at all.

    Returns
    -------
    pathlib.Path or None
        Where it lies; None if no folder can be written.
    """
    for folder in folders():
        with contextlib.suppress(OSError):
            folder.mkdir(parents=True, exist_ok=True)
            handle, temporary = tempfile.mkstemp(dir=folder, prefix=".", suffix=SUFFIX)
            try:
                with os.fdopen(handle, "wb") as file:
                    file.write(hashlib.sha256(content).digest() + content)
                Path(temporary).chmod(0o644)  # readable by the other users of this installation
                if folder == BESIDE_SOURCES:
                    _drop_older(name)
                return Path(temporary).replace(folder / f"{name}-{form}{SUFFIX}")
            except OSError:
                Path(temporary).unlink(missing_ok=True)
                raise
    return None


def _drop_older(name: str) -> None:
    """Remove what was compiled longest ago, from earlier sources of this installation."""
    others = [
        (path.stat().st_mtime_ns, path)
        for path in _files(BESIDE_SOURCES, f"{name.rpartition('-')[0]}-*")
        if not path.name.startswith(name)
    ]
    for _, path in sorted(others, reverse=True)[KEPT - 1 :]:
        path.unlink(missing_ok=True)


def _files(folder: Path, pattern: str) -> Iterator[Path]:
    """The files of a folder that nobody else could have made."""
    found: list[Path] = []
    with contextlib.suppress(OSError):
        found = sorted(folder.glob(pattern + SUFFIX))
    for path in found:
        with contextlib.suppress(OSError):  # another process may have removed it
            if not hasattr(os, "getuid") or path.stat().st_uid in _owners():
                yield path


def _owners() -> set[int]:
    """The administrator, this user, and whoever owns the package."""
    owners = {0, os.getuid()}
    with contextlib.suppress(OSError):  # in an archive
        owners.add(Path(__file__).stat().st_uid)
    return owners
