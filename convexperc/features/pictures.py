"""Pictures as 8-bit RGB: reading, conversion by exact integer formulas, and resizing."""

import operator
import os
import warnings
from pathlib import Path
from typing import Any, Literal

import cv2
import numpy as np
from jaxtyping import UInt8
from numpy.typing import NDArray

from convexperc.errors import ImageError, PictureWarning, is_one_of
from convexperc.features.decoding.decode import decode
from convexperc.features.decoding.sizes import MAX_BYTES, check_size
from convexperc.features.folders import SUFFIXES, Folder
from convexperc.files import given_path

Picture = UInt8[np.ndarray, "h w 3"]
AnyPicture = UInt8[np.ndarray, "_ _ 3"]
"""A picture of any size, where several are annotated together."""
Pictures = list[AnyPicture]
"""Each has its own size."""
GrayPicture = UInt8[np.ndarray, "h w"]
Channels = Literal["RGB", "BGR"]
"""Order of the channels of an array, with alpha last where there is one."""

FLAT_RANGE = 4
"""Levels of 255 by which a picture may vary and still be of one color: noise of a sensor in the dark."""


def read_image(path: str | os.PathLike[str]) -> Picture:
    """Read a PNG, JPEG, BMP, TIFF or WebP file as 8-bit RGB.

    The format is recognised by the content, not by the name. The picture is turned by its EXIF orientation (a
    TIFF by its tag), unless EXIF is not readable. Of several pages or animation frames the first is read, and
    a `PictureWarning` says so. If the caller's filters turn warnings into errors, the file is refused.
    Gray, 16-bit and transparent pictures are converted as `as_rgb` does; color profiles are not applied.
    Where a file of 16 bits states that fewer are used (sBIT of a PNG, the largest value of a TIFF) and no
    value is larger than they allow, its values are scaled to 16 bits first.
    CMYK values of a JPEG are interpreted as Adobe's programs store them, with 255 for no ink.

    Parameters
    ----------
    path : path-like
        The file, with any name.

    Returns
    -------
    ndarray of uint8, (h, w, 3), read-only
        Intensities 0..255 of R, G, B.

    Raises
    ------
    ImageError
        Missing, a directory, empty, of another format, truncated (a JPEG without its end marker or some of
        its scans, a PNG without IEND), damaged (a wrong checksum in a PNG or in a TIFF with Deflate; a JPEG
        of whose code libjpeg warns), with a side under `MIN_SIDE` or more than `MAX_PIXELS` pixels (by its
        header, before any pixel is decoded), transparent everywhere, a form that decoders take differently,
        or pixels that are signed, floating-point or of more than 16 bits. JPEG, BMP, WebP and other TIFFs
        have no checksum: damage that leaves valid code inside a complete file cannot be detected.

    Notes
    -----
    PNG: every form of the specification. JPEG: 8 bits; gray, color, CMYK with Adobe's marker;
    Huffman's codes. BMP: 1, 4, 8
    (also in runs that fill the picture), 16, 24 and 32 bits, with the usual masks. TIFF: gray, RGB, palette
    and YCbCr, unassociated alpha, strips and tiles, uncompressed or by LZW, Deflate, PackBits, JPEG or
    Zstandard; not facsimile codes, whose damage would not be seen, CMYK or CIELab. WebP: all.
    """
    place = given_path(path, "picture", ImageError)
    name = f"picture {os.fspath(path)}"
    data = _read_bytes(place, name)
    return as_rgb(decode(data, name), name)


def as_rgb(array: object, name: str, channels: Channels = "RGB") -> Picture:
    """Convert an array of pixels to 8-bit RGB, exactly.

    * 16 bits to 8: ``v >> 8``, so that ``x * 256`` and ``x * 257`` both give back ``x``.
    * Gray: R = G = B = gray.
    * Alpha: composited on black, ``(c * a + 127) // 255``, after the reduction to 8 bits.

    Where the brightest value of 16 bits is below a quarter of white, a `PictureWarning` says so: the values
    may be of 10, 12 or 14 bits.

    Parameters
    ----------
    array : ndarray of uint8 or uint16
        (h, w) or (h, w, 1) gray, (h, w, 3) RGB, (h, w, 4) RGB and alpha. It may be read-only, a view of a
        buffer that is used again, or have any strides.
    name : str
        How an error names the picture.
    channels : {"RGB", "BGR"}
        "BGR" for OpenCV's own arrays, and for the encodings bgr8 and bgra8 of ROS: B, G, R, and then alpha.

    Returns
    -------
    ndarray of uint8, (h, w, 3), read-only, a copy

    Raises
    ------
    ImageError
        Not an array, masked pixels, another type of number (floats are refused, because their local binary
        patterns differ from those of 8-bit values), another shape, a size out of range (see `read_image`), or
        another order of channels.
    """
    if not is_one_of(channels, ("RGB", "BGR")):
        raise ImageError("channels", value=channels, must="must be 'RGB' or 'BGR'")
    if not isinstance(array, np.ndarray):
        raise ImageError(name, value=type(array).__name__, must="must be a NumPy array of uint8 or uint16")
    if isinstance(array, np.ma.MaskedArray) and np.ma.is_masked(array):
        hidden = f"a mask that hides {int(np.ma.getmaskarray(array).sum())} values"
        remedy = "Fill the masked pixels, for example with black."
        raise ImageError(name, value=hidden, must="must not be masked", remedy=remedy)
    pixels: NDArray[Any] = np.asarray(array)
    if pixels.dtype.kind != "u" or pixels.dtype.itemsize > 2:
        raise ImageError(
            name,
            value=pixels.dtype.name,
            must="must hold uint8 or uint16",
            remedy="Scale to 0..255, round and convert to uint8: texture features of floats would differ.",
        )
    if not (pixels.ndim == 2 or (pixels.ndim == 3 and pixels.shape[2] in (1, 3, 4))):
        raise ImageError(
            name, value=array.shape, must="must have the shape (h, w), (h, w, 1), (h, w, 3) or (h, w, 4)"
        )
    check_size(pixels.shape[0], pixels.shape[1], name)
    if pixels.dtype.itemsize == 2:
        _warn_of_dark(pixels, name)
    rgb = _as_rgb(pixels)
    if channels == "BGR":
        cv2.cvtColor(rgb, cv2.COLOR_BGR2RGB, dst=rgb)
    rgb.flags.writeable = False
    return rgb


def _warn_of_dark(deep: NDArray[Any], name: str) -> None:
    """Say that 16-bit values may be meant to be of fewer bits: a dark picture cannot be told from one."""
    bits = int(deep.max()).bit_length()
    if 0 < bits <= 14:
        said = f"no value of 16 bits is larger than {deep.max()}, so that it is read as a dark picture"
        remedy = f"if its values are of fewer bits, multiply them first, by {2 ** (16 - max(bits, 10))} or so"
        warnings.warn(f"{name}: {said}; {remedy}", PictureWarning, stacklevel=3)


def _as_rgb(pixels: NDArray[Any]) -> Picture:
    """Convert checked pixels; see `as_rgb`."""
    if pixels.ndim == 2:
        pixels = pixels[..., np.newaxis]
    if pixels.dtype.itemsize == 2:
        pixels = np.right_shift(pixels, 8, out=np.empty(pixels.shape, dtype=np.uint8), casting="unsafe")
    rgb = np.empty((*pixels.shape[:2], 3), dtype=np.uint8)
    if pixels.shape[2] == 4:
        _composite(pixels, rgb)
    else:
        rgb[...] = pixels
    return rgb


def check_picture(image: Any, name: str = "image", channels: int = 3) -> None:
    """Check that an array is what `as_rgb` returns, or with one channel what `to_gray` does.

    Raises
    ------
    ImageError
        It is no array of uint8, or has another shape or no pixel.
    """
    shaped = isinstance(image, np.ndarray) and image.dtype == np.uint8 and image.size
    if not shaped or not (
        image.ndim == 2 if channels == 1 else image.ndim == 3 and image.shape[2] == channels
    ):
        found = f"{image.dtype.name} {image.shape}" if isinstance(image, np.ndarray) else type(image).__name__
        must = f"must be a NumPy array of uint8, (h, w{', 3' if channels == 3 else ''})"
        remedy = "as_rgb(picture, name) converts other forms, and to_gray(picture) makes it gray."
        raise ImageError(name, value=found, must=must, remedy=remedy)


def is_flat(pixels: NDArray[Any]) -> bool:
    """Whether a picture shows nothing: red, green and blue each vary by at most `FLAT_RANGE` of 255.

    Parameters
    ----------
    pixels : ndarray of uint8 or uint16
        A picture that `as_rgb` accepts.
    """
    whole = np.asarray(pixels)
    parts = (whole[:1], whole)  # the first row decides of most pictures
    channels = (channel for part in parts for channel in cv2.split(_as_rgb(part)))
    return all(high - low <= FLAT_RANGE for low, high, _, _ in map(cv2.minMaxLoc, channels))


def to_gray(image: Picture) -> GrayPicture:
    """Return the luma of ITU-R BT.601, ``(299 R + 587 G + 114 B + 500) // 1000``, shape (h, w), uint8.

    In integer arithmetic it is the same for every version of OpenCV and every processor, and the identity on
    gray pictures.
    """
    check_picture(image)
    red, green, blue = cv2.split(image)
    luma = np.multiply(red, 299, dtype=np.uint32)
    luma += np.multiply(green, 587, dtype=np.uint32)
    luma += np.multiply(blue, 114, dtype=np.uint32)
    luma += 500
    luma //= 1000
    gray: NDArray[np.uint8] = luma.astype(np.uint8)
    return gray


def resize(image: Picture, size: tuple[int, int]) -> UInt8[np.ndarray, "height width 3"]:
    """Resize a picture; its aspect ratio is not preserved.

    First, a side that shrinks is averaged over areas (``cv2.INTER_AREA``); then, a side that grows is
    interpolated linearly (``cv2.INTER_LINEAR``).

    Parameters
    ----------
    image : ndarray of uint8, (h, w, 3)
    size : tuple of int
        (height, width) in pixels.

    Returns
    -------
    ndarray of uint8, (height, width, 3), read-only

    Raises
    ------
    ImageError
        `size` is not two integers, or is out of range (see `read_image`).
    """
    check_picture(image)
    try:
        height, width = (operator.index(side) for side in size)
    except (TypeError, ValueError):
        raise ImageError("size", value=size, must="must be two integers, (height, width)") from None
    check_size(height, width, "size")
    smaller = (min(width, image.shape[1]), min(height, image.shape[0]))
    result = cv2.resize(image, smaller, interpolation=cv2.INTER_AREA)
    if smaller != (width, height):
        result = cv2.resize(result, (width, height), interpolation=cv2.INTER_LINEAR)
    rgb = result.astype(np.uint8, copy=False)
    rgb.flags.writeable = False
    return rgb


def list_images(folder: str | os.PathLike[str]) -> list[Path]:
    """Return the pictures directly in `folder`, sorted by name (code points), without hidden files.

    Raises
    ------
    ImageError
        `folder` is not a readable directory, or holds no file with one of `SUFFIXES` (in any case).
    """
    found = Folder.of(folder)
    if not found.pictures:
        wanted = f"must hold a picture ({', '.join(sorted(SUFFIXES))})"
        value = f"{len(found.folders) + len(found.others)} other entries"
        name, remedy = f"folder {os.fspath(folder)}", "Is it the right folder?"
        raise ImageError(name, value=value, must=wanted, remedy=remedy)
    return list(found.pictures)


def _read_bytes(path: Path, name: str) -> bytes:
    must = f"must be a readable file of 1 to {MAX_BYTES} bytes"
    try:
        if not path.is_file():
            kind = "a directory" if path.is_dir() else "no such file"
            raise ImageError(name, value=kind, must=must, remedy="Check the path.")
        size = path.stat().st_size
        if not 0 < size <= MAX_BYTES:
            raise ImageError(name, value=f"{size} bytes", must=must)
        return path.read_bytes()
    except OSError as problem:
        raise ImageError(name, value=problem.strerror, must=must, remedy="Check its permissions.") from None


def _composite(rgba: UInt8[np.ndarray, "h w 4"], rgb: Picture) -> None:
    """Fill `rgb` with the picture on black, one channel at a time to save memory."""
    alpha = rgba[..., 3].astype(np.uint16)
    for channel in range(3):
        product = rgba[..., channel] * alpha
        product += 127
        product //= 255
        rgb[..., channel] = product
