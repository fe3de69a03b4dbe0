"""Decoding of picture files: the stored pixels exactly, or an error.

Pillow decodes. Damaged files that it accepts are refused here, and OpenCV decodes the formats that Pillow
decodes incorrectly.
"""

import io
import re
import struct
import zlib
from collections.abc import Iterable
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import ExifTags, Image, ImageFile, TiffImagePlugin
from PIL.BmpImagePlugin import BmpImageFile
from PIL.JpegImagePlugin import JpegImageFile
from PIL.PngImagePlugin import PngImageFile
from PIL.TiffImagePlugin import TiffImageFile
from PIL.WebPImagePlugin import WebPImageFile

from convexperc.errors import ImageError

MIN_SIDE = 8
"""Least side in pixels, as of a working size."""
MAX_PIXELS = 2**26
"""Largest number of pixels: 192 MiB as RGB."""
MAX_BYTES = 8 * MAX_PIXELS
"""Largest file in bytes: that many pixels as uncompressed 16-bit RGBA."""
_SIZES = f"must have sides of at least {MIN_SIDE} pixels and at most {MAX_PIXELS} pixels in all"


class _Jpeg(JpegImageFile):
    """Pillow's JPEG reader without its search for a resolution, which would warn of damaged EXIF."""

    def _read_dpi_from_exif(self) -> None:
        """Skip the search."""


# Pillow's readers themselves: `Image.open` first checks the size against a limit that other code may set.
_READERS: tuple[tuple[bytes, type[ImageFile.ImageFile]], ...] = (
    (b"\x89PNG\r\n\x1a\n", PngImageFile),
    (b"\xff\xd8\xff", _Jpeg),
    (b"BM", BmpImageFile),
    (b"II*\x00", TiffImageFile),
    (b"MM\x00*", TiffImageFile),
    (b"RIFF", WebPImageFile),
)

# Markers of JPEG segments by ITU-T T.81, table B.1: any of them, those without a length, and the end.
_JPEG_MARKER = re.compile(rb"\xff([^\x00\xff\xd0-\xd7])")
_JPEG_BARE, _JPEG_END = (0x01, 0xD8), 0xD9  # TEM and SOI; EOI

# Byte offsets of a PNG's first chunk, bit depth and colour type, and of a BMP's colour masks.
_PNG_CHUNKS, _PNG_DEPTH, _PNG_COLOR, _BMP_MASKS = 8, 24, 25, slice(54, 66)

# Samples for each pixel of a PNG, by its colour type.
_PNG_SAMPLES = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}
# Left, top, horizontal and vertical step in pixels of the passes of an interlaced PNG (Adam7).
_PNG_PASSES = (
    *((0, 0, 8, 8), (4, 0, 8, 8), (0, 4, 4, 8), (2, 0, 4, 4)),
    *((0, 2, 2, 4), (1, 0, 2, 2), (0, 1, 1, 2)),
)
_BYTE_MAX, _DEEP_BITS = 255, 16  # largest value of 8 bits; bits of a deep sample

# Values of TIFF tags by the specification "TIFF 6.0": photometric interpretation.
_WHITE_IS_ZERO, _BLACK_IS_ZERO, _RGB, _PALETTE, _YCBCR, _LAB = 0, 1, 2, 3, 6, 8
# The samples of each photometric interpretation.
_TIFF_COLORS = {_WHITE_IS_ZERO: 1, _BLACK_IS_ZERO: 1, _RGB: 3, _PALETTE: 1, _YCBCR: 3, _LAB: 3}
# Compression (Deflate has two numbers, the later one by Adobe), planar configuration, extra samples, format.
_RAW, _DEFLATE, _CHUNKY, _PLANAR, _UNASSOCIATED, _UNSIGNED = 1, (32946, 8), 1, 2, 2, 1

_PACKED_BITS = 12  # the only depth between 8 and 16 bits that Pillow opens

# Compressed bytes inflated at once: they give at most 64.5 MiB, because Deflate's ratio is at most 1032.
_PIECE_BYTES = 2**16


def decode(data: bytes, name: str) -> NDArray[Any]:
    """Decode a PNG, JPEG, BMP, TIFF or WebP file, whose format is recognised by its content.

    Parameters
    ----------
    data : bytes
        The whole file.
    name : str
        How an error names the picture.

    Returns
    -------
    ndarray of uint8 or uint16, (h, w), (h, w, 3) or (h, w, 4)
        Gray, RGB, or RGB and alpha, in the orientation that the file states.

    Raises
    ------
    ImageError
        See `convexperc.features.read_image`.
    """
    reader = next((reader for signature, reader in _READERS if data.startswith(signature)), None)
    if reader is None:
        raise ImageError(
            name, value=data[:8], must="must be PNG, JPEG, BMP, TIFF or WebP", remedy="Convert it."
        )
    if ImageFile.LOAD_TRUNCATED_IMAGES:  # set by other code: Pillow then fills missing pixels
        raise ImageError("PIL.ImageFile.LOAD_TRUNCATED_IMAGES", value=True, must="must be False")
    try:
        pixels = _pixels(reader, data, name)
    except (ImageError, MemoryError):
        raise
    except (Image.DecompressionBombError, Image.DecompressionBombWarning) as problem:
        raise ImageError(name, value=str(problem), must=_SIZES, remedy="Use another size.") from None
    except Exception as problem:  # damaged files make Pillow raise many types: SyntaxError, KeyError, ...
        value = "a truncated file" if isinstance(problem, struct.error) else str(problem)
        must = "must be complete, undamaged, and gray, RGB or palette of unsigned integers up to 16 bits"
        remedy = "Copy it again, or save it in another form."
        raise ImageError(name, value=value or type(problem).__name__, must=must, remedy=remedy) from None
    return pixels


def _pixels(reader: type[ImageFile.ImageFile], data: bytes, name: str) -> NDArray[Any]:
    stream = b""
    if reader is PngImageFile:
        data, stream = _pixel_chunks(data)
    with reader(io.BytesIO(data)) as image:
        check_size(image.height, image.width, name)
        by_opencv = False
        if isinstance(image, PngImageFile):
            # Pillow would compare the transparent color with pixels reduced to 8 bits.
            by_opencv = (
                image.mode == "RGB" and "transparency" in image.info and data[_PNG_DEPTH] == _DEEP_BITS
            )
            if not by_opencv:
                _check_png(image, data, stream)
        elif isinstance(image, JpegImageFile):
            _check_jpeg(data)
        elif isinstance(image, BmpImageFile):
            _check_bmp(image, data)
            # Pillow treats a palette of grays as gray pixels of 1 or 8 bits, whatever their depth.
            by_opencv = image.mode in ("1", "L")
        elif isinstance(image, TiffImageFile):
            image.info.pop("xmp", None)  # Pillow would take an orientation from it
            by_opencv = _check_tiff(image, data)
        pixels = _samples_by_opencv(data) if by_opencv else _samples(image, data)
        return _turned(pixels, 1 if isinstance(image, TiffImageFile) else _orientation(image))


def _pixel_chunks(data: bytes) -> tuple[bytes, bytes]:
    """Return the PNG reduced to the chunks that affect pixels, and its Deflate stream.

    The checksum of every chunk is verified; Pillow verifies only those before the pixel data. The other
    chunks are dropped because Pillow refuses pictures for small faults in them.
    """
    position, kind, kept, stream = _PNG_CHUNKS, b"", [data[:_PNG_CHUNKS]], []
    while kind != b"IEND":
        length, kind = struct.unpack_from(">I4s", data, position)
        end = position + 8 + length
        if struct.unpack_from(">I", data, end) != (zlib.crc32(memoryview(data)[position + 4 : end]),):
            raise ValueError(f"a wrong checksum in the PNG's {kind!r} chunk")
        if kind[:1].isupper() or kind in (b"tRNS", b"eXIf"):
            kept.append(data[position : end + 4])
        if kind == b"IDAT":
            stream.append(data[position + 8 : end])
        position = end + 4
    return b"".join(kept), b"".join(stream)


def _check_png(image: PngImageFile, data: bytes, stream: bytes) -> None:
    """Refuse a stream that ends before the last row, for which Pillow would return zeros."""
    image.load()
    interlaced = bool(image.info.get("interlace"))
    last = image.height - 1 - image.height % 2 * interlaced
    if any(image.crop((0, last, image.width, last + 1)).tobytes()):
        return
    bits = data[_PNG_DEPTH] * _PNG_SAMPLES[data[_PNG_COLOR]]
    needed = 0
    for left, top, across, down in _PNG_PASSES if interlaced else ((0, 0, 1, 1),):
        width, height = -((left - image.width) // across), -((top - image.height) // down)
        needed += height * (1 + -(-width * bits // 8))
    if _inflated(stream, needed)[0] < needed:
        raise ValueError("a truncated PNG")


def _check_jpeg(data: bytes) -> None:
    """Require an end marker after the segments; one inside a segment (a thumbnail's) does not count."""
    position = 2
    while found := _JPEG_MARKER.search(data, position):
        marker, position = found[1][0], found.end()
        if marker == _JPEG_END:
            return
        if marker not in _JPEG_BARE:
            position += int.from_bytes(data[position : position + 2], "big")
    raise ValueError("a JPEG without its end marker: it is truncated")


def _check_bmp(image: BmpImageFile, data: bytes) -> None:
    """Refuse a file cut in the last row's padding, and a fourth byte that is not declared as alpha."""
    codec, _, offset, layout = image.tile[0]
    if codec == "raw" and isinstance(layout, tuple) and len(data) < offset + layout[1] * image.height:
        raise ValueError("a truncated BMP")
    if image.mode == "RGBA" and not any(data[_BMP_MASKS]):
        raise ValueError("a BMP with bit fields and without masks")


def _check_tiff(image: TiffImageFile, data: bytes) -> bool:
    """Refuse what neither library decodes correctly; true if OpenCV must decode in place of Pillow."""
    tags, tag = image.tag_v2, TiffImagePlugin
    kind, extra = tags.get(tag.PHOTOMETRIC_INTERPRETATION, -1), tags.get(tag.EXTRASAMPLES, ())
    colors, planar = _TIFF_COLORS.get(kind, 0), tags.get(tag.PLANAR_CONFIGURATION, _CHUNKY)
    samples, bits = tags.get(tag.SAMPLESPERPIXEL, colors), max(tags.get(tag.BITSPERSAMPLE, (1,)))
    meant = colors and extra in ((), (_UNASSOCIATED,)) and samples == colors + len(extra)
    if not meant or planar not in (_CHUNKY, _PLANAR):
        said = f"photometric {kind}, extra samples {extra}, planar {planar}"
        raise ValueError(f"a TIFF of {samples} samples a pixel, {said}")
    if {*tags.get(tag.SAMPLEFORMAT, ()), _UNSIGNED} != {_UNSIGNED}:
        raise ValueError("a TIFF of signed or floating-point numbers")
    raw = tags.get(tag.COMPRESSION, _RAW) == _RAW
    apart = raw and planar == _PLANAR
    if bits > 8 and (kind == _WHITE_IS_ZERO or (apart and samples > 1)):
        raise ValueError(f"a TIFF of {bits} bits with 0 for white or with its colors apart")
    if tags.get(tag.COMPRESSION) in _DEFLATE:
        _check_deflate(data, tags.get(tag.STRIPOFFSETS) or tags[tag.TILEOFFSETS])
    if kind == _LAB or bits == _PACKED_BITS or (raw and kind == _YCBCR) or (apart and samples == 1):
        return True
    if raw:
        _check_strips(image, samples if apart else 1, samples * bits)
    # Pillow assumes 16 bits for every palette.
    return bool(kind == _PALETTE and max(tags[tag.COLORMAP]) <= _BYTE_MAX)


def _check_strips(image: TiffImageFile, planes: int, bits: int) -> None:
    """Refuse strips that do not fill the picture: Pillow would leave the rest black."""
    tags, tag = image.tag_v2, TiffImagePlugin
    width, height = tags[tag.IMAGEWIDTH], tags[tag.IMAGELENGTH]
    boxes = [part.extents for part in image.tile if part.extents]
    area = sum((right - left) * (bottom - top) for left, top, right, bottom in boxes)
    counts = tags.get(tag.STRIPBYTECOUNTS) or tags.get(tag.TILEBYTECOUNTS)
    if area < planes * width * height or (counts and sum(counts) < -(-width * bits // 8) * height):
        raise ValueError("a TIFF whose strips do not fill the picture")


def _check_deflate(data: bytes, offsets: Iterable[int]) -> None:
    """Inflate every strip up to its checksum, which the TIFF decoder does not verify."""
    left = MAX_BYTES
    for offset in offsets:
        size, ended = _inflated(memoryview(data)[offset:], left)
        left -= size
        if not ended or left < 0:
            raise ValueError("a TIFF with a strip that does not end where it should")


def _inflated(stream: bytes | memoryview, enough: int) -> tuple[int, bool]:
    """Return the inflated size of a Deflate stream, or one above `enough`, and whether it ended."""
    inflate, size = zlib.decompressobj(), 0
    for start in range(0, len(stream), _PIECE_BYTES):
        if inflate.eof or size > enough:
            break
        size += len(inflate.decompress(stream[start : start + _PIECE_BYTES]))
    return size, inflate.eof


def _samples_by_opencv(data: bytes) -> NDArray[Any]:
    """Decode with OpenCV, for the formats whose values Pillow changes."""
    decoded: NDArray[Any] | None = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    if decoded is None:
        raise ValueError("pixels that do not decode")
    if decoded.ndim == 2:
        return decoded
    return decoded[..., [2, 1, 0, 3][: decoded.shape[2]]]


def _samples(image: ImageFile.ImageFile, data: bytes) -> NDArray[Any]:
    image.load()
    level = image.info.get("transparency")
    if image.mode.startswith("I;16"):
        deep = np.array(image)
        if level is not None:
            deep[deep == level] = 0
        return deep
    if image.mode in ("I", "F"):
        raise ValueError("numbers of 32 bits")
    if image.mode == "L" and level is not None:  # Pillow scales the pixels to 8 bits, but not this level
        top = 2 ** data[_PNG_DEPTH] - 1
        image.info["transparency"] = (level & top) * _BYTE_MAX // top
    gray = "L" if image.mode in ("1", "L") else "RGB"
    return np.asarray(image.convert("RGBA" if image.has_transparency_data else gray))


def _orientation(image: ImageFile.ImageFile) -> int:
    """Return the orientation by EXIF, 1 to 8; 1, unchanged, if it is not readable."""
    exif, tag = Image.Exif(), ExifTags.Base.Orientation
    try:
        exif.load(image.info.get("exif", b""))
    except Warning:  # the caller's filter made it an error; it must not affect the orientation
        if tag not in exif:
            raise
    except Exception:  # damaged EXIF raises many types, and does not affect the pixels
        return 1
    stated = exif.get(tag)
    return stated if isinstance(stated, int) else 1


def _turned(pixels: NDArray[Any], orientation: int) -> NDArray[Any]:
    if orientation in (5, 6, 7, 8):
        pixels = pixels.swapaxes(0, 1)
    if orientation in (2, 3, 6, 7):
        pixels = pixels[:, ::-1]
    return pixels[::-1] if orientation in (3, 4, 7, 8) else pixels


def check_size(height: int, width: int, name: str) -> None:
    """Raise unless a size in pixels is within `MIN_SIDE` and `MAX_PIXELS`.

    Raises
    ------
    ImageError
        It is not.
    """
    if min(height, width) < MIN_SIDE or height * width > MAX_PIXELS:
        value = f"{height} x {width} (height x width)"
        raise ImageError(name, value=value, must=_SIZES, remedy="Use another size.")
