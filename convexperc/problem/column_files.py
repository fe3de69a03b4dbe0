"""Templates in a file that is opened without being read: the safetensors layout, one template a row.

Eight bytes give the length of a JSON header; the numbers follow it, little-endian. The header's metadata hold
the names, the objects and the modalities. Source: the format's description in the safetensors project.
"""

import errno
import json
import os
import stat
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, BinaryIO, NamedTuple

import numpy as np

from convexperc.errors import FileFormatError, InputError
from convexperc.files import check_json, given_path, parse_json, placed, write_atomic
from convexperc.problem.arrays import BLOCK
from convexperc.problem.columns import Columns
from convexperc.problem.files import partition_record
from convexperc.problem.modalities import Modalities

SCHEMA = "convexperc/library/1"
TENSOR = "templates"
KINDS = {
    "F64": "<f8", "F32": "<f4", "F16": "<f2", "I32": "<i4", "I16": "<i2", "I8": "|i1", "U32": "<u4",
    "U16": "<u2", "U8": "|u1", "BOOL": "|b1",
}  # fmt: skip
"""The number types that float64 holds, by their names in the format."""
ALIGNMENT = 64
"""Bytes that the place of the first number is a multiple of."""
MAX_HEADER = 2**28
"""Longest header in bytes: names of some million templates."""
READABLE = "must be a readable library of templates"
METADATA = "__metadata__"
_STORED = ("schema", "names", "objects", "modalities", "more")


class Stored(NamedTuple):
    """What a file holds.

    Attributes
    ----------
    columns : Columns
        O is mapped into memory, not read.
    modalities : Modalities
    more : mapping of str to JSON value
        What was stored beside them.
    """

    columns: Columns
    modalities: Modalities
    more: Mapping[str, Any]


def write_columns(path: str | os.PathLike[str], stored: Stored) -> None:
    """Write templates to a file, whole or not at all.

    Raises
    ------
    InputError
        `more` is no mapping of str to JSON values, the names are too long for the header, or see
        `convexperc.files.write_atomic`.
    """
    if not isinstance(stored.more, Mapping):
        raise InputError("more", value=stored.more, must="must be a mapping of str to JSON values")
    check_json(dict(stored.more), "more")
    O, names, objects = stored.columns  # noqa: E741 - the paper's symbol
    kind = next(name for name, code in KINDS.items() if np.dtype(code) == O.dtype.newbyteorder("<"))
    (d, p), dtype = O.shape, np.dtype(KINDS[kind])
    record = {
        "names": names, "objects": objects, "modalities": partition_record(stored.modalities),
        "more": dict(stored.more),
    }  # fmt: skip
    metadata = {"schema": SCHEMA} | {key: json.dumps(value) for key, value in record.items()}
    tensor = {"dtype": kind, "shape": [p, d], "data_offsets": [0, p * d * dtype.itemsize]}
    header = json.dumps({METADATA: metadata, TENSOR: tensor}).encode()
    header += b" " * (-(8 + len(header)) % ALIGNMENT)
    if len(header) > MAX_HEADER:
        must, remedy = f"must fit into a header of {MAX_HEADER} bytes", "Shorten the names."
        raise InputError("names, objects and more", value=f"{len(header)} bytes", must=must, remedy=remedy)

    def content() -> Iterator[bytes]:
        yield len(header).to_bytes(8, "little") + header
        rows = max(1, BLOCK // d)
        for start in range(0, p, rows):
            yield np.ascontiguousarray(O[:, start : start + rows].T, dtype=dtype).tobytes()

    write_atomic(path, content())


def open_columns(path: str | os.PathLike[str]) -> Stored:
    """Open a file of `write_columns`; its numbers are mapped into memory.

    Raises
    ------
    FileFormatError
        It is not readable, or holds something else; the part of the header is named.
    """
    place = given_path(path, "library of templates")
    file = os.fspath(path)
    try:
        if not stat.S_ISREG(place.stat().st_mode):  # opening a pipe waits for its other end
            raise FileFormatError(file, value="no ordinary file", must=READABLE, remedy="Check the path.")
        with place.open("rb") as stream:
            header, begin, size = _header(stream, file)
            dtype, shape = _tensor(header[TENSOR], size, f"{file}: {TENSOR}")
            metadata = _metadata(header[METADATA], f"{file}: {METADATA}")
            rows = _mapped(stream, dtype, begin, shape)
    except OSError as problem:
        raise FileFormatError(file, value=problem.strerror, must=READABLE, remedy="Check the path.") from None
    try:
        found = Columns.of(rows.T, metadata["names"], metadata["objects"])
        return Stored(found, Modalities.of(metadata["modalities"], shape[1]), metadata["more"])
    except InputError as error:
        raise placed(file, error) from None


def _header(stream: BinaryIO, file: str) -> tuple[dict[str, Any], int, int]:
    """The header, where the numbers begin, and how many bytes follow it."""
    size = os.fstat(stream.fileno()).st_size
    length = int.from_bytes(stream.read(8), "little")
    if not 2 <= length <= min(MAX_HEADER, size - 8):
        remedy = "Is it a file of `convexperc library` or of TemplateLibrary.save?"
        raise FileFormatError(file, value=f"{size} bytes, header of {length}", must=READABLE, remedy=remedy)
    part = f"{file}: header"
    header = _object(parse_json(stream.read(length), part), (METADATA, TENSOR), part)
    return header, 8 + length, size - 8 - length


def _mapped(stream: BinaryIO, dtype: np.dtype[Any], begin: int, shape: tuple[int, int]) -> Any:
    """The numbers; a file that is shortened meanwhile is refused as unreadable."""
    try:
        return np.memmap(stream, dtype=dtype, mode="r", offset=begin, shape=shape)
    except ValueError as problem:
        raise OSError(errno.EIO, str(problem)) from None


def _tensor(tensor: Any, size: int, part: str) -> tuple[np.dtype[Any], tuple[int, int]]:
    """The type and the shape of the numbers, which are all that follows the header."""
    record = _object(tensor, ("dtype", "shape", "data_offsets"), part)
    kind, shape, offsets = record["dtype"], record["shape"], record["data_offsets"]
    if not isinstance(kind, str) or kind not in KINDS:
        raise FileFormatError(f"{part}: dtype", value=kind, must=f"must be one of {', '.join(KINDS)}")
    if not _integers(shape) or len(shape) != 2 or min(shape) < 1:
        must = "must be two integers >= 1: templates, features"
        raise FileFormatError(f"{part}: shape", value=shape, must=must)
    if not _integers(offsets) or offsets != [0, size]:
        must = f"must be [0, {size}]: all bytes that follow the header"
        raise FileFormatError(f"{part}: data_offsets", value=offsets, must=must)
    dtype, (p, d) = np.dtype(KINDS[kind]), shape
    if p * d * dtype.itemsize != size:
        must = f"must fill the {size} bytes that follow the header, {dtype.itemsize} a number"
        raise FileFormatError(f"{part}: shape", value=shape, must=must)
    return dtype, (p, d)


def _metadata(metadata: Any, part: str) -> dict[str, Any]:
    """What the header says of the templates, each part of the type that `write_columns` gives it."""
    texts = _object(metadata, _STORED, part)
    for key, text in texts.items():
        if type(text) is not str:
            raise FileFormatError(f"{part}: {key}", value=text, must="must be a string")
    if texts["schema"] != SCHEMA:
        raise FileFormatError(f"{part}: schema", value=texts["schema"], must=f"must be {SCHEMA!r}")
    found = {key: parse_json(texts[key], f"{part}: {key}") for key in _STORED[1:]}
    for key in ("names", "objects"):
        if found[key] is not None and not _all_of(found[key], str):
            must = "must be null or a list of strings, one a template"
            raise FileFormatError(f"{part}: {key}", value=found[key], must=must)
    groups = found["modalities"]
    if not isinstance(groups, dict) or not all(
        type(each) is int or _integers(each) for each in groups.values()
    ):
        must = "must be a JSON object of names with sizes or lists of columns"
        raise FileFormatError(f"{part}: modalities", value=groups, must=must)
    try:
        check_json(_object(found["more"], None, f"{part}: more"), "more")
    except InputError as error:
        raise placed(part, error) from None
    return found


def _object(value: Any, keys: Iterable[str] | None, part: str) -> dict[str, Any]:
    """A JSON object, with these keys and no others if they are given."""
    if not isinstance(value, dict):
        raise FileFormatError(part, value=value, must="must be a JSON object")
    if keys is not None and set(value) != set(keys):
        must = f"must have exactly the keys {', '.join(keys)}, as a library of templates ({SCHEMA}) has"
        raise FileFormatError(part, value=list(value), must=must)
    return value


def _integers(value: Any) -> bool:
    return _all_of(value, int)


def _all_of(value: Any, kind: type) -> bool:
    """Whether it is a list whose entries are of exactly this type: no boolean, and no `NoFloat`."""
    return isinstance(value, list) and all(type(each) is kind for each in value)
