"""The headers of picture files: size and completeness, judged before any pixel is decoded."""

import re
import struct
import zlib
from collections.abc import Callable

_JPEG_MARKER = re.compile(rb"\xff([^\x00\xff\xd0-\xd7])")


def png_size(data: bytes) -> tuple[int, int]:
    """(height, width), after a check of every chunk up to IEND and of its checksum."""
    position, kind = 8, b""
    while kind != b"IEND":
        length, kind = struct.unpack_from(">I4s", data, position)
        end = position + 8 + length
        if struct.unpack_from(">I", data, end) != (zlib.crc32(memoryview(data)[position + 4 : end]),):
            raise ValueError(f"a wrong checksum in the PNG's {kind!r} chunk")
        if kind == b"tRNS" and data[25] == 0:
            raise ValueError("a gray PNG with one transparent level, which would be lost")
        position = end + 4
    width, height = struct.unpack_from(">II", data, 16)
    return height, width


def jpeg_size(data: bytes) -> tuple[int, int]:
    """Walk the segments to the end marker; an end marker inside one (a thumbnail's) does not count."""
    size, position = (0, 0), 2
    while found := _JPEG_MARKER.search(data, position):
        marker, position = found[1][0], found.end()
        if marker == 0xD9:
            return size
        if marker not in (0x01, 0xD8):
            (length,) = struct.unpack_from(">H", data, position)
            if 0xC0 <= marker <= 0xCF and marker not in (0xC4, 0xC8, 0xCC):
                size = struct.unpack_from(">HH", data, position + 3)
            position += length
    raise ValueError("a JPEG without its end marker: it is truncated")


def bmp_size(data: bytes) -> tuple[int, int]:
    """(height, width) of either kind of header."""
    old = struct.unpack_from("<I", data, 14) == (12,)
    width, height = struct.unpack_from("<HH" if old else "<ii", data, 18)
    return abs(height), width


def tiff_size(data: bytes) -> tuple[int, int]:
    """(height, width) of the first directory, in either byte order."""
    order = "<" if data.startswith(b"II") else ">"
    (directory,) = struct.unpack_from(order + "I", data, 4)
    (count,) = struct.unpack_from(order + "H", data, directory)
    tags: dict[int, int] = {}
    for entry in range(directory + 2, directory + 2 + 12 * count, 12):
        tag, kind = struct.unpack_from(order + "HH", data, entry)
        tags.setdefault(tag, *struct.unpack_from(order + ("H" if kind == 3 else "I"), data, entry + 8))
    if not {256, 257} <= tags.keys():
        raise ValueError("a TIFF that does not state its size")
    if tags.get(277, 1) not in (1, 3):
        raise ValueError(f"a TIFF of {tags[277]} samples a pixel; only gray and RGB without alpha are read")
    return tags[257], tags[256]


def webp_size(data: bytes) -> tuple[int, int]:
    """(height, width) of the lossy, lossless or extended form."""
    if data[8:12] != b"WEBP":
        raise ValueError("a RIFF file that is not WebP")
    if len(data) < 8 + struct.unpack_from("<I", data, 4)[0]:
        raise ValueError("a truncated WebP")
    if data[12:16] == b"VP8X":
        return int.from_bytes(data[27:30], "little") + 1, int.from_bytes(data[24:27], "little") + 1
    if data[12:16] == b"VP8L":
        (bits,) = struct.unpack_from("<I", data, 21)
        return (bits >> 14 & 0x3FFF) + 1, (bits & 0x3FFF) + 1
    width, height = struct.unpack_from("<HH", data, 26)
    return height & 0x3FFF, width & 0x3FFF


FORMATS: tuple[tuple[bytes, Callable[[bytes], tuple[int, int]]], ...] = (
    (b"\x89PNG\r\n\x1a\n", png_size),
    (b"\xff\xd8\xff", jpeg_size),
    (b"BM", bmp_size),
    (b"II*\x00", tiff_size),
    (b"MM\x00*", tiff_size),
    (b"RIFF", webp_size),
)
