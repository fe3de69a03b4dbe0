"""BMP files: palettes that Pillow takes for gray values, and what it would accept or misread.

Source: Microsoft, Bitmap Storage (BITMAPINFOHEADER, BITMAPV4HEADER, BITMAPV5HEADER); runs by its
"Bitmap Compression".
"""

import struct
from collections.abc import Iterator
from typing import Any

import numpy as np
from jaxtyping import UInt8
from PIL.BmpImagePlugin import BmpImageFile

_FILE_HEADER, _OLD_HEADER = 14, 12
"""Bytes of the header of the file, and of the oldest header of the picture (OS/2)."""
_HEADERS = (12, 40, 52, 56, 64, 108, 124)
"""Sizes of the headers that Pillow reads."""
_RUNS_8, _RUNS_4, _FIELDS = 1, 2, 3
"""Compression: runs of bytes, runs of half bytes, colors by masks."""
_MASKS, _ALPHA_MASK = slice(54, 66), slice(66, 70)
_END_OF_LINE, _END, _MOVE = 0, 1, 2
"""What follows a 0 in place of a run, if it is no number of pixels."""


def without_gray(data: bytes) -> tuple[bytes, UInt8[np.ndarray, "colors 3"] | None]:
    """Return the file with another palette, and its own one: Pillow treats a palette of grays as gray values.

    A file without a palette is returned as it is.
    """
    header, colors, bits, _ = _header(data)
    if header not in _HEADERS or bits > 8 or colors > 1 << 8:
        return data, None
    size, start = 3 if header == _OLD_HEADER else 4, _FILE_HEADER + header
    stored = np.frombuffer(data, np.uint8, colors * size, start).reshape(colors, size)
    return data[:start] + b"\1" * stored.size + data[start + stored.size :], stored[:, 2::-1]


def _header(data: bytes) -> tuple[int, int, int, int]:
    """Return the size of the header, the entries of the palette, the bits of a pixel, and the compression."""
    (header,) = struct.unpack_from("<I", data, _FILE_HEADER)
    if header == _OLD_HEADER:
        (bits,) = struct.unpack_from("<H", data, 24)
        return header, 1 << min(bits, 8), bits, 0
    bits, compression = struct.unpack_from("<HI", data, 28)
    (colors,) = struct.unpack_from("<I", data, 46)
    return header, colors or 1 << min(bits, 8), bits, compression


def check(image: BmpImageFile, data: bytes) -> None:
    """Refuse a file that is cut, or whose masks or runs Pillow would misread.

    Raises
    ------
    ValueError
        Cut in the last row's padding, a palette that reaches into the pixels, bit fields without masks, an
        alpha of 16-bit pixels, or runs that do not fill each row.
    """
    header, colors, bits, compression = _header(data)
    codec, _, offset, layout = image.tile[0]
    if codec == "raw" and isinstance(layout, tuple) and len(data) < offset + layout[1] * image.height:
        raise ValueError("a truncated BMP")
    if offset < _FILE_HEADER + header + 12 * (compression == _FIELDS and header == 40):
        raise ValueError("a BMP whose pixels lie in its header")
    size = 3 if header == _OLD_HEADER else 4
    if bits <= 8 and (colors > 1 << bits or _FILE_HEADER + header + colors * size > offset):
        raise ValueError(f"a BMP with a palette of {colors} colors, which do not fit")
    if image.mode == "RGBA" and not any(data[_MASKS]):
        raise ValueError("a BMP with bit fields and without masks")
    if compression == _FIELDS and bits == 16 and header >= 56 and any(data[_ALPHA_MASK]):
        raise ValueError("a BMP of 16 bits with an alpha")
    if compression in (_RUNS_8, _RUNS_4):
        _check_runs(data, offset, image.width, image.height, compression == _RUNS_4)


def _check_runs(data: bytes, offset: int, width: int, height: int, halves: bool) -> None:
    """Follow the runs: every row is as long as the picture is wide, and there are as many as it is high."""
    rows = [0]
    for pixels in _runs(data, offset, halves):
        if pixels:
            rows[-1] += pixels
        else:
            rows.append(0)
    if not rows[-1]:
        rows.pop()
    if offset % 2 or rows != [width] * height:  # from an odd place Pillow would align the runs to it
        raise ValueError("a BMP whose runs do not fill its rows")


def _runs(data: bytes, offset: int, halves: bool) -> Iterator[int]:
    """Yield the pixels of each run, and 0 at the end of a row; what ends the picture ends the runs."""
    place = offset
    while place + 2 <= len(data):
        count, value = data[place], data[place + 1]
        place += 2
        if count:
            yield count
        elif value == _END_OF_LINE:
            yield 0
        elif value == _END:
            return
        elif value == _MOVE:
            raise ValueError("a BMP whose runs leave pixels out")
        else:
            yield value
            stored = (value + 1) // 2 if halves else value
            place += stored + stored % 2
    raise ValueError("a truncated BMP")


def samples(image: BmpImageFile, palette: UInt8[np.ndarray, "colors 3"]) -> UInt8[np.ndarray, "h w 3"]:
    """Return the colors of a picture with a palette.

    Raises
    ------
    ValueError
        A pixel names a color that the palette does not have.
    """
    image.load()
    named: np.ndarray[Any, np.dtype[np.uint8]] = np.asarray(image)
    if int(named.max()) >= len(palette):
        raise ValueError(f"a BMP whose pixels name more colors than the {len(palette)} of its palette")
    return np.asarray(palette[named])
