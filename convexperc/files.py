"""Strict reading of JSON, and atomic writing of files."""

import json
import math
import os
import secrets
from collections.abc import Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from convexperc.errors import FileFormatError, InputError


class NoFloat(str):
    """A number as the file writes it that float64 does not hold: refused where a number is expected.

    NaN and infinity, which are not JSON, and what float64 would turn into infinity or into 0.
    """

    __slots__ = ()


def read_json(path: str | os.PathLike[str]) -> tuple[str, Any]:
    """Return the file's name, for errors, and its JSON value.

    Raises
    ------
    FileFormatError
        The file is not readable or not JSON, or repeats a key.
    """
    file = os.fspath(path)

    def once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        keys = [key for key, _ in pairs]
        for key in keys if len(set(keys)) < len(keys) else ():
            if keys.count(key) > 1:
                raise FileFormatError(f"{file}: key", value=key, must="must be given once")
        return dict(pairs)

    must = "must be a readable JSON file"
    try:
        text = Path(path).read_bytes().decode("utf-8-sig")
        return file, json.loads(text, object_pairs_hook=once, parse_constant=NoFloat, parse_float=_float)
    except FileFormatError:
        raise
    except OSError as problem:
        raise FileFormatError(file, value=problem.strerror, must=must, remedy="Check the path.") from None
    except (ValueError, RecursionError) as problem:
        raise FileFormatError(file, value=str(problem), must=must) from None


def _float(text: str) -> float | NoFloat:
    """The nearest float64 of a decimal number, if it is neither infinite nor 0 for another number."""
    value = float(text)
    lost = value == 0.0 and text.lower().partition("e")[0].strip("-0.")
    return NoFloat(text) if lost or math.isinf(value) else value


def placed(file: str, error: InputError) -> FileFormatError:
    """Return the same error as a `FileFormatError` that names the file."""
    return FileFormatError(f"{file}: {error.what}", value=error.value, must=error.must, remedy=error.remedy)


def write_json(path: str | os.PathLike[str], record: Mapping[str, Any]) -> None:
    """Write `record` as JSON, each innermost list on one line; errors as in `write_atomic`."""
    write_atomic(path, json_bytes(record))


def json_bytes(record: Mapping[str, Any]) -> bytes:
    """Return what `write_json` writes."""
    return (_layout(record, "") + "\n").encode()


def write_atomic(path: str | os.PathLike[str], data: bytes) -> None:
    """Write a file atomically: to a temporary file in the same folder, which is then renamed.

    Raises
    ------
    InputError
        See `check_place`; or writing fails, for example because the disk is full.
    """
    place = check_place(path)
    beside = place.with_name(f".{secrets.token_hex(6)}.part")
    try:
        try:
            with beside.open("xb") as stream:
                stream.write(data)
                stream.flush()
                os.fsync(stream.fileno())
            beside.replace(place)
        except BaseException:
            with suppress(OSError):
                beside.unlink(missing_ok=True)
            raise
    except OSError as problem:
        raise _unwritable(path, problem.strerror) from None


def check_place(path: str | os.PathLike[str]) -> Path:
    """Return the resolved path of a file to be written, after checking that it can be; call before long work.

    Raises
    ------
    InputError
        The folder does not exist or is not writable, the path exists and is not a file, or it is in ``/dev``
        or ``/proc``: ``/dev/stdout``, for example, may be another program's file, which would be replaced.
    """
    try:
        place = Path(path).resolve()
        device = Path(path).absolute().parts[1:2] in (("dev",), ("proc",))
        if device or (place.exists() and not place.is_file()):
            raise _unwritable(path, "no ordinary file")
    except (OSError, ValueError, RuntimeError) as problem:
        if isinstance(problem, InputError):
            raise
        raise _unwritable(path, str(problem)) from None
    if not place.parent.is_dir():
        raise _unwritable(path, "no such folder")
    if not os.access(place.parent, os.W_OK | os.X_OK):
        raise _unwritable(path, "no permission in its folder")
    return place


def _unwritable(path: str | os.PathLike[str], found: str | None) -> InputError:
    must = "must be a file that can be written"
    return InputError(f"output {os.fspath(path)}", value=found, must=must, remedy="Choose another place.")


def _layout(value: Any, indent: str) -> str:
    """Format as JSON with one line for each entry, but innermost lists and pairs on one line."""
    deeper = indent + "  "
    if isinstance(value, Mapping) and (len(value) > 2 or _nested(value.values())):
        parts = [f"{json.dumps(key)}: {_layout(entry, deeper)}" for key, entry in value.items()]
        return "{\n" + ",\n".join(deeper + part for part in parts) + f"\n{indent}}}"
    if isinstance(value, list) and _nested(value):
        parts = [deeper + _layout(entry, deeper) for entry in value]
        return "[\n" + ",\n".join(parts) + f"\n{indent}]"
    return json.dumps(value, allow_nan=False)


def _nested(values: Iterable[Any]) -> bool:
    return any(isinstance(value, (Mapping, list)) for value in values)
