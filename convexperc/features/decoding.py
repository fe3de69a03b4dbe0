"""The pixels of a picture file as they are stored: decoded right, or refused.

Pillow reads; what it accepts though it is damaged is refused here, and the forms that it reads wrongly are
left to OpenCV.
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
"""Pixels a side."""
MAX_PIXELS = 2**26
"""Pixels in all: 192 MiB as RGB."""
MAX_BYTES = 8 * MAX_PIXELS
"""Bytes of a file: as many pixels, 16-bit RGBA without compression."""
_SIZES = f"must have sides of at least {MIN_SIDE} pixels and at most {MAX_PIXELS} pixels in all"


class _Jpeg(JpegImageFile):
    """Pillow's reader without its search for a resolution, which warns of damaged EXIF at the wrong time."""

    def _read_dpi_from_exif(self) -> None:
        """Look for nothing."""


# Pillow's readers themselves, because `Image.open` judges the size first, by a limit that others may set.
_READERS: tuple[tuple[bytes, type[ImageFile.ImageFile]], ...] = (
    (b"\x89PNG\r\n\x1a\n", PngImageFile),
    (b"\xff\xd8\xff", _Jpeg),
    (b"BM", BmpImageFile),
    (b"II*\x00", TiffImageFile),
    (b"MM\x00*", TiffImageFile),
    (b"RIFF", WebPImageFile),
)

# A marker of a JPEG's segments, and those without a length: none, start and end of a picture.
_JPEG_MARKER = re.compile(rb"\xff([^\x00\xff\xd0-\xd7])")
_JPEG_BARE, _JPEG_END = (0x01, 0xD8), 0xD9

# Where a PNG has its first chunk, its bits a sample and its kind of color; and a BMP the masks of its colors.
_PNG_CHUNKS, _PNG_DEPTH, _PNG_COLOR, _BMP_MASKS = 8, 24, 25, slice(54, 66)

# Samples a pixel of a PNG by its kind of color; left, top and steps of the passes of an interlaced one.
_PNG_SAMPLES = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}
_PNG_PASSES = (
    *((0, 0, 8, 8), (4, 0, 8, 8), (0, 4, 4, 8), (2, 0, 4, 4)),
    *((0, 2, 2, 4), (1, 0, 2, 2), (0, 1, 1, 2)),
)
_BYTE, _DEEP = 255, 16

# What TIFF tags hold, by the specification "TIFF 6.0"; Deflate has two numbers, the later one is Adobe's.
_WHITE_IS_ZERO, _BLACK_IS_ZERO, _RGB, _PALETTE, _YCBCR, _LAB = 0, 1, 2, 3, 6, 8
_TIFF_COLORS = {_WHITE_IS_ZERO: 1, _BLACK_IS_ZERO: 1, _RGB: 3, _PALETTE: 1, _YCBCR: 3, _LAB: 3}
_RAW, _DEFLATE, _TOGETHER, _APART, _UNASSOCIATED, _UNSIGNED = 1, (32946, 8), 1, 2, 2, 1

_PACKED = 12  # the one depth between 8 and 16 bits that Pillow opens

# Bytes inflated at once: they become at most 64 MiB, because Deflate's ratio is at most 1032.
_PIECE = 2**16


def decode(data: bytes, name: str) -> NDArray[Any]:
    """Decode a PNG, JPEG, BMP, TIFF or WebP file, its format told by its content.

    Parameters
    ----------
    data : bytes
        The whole file.
    name : str
        How an error names the picture.

    Returns
    -------
    ndarray of uint8 or uint16, (h, w), (h, w, 3) or (h, w, 4)
        Gray, RGB, or RGB and alpha, turned as the file states.

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
    if ImageFile.LOAD_TRUNCATED_IMAGES:  # another module's choice, by which Pillow fills what is missing
        raise ImageError("PIL.ImageFile.LOAD_TRUNCATED_IMAGES", value=True, must="must be False")
    try:
        pixels = _pixels(reader, data, name)
    except (ImageError, MemoryError):
        raise
    except (Image.DecompressionBombError, Image.DecompressionBombWarning) as problem:
        raise ImageError(name, value=str(problem), must=_SIZES, remedy="Use another size.") from None
    except Exception as problem:  # wrong bytes make Pillow raise a dozen types: SyntaxError, KeyError, ...
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
            # Pillow would compare one transparent color with pixels that have lost their low byte.
            by_opencv = image.mode == "RGB" and "transparency" in image.info and data[_PNG_DEPTH] == _DEEP
            if not by_opencv:
                _check_png(image, data, stream)
        elif isinstance(image, JpegImageFile):
            _check_jpeg(data)
        elif isinstance(image, BmpImageFile):
            _check_bmp(image, data)
            # Pillow takes a palette of grays for gray pixels of 1 or 8 bits, whatever their bits are.
            by_opencv = image.mode in ("1", "L")
        elif isinstance(image, TiffImageFile):
            image.info.pop("xmp", None)  # Pillow would turn by it, where the TIFF itself states nothing
            by_opencv = _check_tiff(image, data)
        pixels = _samples_by_opencv(data) if by_opencv else _samples(image, data)
        return _turned(pixels, 1 if isinstance(image, TiffImageFile) else _orientation(image))


def _pixel_chunks(data: bytes) -> tuple[bytes, bytes]:
    """The PNG of the chunks that matter for pixels, and its Deflate stream.

    Every chunk's checksum is verified, because Pillow does not do so from the first pixel on; and it refuses
    pictures for small faults in what does not matter here.
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
    """Refuse a stream that ends before the last row, which Pillow would leave at 0."""
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
    """Walk the segments to the end marker; an end marker inside one (a thumbnail's) does not count."""
    position = 2
    while found := _JPEG_MARKER.search(data, position):
        marker, position = found[1][0], found.end()
        if marker == _JPEG_END:
            return
        if marker not in _JPEG_BARE:
            position += int.from_bytes(data[position : position + 2], "big")
    raise ValueError("a JPEG without its end marker: it is truncated")


def _check_bmp(image: BmpImageFile, data: bytes) -> None:
    """Refuse a cut in the last row's padding, and a fourth byte that nothing says to be alpha."""
    codec, _, offset, layout = image.tile[0]
    if codec == "raw" and isinstance(layout, tuple) and len(data) < offset + layout[1] * image.height:
        raise ValueError("a truncated BMP")
    if image.mode == "RGBA" and not any(data[_BMP_MASKS]):
        raise ValueError("a BMP with bit fields and without masks")


def _check_tiff(image: TiffImageFile, data: bytes) -> bool:
    """Refuse what Pillow would read wrongly; True for what OpenCV reads rightly in its place."""
    tags, tag = image.tag_v2, TiffImagePlugin
    kind, extra = tags.get(tag.PHOTOMETRIC_INTERPRETATION, -1), tags.get(tag.EXTRASAMPLES, ())
    colors, planar = _TIFF_COLORS.get(kind, 0), tags.get(tag.PLANAR_CONFIGURATION, _TOGETHER)
    samples, bits = tags.get(tag.SAMPLESPERPIXEL, colors), max(tags.get(tag.BITSPERSAMPLE, (1,)))
    meant = colors and extra in ((), (_UNASSOCIATED,)) and samples == colors + len(extra)
    if not meant or planar not in (_TOGETHER, _APART):
        said = f"photometric {kind}, extra samples {extra}, planar {planar}"
        raise ValueError(f"a TIFF of {samples} samples a pixel, {said}")
    if {*tags.get(tag.SAMPLEFORMAT, ()), _UNSIGNED} != {_UNSIGNED}:
        raise ValueError("a TIFF of signed or floating-point numbers")
    raw = tags.get(tag.COMPRESSION, _RAW) == _RAW
    apart = raw and planar == _APART
    if bits > 8 and (kind == _WHITE_IS_ZERO or (apart and samples > 1)):
        raise ValueError(f"a TIFF of {bits} bits with 0 for white or with its colors apart")
    if tags.get(tag.COMPRESSION) in _DEFLATE:
        _check_deflate(data, tags.get(tag.STRIPOFFSETS) or tags[tag.TILEOFFSETS])
    if kind == _LAB or bits == _PACKED or (raw and kind == _YCBCR) or (apart and samples == 1):
        return True
    if raw:
        _check_strips(image, samples if apart else 1, samples * bits)
    # Pillow takes every palette for one of 16 bits.
    return bool(kind == _PALETTE and max(tags[tag.COLORMAP]) <= _BYTE)


def _check_strips(image: TiffImageFile, planes: int, bits: int) -> None:
    """Refuse strips that do not fill the picture, of which Pillow would leave a part black."""
    tags, tag = image.tag_v2, TiffImagePlugin
    width, height = tags[tag.IMAGEWIDTH], tags[tag.IMAGELENGTH]
    boxes = [part.extents for part in image.tile if part.extents]
    area = sum((right - left) * (bottom - top) for left, top, right, bottom in boxes)
    counts = tags.get(tag.STRIPBYTECOUNTS) or tags.get(tag.TILEBYTECOUNTS)
    if area < planes * width * height or (counts and sum(counts) < -(-width * bits // 8) * height):
        raise ValueError("a TIFF whose strips do not fill the picture")


def _check_deflate(data: bytes, offsets: Iterable[int]) -> None:
    """Inflate every strip up to its checksum, which the decoder of TIFF does not look at."""
    left = MAX_BYTES
    for offset in offsets:
        size, ended = _inflated(memoryview(data)[offset:], left)
        left -= size
        if not ended or left < 0:
            raise ValueError("a TIFF with a strip that does not end where it should")


def _inflated(stream: bytes | memoryview, enough: int) -> tuple[int, bool]:
    """Size of what a Deflate stream holds, at least as far as enough, and whether its end was reached."""
    inflate, size = zlib.decompressobj(), 0
    for start in range(0, len(stream), _PIECE):
        if inflate.eof or size > enough:
            break
        size += len(inflate.decompress(stream[start : start + _PIECE]))
    return size, inflate.eof


def _samples_by_opencv(data: bytes) -> NDArray[Any]:
    """Samples of the forms to which Pillow gives other values than the file states."""
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
    if image.mode == "L" and level is not None:  # Pillow brings the pixels to 8 bits, and not this level
        top = 2 ** data[_PNG_DEPTH] - 1
        image.info["transparency"] = (level & top) * _BYTE // top
    gray = "L" if image.mode in ("1", "L") else "RGB"
    return np.asarray(image.convert("RGBA" if image.has_transparency_data else gray))


def _orientation(image: ImageFile.ImageFile) -> int:
    """What EXIF states; 1, as it is, if that cannot be read."""
    exif, tag = Image.Exif(), ExifTags.Base.Orientation
    try:
        exif.load(image.info.get("exif", b""))
    except Warning:  # the caller's filter makes it an error; it must not decide how a picture is turned
        if tag not in exif:
            raise
    except Exception:  # wrong bytes raise as many types here as in pixels, which they do not harm
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
    """Refuse an absurd size."""
    if min(height, width) < MIN_SIDE or height * width > MAX_PIXELS:
        value = f"{height} x {width} (height x width)"
        raise ImageError(name, value=value, must=_SIZES, remedy="Use another size.")
