"""PNG files: the chunks that state pixels, verified, and what Pillow would accept or misread.

Source: W3C, Portable Network Graphics (PNG) Specification (Third Edition).
"""

import struct
import zlib
from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
from PIL.PngImagePlugin import PngImageFile

from convexperc.features.decoding.inflating import inflated

SIGNATURE = b"\x89PNG\r\n\x1a\n"

_ONCE = (b"IHDR", b"PLTE", b"tRNS")
_CRITICAL = (b"IHDR", b"PLTE", b"IDAT", b"IEND")
_SAMPLES = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}
"""Samples for each pixel, by the colour type."""
_PASSES = (
    *((0, 0, 8, 8), (4, 0, 8, 8), (0, 4, 4, 8), (2, 0, 4, 4)),
    *((0, 2, 2, 4), (1, 0, 2, 2), (0, 1, 1, 2)),
)
"""Left, top, horizontal and vertical step in pixels of the passes of an interlaced picture (Adam7)."""


@dataclass(frozen=True)
class PngFile:
    """A PNG's chunks.

    Attributes
    ----------
    data : bytes
        The file, reduced to the chunks that affect pixels: Pillow refuses small faults in others.
    stream : bytes
        The Deflate stream of the pixels.
    depth : int
        Bits of a sample.
    color : int
        The colour type.
    colors : int
        Entries of the palette; 0 without.
    stated_bits : int
        The largest number of significant bits by sBIT; `depth` without.
    several : bool
        Whether other pictures follow, as in an animation.
    """

    data: bytes
    stream: bytes
    depth: int
    color: int
    colors: int
    stated_bits: int
    several: bool

    @classmethod
    def of(cls, data: bytes) -> "PngFile":
        """Read the chunks and verify the checksum of each; Pillow verifies only those before the pixels.

        Raises
        ------
        ValueError
            A wrong checksum, a chunk of an unknown critical kind, twice, or not in its place.
        struct.error
            The file ends before IEND.
        """
        kept, found, position, kind = [SIGNATURE], dict[bytes, bytes](), len(SIGNATURE), b""
        stream, significant = list[bytes](), b""
        while kind != b"IEND":
            length, kind = struct.unpack_from(">I4s", data, position)
            end = position + 8 + length
            if struct.unpack_from(">I", data, end) != (zlib.crc32(memoryview(data)[position + 4 : end]),):
                raise ValueError(f"a wrong checksum in the PNG's {kind!r} chunk")
            body = data[position + 8 : end]
            _check_place(kind, found)
            if kind[:1].isupper() or kind in (b"tRNS", b"eXIf"):
                kept.append(data[position : end + 4])
            if kind == b"IDAT":
                stream.append(body)
            if kind == b"sBIT" and not stream:
                significant = body
            found[kind] = body
            position = end + 4
        _, _, depth, color, method, filters, passes = struct.unpack(">IIBBBBB", found[b"IHDR"])
        if method or filters or passes > 1:
            raise ValueError(f"a PNG with compression {method}, filters {filters}, interlacing {passes}")
        colors = len(found.get(b"PLTE", b"")) // 3
        if b"tRNS" in found and len(found[b"tRNS"]) not in _transparencies(color, colors):
            raise ValueError(
                f"a PNG with {len(found[b'tRNS'])} bytes of transparency for colour type {color}"
            )
        bits = max(significant, default=depth)
        return cls(b"".join(kept), b"".join(stream), depth, color, colors, bits, b"fdAT" in found)

    @property
    def by_opencv(self) -> bool:
        """Whether Pillow would reduce the samples to 8 bits, and compare a transparent color with those."""
        return self.depth == 16 and self.color != 0


def _transparencies(color: int, colors: int) -> Collection[int]:
    """Return the possible bytes of tRNS: a level, a color, or an opacity for each of the first colors."""
    return {0: (2,), 2: (6,), 3: range(1, colors + 1)}.get(color, ())


def _check_place(kind: bytes, found: dict[bytes, bytes]) -> None:
    if not kind.isalpha():
        raise ValueError(f"a PNG with the chunk {kind!r}, whose name is not of letters")
    if kind[:1].isupper() and kind not in _CRITICAL:
        raise ValueError(f"a PNG with the chunk {kind!r}, which affects its pixels and is not known")
    if not found and kind != b"IHDR":
        raise ValueError("a PNG that does not begin with IHDR")
    early = kind == b"tRNS" and found[b"IHDR"][9:10] == b"\x03" and b"PLTE" not in found
    late = kind in (b"PLTE", b"tRNS") and b"IDAT" in found
    if early or late or (kind in _ONCE and kind in found):
        raise ValueError(f"a PNG with a chunk {kind!r} too many, or not in its place")


def check(image: PngImageFile, file: PngFile) -> None:
    """Refuse a stream that ends before the last row, and palette entries that there are not: both become 0.

    Raises
    ------
    ValueError
        As said.
    """
    image.load()
    if image.mode == "P" and int(np.asarray(image).max()) >= file.colors:
        raise ValueError(f"a PNG whose pixels name more colors than the {file.colors} of its palette")
    interlaced = bool(image.info.get("interlace"))
    last = image.height - 1 - image.height % 2 * interlaced
    if any(image.crop((0, last, image.width, last + 1)).tobytes()):
        return
    bits, needed = file.depth * _SAMPLES[file.color], 0
    for left, top, across, down in _PASSES if interlaced else ((0, 0, 1, 1),):
        width, height = -((left - image.width) // across), -((top - image.height) // down)
        needed += height * (1 + -(-width * bits // 8))
    if inflated(file.stream, needed)[0] < needed:
        raise ValueError("a truncated PNG")
