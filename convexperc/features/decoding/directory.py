"""The directory of a TIFF: its entries that affect pixels, verified; decoders skip what they cannot read.

Source: Adobe, TIFF Revision 6.0, section 2 (structure of the file).
"""

import struct
from typing import NamedTuple

_BYTE, _SHORT, _LONG, _UNDEFINED = 1, 3, 4, 7
_SIZES = {_BYTE: 1, _SHORT: 2, _LONG: 4, _UNDEFINED: 1}
_ENTRY_BYTES, _INLINE_BYTES = 12, 4

_BITS, _COMPRESSION, _SAMPLES, _SAMPLE_FORMAT, _TABLES = 258, 259, 277, 339, 347
_SINGLE = (256, 257, _COMPRESSION, 262, 266, 274, _SAMPLES, 278, 284, 317, 322, 323)
"""Tags with one value: size, compression, colors, order of bits, orientation, strips, predictor, tiles."""
_FOR_SAMPLES = (_BITS, _SAMPLE_FORMAT)
"""Tags with a value for each sample; some programs write one for all."""
_LISTS = (273, 279, 320, 324, 325, 338, 530)
"""Tags whose number of values is verified where they are used."""


class _Entry(NamedTuple):
    kind: int
    number: int
    values: tuple[int, ...]


def check(data: bytes) -> None:
    """Refuse a first directory in which an entry that affects pixels is damaged.

    Raises
    ------
    ValueError
        An entry twice, of another type or with another number of values than its tag has, or samples of
        different numbers of bits.
    struct.error
        Entries that reach beyond the file.
    """
    order = "<" if data.startswith(b"II") else ">"
    (start,) = struct.unpack_from(f"{order}I", data, 4)
    (count,) = struct.unpack_from(f"{order}H", data, start)
    entries: dict[int, _Entry] = {}
    for place in range(start + 2, start + 2 + count * _ENTRY_BYTES, _ENTRY_BYTES):
        (tag,) = struct.unpack_from(f"{order}H", data, place)
        if tag in (*_SINGLE, *_FOR_SAMPLES, *_LISTS, _TABLES):
            if tag in entries:
                raise ValueError(f"a TIFF with the tag {tag} twice")
            entries[tag] = _entry(data, order, place)
    samples = entries[_SAMPLES].values[0] if _SAMPLES in entries else 1
    for tag, entry in entries.items():
        kinds = (_UNDEFINED, _BYTE) if tag == _TABLES else (_BYTE, _SHORT, _LONG)
        wrong = (tag in _SINGLE and entry.number != 1) or (
            tag in _FOR_SAMPLES and entry.number not in (1, samples)
        )
        if entry.kind not in kinds or not entry.number or wrong:
            raise ValueError(f"a TIFF whose tag {tag} has {entry.number} values of type {entry.kind}")
    if _BITS in entries and len(set(entries[_BITS].values)) > 1:
        raise ValueError(f"a TIFF with samples of {entries[_BITS].values} bits")


def _entry(data: bytes, order: str, place: int) -> _Entry:
    kind, count = struct.unpack_from(f"{order}HI", data, place + 2)
    size = _SIZES.get(kind, 0) * count
    if not size:
        return _Entry(kind, 0, (0,))
    start = place + 8
    if size > _INLINE_BYTES:
        (start,) = struct.unpack_from(f"{order}I", data, start)
    if start + size > len(data):
        raise struct.error
    letter = {1: "B", 2: "H", 4: "I"}[_SIZES[kind]]
    return _Entry(kind, count, struct.unpack_from(f"{order}{count}{letter}", data, start))
