"""Templates in a file that is opened without being read: the safetensors layout, one template a row.

Eight bytes give the length of a JSON header; the numbers follow it, little-endian. The header's metadata hold
the names, the objects and the modalities. Source: the format's description in the safetensors project.
"""

import json
import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from convexperc.errors import FileFormatError, InputError
from convexperc.files import parse_json, placed, write_atomic
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
        See `convexperc.files.write_atomic`.
    """
    O, names, objects = stored.columns  # noqa: E741 - the paper's symbol
    kind = next(name for name, code in KINDS.items() if np.dtype(code) == O.dtype.newbyteorder("<"))
    (d, p), dtype = O.shape, np.dtype(KINDS[kind])
    record = {
        "schema": SCHEMA, "names": names, "objects": objects,
        "modalities": partition_record(stored.modalities), "more": dict(stored.more),
    }  # fmt: skip
    metadata = {key: value if key == "schema" else json.dumps(value) for key, value in record.items()}
    tensor = {"dtype": kind, "shape": [p, d], "data_offsets": [0, p * d * dtype.itemsize]}
    header = json.dumps({"__metadata__": metadata, TENSOR: tensor}).encode()
    header += b" " * (-(8 + len(header)) % ALIGNMENT)

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
        It is not readable, or holds something else.
    """
    file = os.fspath(path)
    header, begin, size = _header(Path(path), file)
    try:
        metadata, tensor = header["__metadata__"], header[TENSOR]
        kind, shape, place = tensor["dtype"], tensor["shape"], tensor["data_offsets"]
        schema = metadata["schema"]
        names, objects, modalities, more = (
            parse_json(metadata[key], f"{file}: {key}") for key in ("names", "objects", "modalities", "more")
        )
    except (KeyError, TypeError) as problem:
        must = f"must be a library of templates ({SCHEMA})"
        raise FileFormatError(file, value=f"no {problem}", must=must) from None
    if schema != SCHEMA:
        raise FileFormatError(f"{file}: schema", value=schema, must=f"must be {SCHEMA!r}")
    if kind not in KINDS:
        raise FileFormatError(f"{file}: dtype", value=kind, must=f"must be one of {', '.join(KINDS)}")
    dtype = np.dtype(KINDS[kind])
    if not (_is_shape(shape) and place == [0, size] and shape[0] * shape[1] * dtype.itemsize == size):
        value = f"shape {shape}, place {place}, {size} bytes"
        raise FileFormatError(f"{file}: {TENSOR}", value=value, must="must be all that follows the header")
    rows = np.memmap(path, dtype=dtype, mode="r", offset=begin, shape=(shape[0], shape[1]))
    try:
        found = Columns.of(rows.T, names, objects)
        return Stored(found, Modalities.of(modalities, shape[1]), more)
    except InputError as error:
        raise placed(file, error) from None


def _header(path: Path, file: str) -> tuple[Any, int, int]:
    """The header, where the numbers begin, and how many bytes follow it."""
    must = "must be a readable library of templates"
    try:
        with path.open("rb") as stream:
            size = os.fstat(stream.fileno()).st_size
            length = int.from_bytes(stream.read(8), "little")
            if not 2 <= length <= min(MAX_HEADER, size - 8):
                raise FileFormatError(file, value=f"{size} bytes, header of {length}", must=must)
            text = stream.read(length)
    except OSError as problem:
        raise FileFormatError(file, value=problem.strerror, must=must, remedy="Check the path.") from None
    return parse_json(text, file), 8 + length, size - 8 - length


def _is_shape(value: Any) -> bool:
    return isinstance(value, list) and len(value) == 2 and all(type(n) is int and n > 0 for n in value)
