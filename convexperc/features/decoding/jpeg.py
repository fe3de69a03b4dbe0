"""JPEG files: their segments, verified, and their pixels by libjpeg-turbo, whose warnings are errors here.

Source: ITU-T T.81 (ISO/IEC 10918-1), annexes B (segments), F (sequential scans) and G (progressive scans).
"""

import re
import struct
from bisect import bisect_left
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import simplejpeg
from jaxtyping import UInt8
from numpy.typing import NDArray
from PIL import Image

SIGNATURE = b"\xff\xd8\xff"

_SOI, _EOI, _SOS, _DRI = b"\xff\xd8", 0xD9, 0xDA, 0xDD
_APP0, _APP1, _APP14 = 0xE0, 0xE1, 0xEE
_BARE = (0x01, *range(0xD0, 0xD9))
"""Markers without a segment: TEM, the restarts, and SOI."""
_FRAMES = tuple(code for code in range(0xC0, 0xD0) if code not in (0xC4, 0xC8, 0xCC))
"""Frames; the other three are Huffman tables, an extension, and conditions of arithmetic coding."""
_BY_HUFFMAN = (0xC0, 0xC1, 0xC2)
"""Baseline, extended sequential, and progressive. Arithmetic codes are not read: their end cannot be seen."""
_LEFT_OUT = (*range(0xE0, 0xF0), 0xFE)
"""Application data and comments."""
_PLAIN_JFIF, _ADOBE_BYTES = b"JFIF\0\1\1\0\0\1\0\1\0\0", 12

_MARKER = re.compile(rb"\xff([^\x00\xff])")
_SCAN_END = re.compile(rb"\xff[^\x00\xff\xd0-\xd7]")
_RESTART = re.compile(rb"(\xff[\xd0-\xd7])")

_COEFFICIENTS, _UNSENT = 64, 16
_MAX_SCANS = 100
"""Each takes the time of a pass over the picture; 3 to 14 are usual."""
_MAX_SIDE, _MAX_SEGMENTS, _MAX_INTERVALS, _MAX_PADDING = 65500, 10_000, 10_000, 1000
_COLORS = {1: "GRAY", 3: "RGB", 4: "CMYK"}
"""What is decoded, by the number of components."""
_LEFT_OVER = "extraneous bytes before marker"


class JpegFile(NamedTuple):
    """A JPEG's segments.

    Attributes
    ----------
    data : bytes
        The first picture, reduced to what affects its pixels: libjpeg also warns of small faults in the other
        segments, and of bytes between segments.
    frame : int
        Where the height stands in it.
    height, width : int
    factors : tuple of (int, int)
        The horizontal and vertical sampling of each component.
    restart : int
        The number of units (MCUs) between restarts; 0 without.
    scans : tuple of slice
        The coded bytes of each scan.
    adobe : bool
        Whether Adobe's marker states the colors.
    exif : bytes
    """

    data: bytes
    frame: int
    height: int
    width: int
    factors: tuple[tuple[int, int], ...]
    restart: int
    scans: tuple[slice, ...]
    adobe: bool
    exif: bytes

    @classmethod
    def of(cls, data: bytes) -> "JpegFile":
        """Read the segments up to the end marker.

        Raises
        ------
        ValueError
            No end marker, another process than Huffman's with 8 bits, or scans that are missing.
        struct.error
            The file ends inside a segment.
        """
        kept, length, scans = [_SOI], len(_SOI), list[slice]()
        frame, restart, adobe, exif, progress = 0, 0, False, b"", _Progress()
        for code, body, coded in _segments(data):
            segment = _segment(code, body)
            if code in _FRAMES:
                progress.begin(code, body)
                frame, header = length + 5, body
            elif code == _DRI and len(body) == 2:
                (restart,) = struct.unpack(">H", body)
            elif code == _APP14:
                adobe = adobe or bool(segment)
            elif code == _APP1 and body.startswith(b"Exif\0\0"):
                exif += body[6:] if exif else body
            elif code == _SOS:
                progress.go_on(body)
                scans.append(slice(length + len(segment), length + len(segment) + len(coded)))
            kept += (segment, coded)
            length += len(segment) + len(coded)
        progress.end()
        height, width = struct.unpack_from(">HH", header, 1)
        factors = tuple((each >> 4, each & 15) for each in header[7::3])
        return cls(b"".join(kept), frame, height, width, factors, restart, tuple(scans), adobe, exif)

    def decoded(self) -> UInt8[np.ndarray, "h w _"]:
        """Decode gray (1 channel), RGB (3), or the CMYK values as they are stored (4).

        Raises
        ------
        ValueError
            What libjpeg warns of: data that end before the last unit or go on after it, or that are no code.
        """
        try:
            return _decoded(self.data, len(self.factors))
        except ValueError as problem:
            if _LEFT_OVER not in str(problem) or len(self.scans) != 1:
                raise
            return _decoded(self._without_padding(), len(self.factors))

    def _without_padding(self) -> bytes:
        """Leave out bytes of ones or of zeros that cameras insert before restarts, and at the end.

        Webcams of Logitech insert a byte of ones where the code ends with a byte. The code may end so as
        well: therefore each interval is decoded alone.
        """
        wide, high = 8, 8
        if len(self.factors) > 1:
            wide, high = (8 * max(side) for side in zip(*self.factors, strict=True))
        units = -(-self.width // wide) * -(-self.height // high)
        parts = _RESTART.split(self.data[self.scans[0]])
        if len(parts) > 2 * _MAX_INTERVALS:
            return self.data
        for number in range(0, len(parts), 2):
            size = (self.height, self.width)
            if self.restart:
                size = (high, wide * min(self.restart, units - number // 2 * self.restart))
            if parts[number].endswith(b"\0") and 0 < size[1] <= _MAX_SIDE:
                parts[number] = self._needed(parts[number], size)
        start, end = self.scans[0].start, self.scans[0].stop
        return self.data[:start] + b"".join(parts) + self.data[end:]

    def _needed(self, part: bytes, size: tuple[int, int]) -> bytes:
        """Return the coded bytes of a picture of (height, width) without the padding behind them."""
        ends = [len(part)]
        while part.endswith(b"\0", 0, ends[-1]) and len(ends) <= _MAX_PADDING:
            ends.append(ends[-1] - (2 if part.endswith(b"\xff\0", 0, ends[-1]) else 1))
        first = self.data[: self.frame] + struct.pack(">HH", *size)
        first += self.data[self.frame + 4 : self.scans[0].start]

        def too_short(end: int) -> bool:
            try:
                _decoded(first + part[:end] + b"\xff\xd9", len(self.factors))
            except ValueError as problem:
                return _LEFT_OVER not in str(problem)
            return False

        return part[: ends[max(bisect_left(ends, True, key=too_short) - 1, 0)]]


def _decoded(data: bytes, components: int) -> UInt8[np.ndarray, "h w _"]:
    try:
        decoded: NDArray[np.uint8] = simplejpeg.decode_jpeg(data, _COLORS[components], strict=True)
    except KeyError:  # by simplejpeg, too, where the header states no colors that it knows
        raise ValueError(f"a JPEG of {components} components that are no known colors") from None
    return decoded


def samples(file: JpegFile) -> NDArray[np.uint8]:
    """Decode to gray (h, w) or RGB (h, w, 3).

    Raises
    ------
    ValueError
        CMYK without Adobe's marker, by which 255 is no ink; damaged data.
    """
    if len(file.factors) == 4 and not file.adobe:
        raise ValueError("a CMYK JPEG without Adobe's marker, so that 255 may be full ink, or none")
    decoded = file.decoded()
    if decoded.shape[2] == 4:
        inks = Image.frombytes("CMYK", (file.width, file.height), (255 - decoded).tobytes())
        return np.asarray(inks.convert("RGB"))
    return decoded[..., 0] if decoded.shape[2] == 1 else decoded


class _Progress:
    """How many low bits of each coefficient of each component the scans have left to be transmitted."""

    def __init__(self) -> None:
        self.left = dict[int, list[int]]()
        self.scans = 0

    def begin(self, code: int, body: bytes) -> None:
        """Read the header of the frame."""
        if self.left:
            raise ValueError("a JPEG of several frames")
        if code not in _BY_HUFFMAN or len(body) < 9 or body[0] != 8 or len(body) != 6 + 3 * body[5]:
            raise ValueError(f"a JPEG of a form that is not read (frame {code:#x} of {body[:1].hex()} bits)")
        self.left = {component: [_UNSENT] * _COEFFICIENTS for component in body[6::3]}

    def go_on(self, body: bytes) -> None:
        """Read the header of a scan."""
        self.scans += 1
        components = body[1:-3:2]
        if len(body) < 6 or len(body) != 4 + 2 * body[0] or not set(components) <= self.left.keys():
            raise ValueError("a JPEG with a scan of components that it does not have")
        if self.scans > _MAX_SCANS:
            raise ValueError(f"a JPEG of more than {_MAX_SCANS} scans")
        first, last, bits = body[-3:]
        for component in components:
            self.left[component][first : last + 1] = [bits & 15] * (last + 1 - first)

    def end(self) -> None:
        """Refuse a picture that later scans would have completed; libjpeg takes the rest to be 0."""
        if not self.left or any(map(any, self.left.values())):
            raise ValueError("a JPEG without its last scans: it is truncated")


def _segments(data: bytes) -> Iterator[tuple[int, bytes, bytes]]:
    """Yield the code, the body, and the coded bytes behind it, of each segment up to the end marker."""
    position, count = len(_SOI), 0
    while found := _MARKER.search(data, position):
        code, position, body, coded = found[1][0], found.end(), b"", b""
        count += 1
        if code in _BARE or count > _MAX_SEGMENTS:
            raise ValueError("a JPEG with a marker that is not in its place, or with too many")
        if code != _EOI:
            (length,) = struct.unpack_from(">H", data, position)
            body = data[position + 2 : position + length]
            if len(body) != length - 2:
                break
            position += length
        if code == _SOS:
            end = _SCAN_END.search(data, position)
            if end is None:
                break
            coded = data[position : end.start()]
            position = end.start()
        yield code, body, coded
        if code == _EOI:
            return
    raise ValueError("a JPEG without its end marker: it is truncated")


def _segment(code: int, body: bytes) -> bytes:
    """Return the segment for libjpeg, or nothing if it does not affect the pixels."""
    if code == _EOI:
        return b"\xff\xd9"
    if code == _APP0 and body.startswith(b"JFIF\0") and len(body) >= len(_PLAIN_JFIF):
        body = _PLAIN_JFIF  # a version that is not known, or a bad thumbnail, is no fault of the pixels
    elif code == _APP14 and body.startswith(b"Adobe") and len(body) >= _ADOBE_BYTES:
        body = body[:_ADOBE_BYTES]
    elif code in _LEFT_OUT:
        return b""
    return struct.pack(">BBH", 0xFF, code, len(body) + 2) + body
