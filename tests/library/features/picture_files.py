"""Picture files, built byte by byte or by Pillow, and what is compared with what is read of them."""

import io
import struct
import zlib
from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image

from convexperc.errors import ImageError
from convexperc.features.pictures import read_image

HEIGHT, WIDTH = 24, 33
DRAW = np.random.default_rng(5)
GRAY = DRAW.integers(0, 256, (HEIGHT, WIDTH), np.uint8)
RGB = DRAW.integers(0, 256, (HEIGHT, WIDTH, 3), np.uint8)
RGBA = DRAW.integers(0, 256, (HEIGHT, WIDTH, 4), np.uint8)
DEEP = DRAW.integers(0, 2**16, (HEIGHT, WIDTH), np.uint16)
DEEP_RGB = DRAW.integers(0, 2**16, (HEIGHT, WIDTH, 3), np.uint16)
DEEP_RGBA = DRAW.integers(0, 2**16, (HEIGHT, WIDTH, 4), np.uint16)
ROWS, COLUMNS = np.mgrid[:HEIGHT, :WIDTH]
SMOOTH = np.stack([ROWS * 10, COLUMNS * 7, ROWS * 5 + COLUMNS * 3], axis=2).astype(np.uint8)


def read(folder, data):
    path = Path(folder) / "picture.bin"
    path.write_bytes(data)
    return read_image(path)


def refusal(folder, data):
    with pytest.raises(ImageError) as caught:
        read(folder, data)
    return str(caught.value)


def outcome(folder, data):
    """The pixels, or None for a refusal."""
    try:
        return read(folder, data)
    except ImageError:
        return None


def check(folder, data, expected, what):
    found = read(folder, data)
    if expected.ndim == 2:
        expected = np.repeat(expected[..., np.newaxis], 3, axis=2)
    assert np.array_equal(found, expected), (what, found[:2].tolist(), expected[:2].tolist())


def packed(levels, bits):
    """Rows of 1, 2, 4 or 8 bits a pixel, each filled up to a byte."""
    spread = (levels[..., np.newaxis] >> np.arange(bits)[::-1]) & 1
    return np.packbits(spread.reshape(len(levels), -1).astype(np.uint8), axis=1)


def scaled(levels, bits):
    return (levels.astype(int) * 255 // (2**bits - 1)).astype(np.uint8)


def by_opencv(data, flags=cv2.IMREAD_COLOR_RGB):
    return cv2.imdecode(np.frombuffer(data, np.uint8), flags)


def by_pillow(pixels, kind, **options):
    stream = io.BytesIO()
    picture = pixels if isinstance(pixels, Image.Image) else Image.fromarray(pixels)
    picture.save(stream, kind, **options)
    return stream.getvalue()


def chunk(kind, body):
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))


def png(rows, bits, color, before=b"", after=b"", interlace=0):
    header = chunk(b"IHDR", struct.pack(">IIBBBBB", WIDTH, HEIGHT, bits, color, 0, 0, interlace))
    raw = rows if isinstance(rows, bytes) else b"".join(b"\0" + row.tobytes() for row in rows)
    body = before + chunk(b"IDAT", zlib.compress(raw)) + after + chunk(b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + header + body


MASKS = {3: (0xFF0000, 0xFF00, 0xFF), 4: (0xFF0000, 0xFF00, 0xFF, 0xFF000000)}


def bmp(rows, bits, header=40, method=0, masks=(), palette=b"", colors=0, height=HEIGHT):
    """`rows` from top to bottom."""
    body = b"".join(row.tobytes() + b"\0" * (-row.nbytes % 4) for row in rows[::-1])
    if header == 12:
        info = struct.pack("<IHHHH", 12, WIDTH, height, 1, bits)
    else:
        info = struct.pack("<IiiHHIIiiII", header, WIDTH, height, 1, bits, method, len(body), 0, 0, colors, 0)
        info = (info + struct.pack(f"<{len(masks)}I", *masks)).ljust(header, b"\0")
    start = 14 + len(info) + len(palette)
    return b"BM" + struct.pack("<IHHI", start + len(body), 0, 0, start) + info + palette + body


def tiff(strips, bits, photometric, order="<", method=1, dropped=(), **tags):
    """A TIFF of these strips; a tag by its number as `tNUMBER`."""
    body = b"".join(strips)
    starts = [8 + sum(map(len, strips[:number])) for number in range(len(strips))]
    sizes = [len(strip) for strip in strips]
    entries = {256: [WIDTH], 257: [HEIGHT], 258: bits, 259: [method], 262: [photometric]}
    entries |= {273: starts, 277: [len(bits)], 278: [HEIGHT], 279: sizes}
    entries |= {int(name[1:]): value for name, value in tags.items()}
    entries = {tag: value for tag, value in entries.items() if tag not in dropped}
    directory = b"\0" * (len(body) % 2)
    start = 8 + len(body) + len(directory)
    heap = start + 2 + 12 * len(entries) + 4
    directory += struct.pack(order + "H", len(entries))
    tail = b""
    for tag, values in sorted(entries.items()):
        kind = "I" if tag in (273, 279, 324, 325) else "H"
        packed_values = struct.pack(f"{order}{len(values)}{kind}", *values)
        directory += struct.pack(order + "HHI", tag, 4 if kind == "I" else 3, len(values))
        if len(packed_values) <= 4:
            directory += packed_values.ljust(4, b"\0")
        else:
            directory += struct.pack(order + "I", heap + len(tail))
            tail += packed_values
    mark = b"II*\0" if order == "<" else b"MM\0*"
    return mark + struct.pack(order + "I", start) + body + directory + b"\0\0\0\0" + tail
