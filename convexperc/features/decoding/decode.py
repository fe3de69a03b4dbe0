"""Decoding of picture files: the stored pixels exactly, or an error.

Pillow decodes, but JPEG: libjpeg-turbo's warnings of damage, which Pillow hides, are errors in simplejpeg.
Damaged files that Pillow accepts are refused here, and OpenCV decodes the formats that Pillow decodes
incorrectly.
"""

import io
import struct
import warnings
from collections.abc import Callable
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import ExifTags, Image, ImageFile
from PIL.BmpImagePlugin import BmpImageFile
from PIL.PngImagePlugin import PngImageFile
from PIL.TiffImagePlugin import TiffImageFile
from PIL.WebPImagePlugin import WebPImageFile

from convexperc.errors import ImageError, PictureWarning
from convexperc.features.decoding import bmp, directory, jpeg, png, tiff
from convexperc.features.decoding.jpeg import JpegFile
from convexperc.features.decoding.png import PngFile
from convexperc.features.decoding.sizes import SIZES, check_size

_BYTE_MAX, _DEEP_BITS, _DEEP_MAX = 255, 16, 2**16 - 1


def decode(data: bytes, name: str, *, alpha: bool = True) -> NDArray[Any]:
    """Decode a PNG, JPEG, BMP, TIFF or WebP file, whose format is recognised by its content.

    Parameters
    ----------
    data : bytes
        The whole file.
    name : str
        How an error names the picture.
    alpha : bool
        Whether an alpha says what is to be seen; otherwise it is left out, whatever it is.

    Returns
    -------
    ndarray of uint8 or uint16, (h, w), (h, w, 3) or (h, w, 4)
        Gray, RGB, or RGB and alpha, in the orientation that the file states.

    Raises
    ------
    ImageError
        See `convexperc.features.read_image`.
    """
    form = next((form for signature, form in _FORMS if data.startswith(signature)), None)
    if form is None:
        raise ImageError(
            name, value=data[:8], must="must be PNG, JPEG, BMP, TIFF or WebP", remedy="Convert it."
        )
    if ImageFile.LOAD_TRUNCATED_IMAGES:  # set by other code: Pillow then fills missing pixels
        raise ImageError("PIL.ImageFile.LOAD_TRUNCATED_IMAGES", value=True, must="must be False")
    try:
        pixels = form(data, name)
        if pixels.ndim == 3 and pixels.shape[2] == 4:
            pixels = _seen(pixels) if alpha else pixels[..., :3]
    except (ImageError, MemoryError):
        raise
    except (Image.DecompressionBombError, Image.DecompressionBombWarning) as problem:
        raise ImageError(name, value=str(problem), must=SIZES, remedy="Use another size.") from None
    except Exception as problem:  # damaged files make Pillow raise many types: SyntaxError, KeyError, ...
        value = "a truncated file" if isinstance(problem, struct.error) else str(problem)
        must = "must be complete, undamaged, and gray, RGB or palette of unsigned integers up to 16 bits"
        remedy = "Copy it again, or save it in another form."
        raise ImageError(name, value=value or type(problem).__name__, must=must, remedy=remedy) from None
    return pixels


def _seen(pixels: NDArray[Any]) -> NDArray[Any]:
    if not pixels[..., 3].any():
        raise ValueError("a picture that is transparent everywhere: it shows nothing")
    return pixels


def _opened(
    reader: type[ImageFile.ImageFile], data: bytes, name: str, several: bool = False
) -> ImageFile.ImageFile:
    """Read the header, check the size, and say that no picture but the first one is read."""
    image = reader(io.BytesIO(data))  # not by `Image.open`: other code may set a limit of the size for it
    check_size(image.height, image.width, name)
    if several or getattr(image, "is_animated", False):
        warnings.warn(f"{name} holds several pictures; the first is read", PictureWarning, stacklevel=2)
    return image


def _png(data: bytes, name: str) -> NDArray[Any]:
    file = PngFile.of(data)
    with _opened(PngImageFile, file.data, name, file.several) as image:
        assert isinstance(image, PngImageFile)
        png.check(image, file)
        pixels = _samples_by_opencv(file.data) if file.by_opencv else _samples(image, file.depth)
        return _turned(_filled(pixels, file.stated_bits), _orientation(image.info.get("exif", b"")))


def _jpeg(data: bytes, name: str) -> NDArray[Any]:
    file = JpegFile.of(data)
    check_size(file.height, file.width, name)
    return _turned(jpeg.samples(file), _orientation(file.exif))


def _webp(data: bytes, name: str) -> NDArray[Any]:
    with _opened(WebPImageFile, data, name) as image:
        return _turned(_samples(image), _orientation(image.info.get("exif", b"")))


def _bmp(data: bytes, name: str) -> NDArray[Any]:
    plain, palette = bmp.without_gray(data)
    with _opened(BmpImageFile, plain, name) as image:
        assert isinstance(image, BmpImageFile)
        bmp.check(image, data)
        return _samples(image) if palette is None else bmp.samples(image, palette)


def _tiff(data: bytes, name: str) -> NDArray[Any]:
    with _opened(TiffImageFile, data, name) as image:
        assert isinstance(image, TiffImageFile)
        image.info.pop("xmp", None)  # Pillow would take an orientation from it
        directory.check(data)
        layout = tiff.Layout.of(image)
        tiff.check(image, layout, data)
        bits, palette = tiff.stated_bits(image, layout), tiff.named_colors(image, layout)
        if layout.by_opencv:
            return _filled(_samples_by_opencv(data), bits)
        if palette is None:
            return _filled(_samples(image), bits)
        image.load()
        named = np.asarray(image)
        if named.ndim == 2:
            return np.asarray(palette[named])
        return np.dstack([palette[named[..., 0]], named[..., 1]])


_FORMS: tuple[tuple[bytes, Callable[[bytes, str], NDArray[Any]]], ...] = (
    (png.SIGNATURE, _png),
    (jpeg.SIGNATURE, _jpeg),
    (b"BM", _bmp),
    (b"II*\x00", _tiff),
    (b"MM\x00*", _tiff),
    (b"RIFF", _webp),
)
"""What decodes a file, by its first bytes."""


def _filled(pixels: NDArray[Any], bits: int) -> NDArray[Any]:
    """Return 16-bit samples of which `bits` are stated to be used, scaled to all 16.

    The bits used are the low ones where no sample is larger than they allow; but not if all others are 0, as
    in a dark picture whose samples are scaled already.
    """
    spare = _DEEP_BITS - bits
    if pixels.dtype != np.uint16 or not 0 < bits < _DEEP_BITS or int(pixels.max()) >> bits:
        return pixels
    if not (pixels & ((1 << spare) - 1)).any():
        return pixels
    scaled = pixels.astype(np.uint32) * np.uint32(_DEEP_MAX) // np.uint32((1 << bits) - 1)
    return scaled.astype(np.uint16)


def _samples_by_opencv(data: bytes) -> NDArray[Any]:
    """Decode with OpenCV, for the formats whose values Pillow changes."""
    decoded: NDArray[Any] | None = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    if decoded is None:
        raise ValueError("pixels that do not decode")
    if decoded.ndim == 2:
        return decoded
    return decoded[..., [2, 1, 0, 3][: decoded.shape[2]]]


def _samples(image: ImageFile.ImageFile, depth: int = 8) -> NDArray[Any]:
    """Decode with Pillow; the depth is that of a PNG's samples in bits."""
    image.load()
    level = image.info.get("transparency")
    if image.mode.startswith("I;16"):
        deep = np.array(image).astype(np.uint16)  # in the order of the machine
        if level is not None:
            deep[deep == level] = 0
        return deep
    if image.mode in ("I", "F"):
        raise ValueError("numbers of 32 bits")
    if image.mode == "L" and level is not None:  # Pillow scales the pixels to 8 bits, but not this level
        top = 2**depth - 1
        image.info["transparency"] = (level & top) * _BYTE_MAX // top
    gray = "L" if image.mode in ("1", "L") else "RGB"
    return np.asarray(image.convert("RGBA" if image.has_transparency_data else gray))


def _orientation(stored: bytes) -> int:
    """Return the orientation by EXIF, 1 to 8; 1, unchanged, if it is not readable."""
    exif, tag = Image.Exif(), ExifTags.Base.Orientation
    try:
        exif.load(stored)
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
