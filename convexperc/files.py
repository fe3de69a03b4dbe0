"""Strict reading of JSON, and atomic writing of files."""

import json
import math
import os
import unicodedata
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from convexperc.errors import FileFormatError, InputError

Places = Path | Sequence[Path] | None
"""Of an option: the file or folder that it names, or those; None, or none of them, where it is not given."""
MUST_BE_JSON = "must be a readable JSON file"
DEEPEST = 100
"""Lists and objects in each other that `check_json` allows."""


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
    place = given_path(path)
    file = os.fspath(path)
    try:
        content = place.read_bytes()
    except OSError as problem:
        value, remedy = problem.strerror, "Check the path."
        raise FileFormatError(file, value=value, must=MUST_BE_JSON, remedy=remedy) from None
    return file, parse_json(content, file)


def given_path(
    path: str | os.PathLike[str], what: str = "path", error: type[InputError] = FileFormatError
) -> Path:
    """Return a path of the caller's as a `Path`, whether or not there is such a file.

    Raises
    ------
    InputError
        Of the class given: no string or path-like of one, or with a character that no file's name can have.
    """
    try:
        text: object = os.fspath(path)
        if isinstance(text, str) and b"\0" not in os.fsencode(text):
            return Path(text)
    except (TypeError, ValueError):  # of another type; a surrogate that stands for no byte
        pass
    must = "must be a path: a string or path-like without characters that no file's name can have"
    raise error(what, value=path, must=must)


def parse_json(content: bytes | str, file: str) -> Any:
    """Return a JSON value; `file` names its source in errors.

    Raises
    ------
    FileFormatError
        It is not JSON, or repeats a key.
    """

    def once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        keys = [key for key, _ in pairs]
        for key in keys if len(set(keys)) < len(keys) else ():
            if keys.count(key) > 1:
                raise FileFormatError(f"{file}: key", value=key, must="must be given once")
        return dict(pairs)

    try:
        text = content if isinstance(content, str) else content.decode("utf-8-sig")
        return json.loads(text, object_pairs_hook=once, parse_constant=NoFloat, parse_float=_float)
    except FileFormatError:
        raise
    except (ValueError, RecursionError) as problem:
        raise FileFormatError(file, value=str(problem), must=MUST_BE_JSON) from None


def check_json(value: Any, part: str) -> None:
    """Check that a value is read again as it is written: a list or tuple comes back as a list.

    Raises
    ------
    InputError
        It holds a number that is not finite, a key that is no string, or a value that JSON does not have.
    """
    try:
        _check_json(value, part, DEEPEST)
        json.dumps(value)
    except InputError:
        raise
    except ValueError as problem:  # an integer of over 4,300 digits
        must = "must be a JSON value"
        raise InputError(part, value=value, must=must, remedy=f"{problem}.") from None


def _check_json(value: Any, part: str, deepest: int) -> None:
    if value is None or isinstance(value, int) or (isinstance(value, float) and math.isfinite(value)):
        return
    if isinstance(value, str) and not isinstance(value, NoFloat):
        return
    if not isinstance(value, (dict, list, tuple)) or not deepest:
        must = f"must be a JSON value: numbers that float64 holds, at most {DEEPEST} lists in each other"
        raise InputError(part, value=value, must=must)
    entries: Iterable[tuple[Any, Any]] = value.items() if isinstance(value, dict) else enumerate(value)
    for key, entry in entries:
        if isinstance(value, dict) and not isinstance(key, str):
            raise InputError(f"a key of {part}", value=key, must="must be a string")
        _check_json(entry, f"{part}[{key!r}]", deepest - 1)


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


def write_atomic(path: str | os.PathLike[str], data: bytes | Iterable[bytes]) -> None:
    """Write a file, whole or in parts, atomically: to a temporary one in the same folder, then renamed.

    Raises
    ------
    InputError
        See `check_place`; or writing fails, for example because the disk is full.
    """
    place = check_place(path)
    beside = place.with_name(f".{os.urandom(6).hex()}.part")
    try:
        try:
            with beside.open("xb") as stream:
                for part in (data,) if isinstance(data, bytes) else data:
                    stream.write(part)
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
        It is no path, the folder does not exist or is not writable, the path exists and is not a file, or it
        is in ``/dev`` or ``/proc``: ``/dev/stdout``, for example, may be another program's file, which would
        be replaced.
    """
    given = given_path(path, "output", InputError)
    try:
        place = given.resolve()
        device = given.absolute().parts[1:2] in (("dev",), ("proc",))
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


def check_apart(
    files: Mapping[str, Path | None],
    *,
    folders: Mapping[str, Path | None] | None = None,
    inputs: Mapping[str, Places] | None = None,
) -> None:
    """Check that no output of a command is an input or another output; call before any work.

    Files are the same where the system says so, whatever their names; two that do not exist yet are taken for
    the same if their names differ by case or Unicode normalisation alone.

    Parameters
    ----------
    files, folders : mapping of str to Path or None
        The files that are written and the folders that are filled, by what an error calls them, for example
        their options; None is skipped.
    inputs : mapping of str to Path or None
        The files and folders that are read; several may have one name.

    Raises
    ------
    InputError
        Two outputs are the same, or one is an input; a file lies directly in a folder that is read, where it
        would be read the next time, or an entry of that folder leads to it; or a filled folder contains an
        input or another output, or lies in one.
    """
    written, filled, read = _given(files), _given(folders or {}), _given(inputs or {})
    for i, (name, path) in enumerate(written):
        _refuse(name, path, (*read, *written[:i]), _same, "must be another file than {}")
        _refuse(name, path, read, _is_read_with, "must not lie in the folder of {}, which is read")
    for i, (name, path) in enumerate(filled):
        others = *read, *written, *filled[:i]
        _refuse(name, path, others, _overlap, "must neither contain {} nor lie in it")


def _given(places: Mapping[str, Places]) -> list[tuple[str, Path]]:
    several = ((name, (given,) if isinstance(given, Path) else given or ()) for name, given in places.items())
    return [(name, path) for name, paths in several for path in paths]


def _refuse(
    name: str,
    path: Path,
    others: Iterable[tuple[str, Path]],
    collide: Callable[[Path, Path], bool],
    must: str,
) -> None:
    for other, place in others:
        if collide(path, place):
            remedy = "Choose another place."
            raise InputError(name, value=os.fspath(path), must=must.format(other), remedy=remedy)


def _is_read_with(path: Path, place: Path) -> bool:
    """Return whether a file lies in a folder, or is what an entry of the folder leads to."""
    if not place.is_dir():
        return False
    if _same(_resolved(path).parent, place):
        return True
    try:
        found = path.stat()
    except (OSError, ValueError, RuntimeError):
        return False  # there is nothing yet that a link could lead to
    return any(os.path.samestat(found, each) for each in _entries(place))


def _entries(folder: Path) -> Iterator[os.stat_result]:
    """What the entries of a folder are; those that cannot be read are refused when they are."""
    with suppress(OSError), os.scandir(folder) as entries:
        for entry in entries:
            with suppress(OSError):
                yield entry.stat()


def _overlap(one: Path, other: Path) -> bool:
    pairs = (one, other), (other, one)
    return any(_same(folder, each) for folder, path in pairs for each in (path, *_resolved(path).parents))


def _same(one: Path, other: Path) -> bool:
    """Return whether two paths lead to one file or folder; see `check_apart` where neither exists."""
    try:
        return one.samefile(other)
    except (OSError, ValueError, RuntimeError):
        if os.path.exists(one) != os.path.exists(other):  # noqa: PTH110 - false for what cannot be asked for
            return False
        found = _resolved(one), _resolved(other)
        if found[0] == found[1] or any(map(os.path.lexists, found)):
            return found[0] == found[1]
        names = (unicodedata.normalize("NFC", path.name).casefold() for path in found)
        return next(names) == next(names) and _same(found[0].parent, found[1].parent)


def _resolved(path: Path) -> Path:
    """Follow the links of a path; one that cannot be followed is refused when it is used."""
    try:
        return path.resolve()
    except (OSError, ValueError, RuntimeError):
        return path.absolute()


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
