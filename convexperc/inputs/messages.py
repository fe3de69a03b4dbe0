"""The picture in a ROS message: `sensor_msgs` Image and CompressedImage."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from convexperc.errors import ImageError
from convexperc.features.decoding import decode
from convexperc.features.pictures import Picture, as_rgb
from convexperc.features.sizes import check_size

IMAGE, COMPRESSED = "sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"


class _Encoding(NamedTuple):
    """How the pixels of an encoding are stored."""

    channels: int
    depth: int
    to_rgb: Callable[[NDArray[Any]], NDArray[Any]]


def _same(pixels: NDArray[Any]) -> NDArray[Any]:
    return pixels


def _reversed(pixels: NDArray[Any]) -> NDArray[Any]:
    return pixels[..., ::-1]


def _without_alpha(pixels: NDArray[Any]) -> NDArray[Any]:
    return pixels[..., :3]


def _reversed_without_alpha(pixels: NDArray[Any]) -> NDArray[Any]:
    return pixels[..., 2::-1]


def _mosaic(code: int) -> Callable[[NDArray[Any]], NDArray[Any]]:
    return lambda pixels: np.asarray(cv2.cvtColor(pixels[..., 0], code))


_BYTES = {8: 1, 16: 2}
_ENCODINGS: dict[str, _Encoding] = {
    "8UC1": _Encoding(1, 8, _same),
    "8UC3": _Encoding(3, 8, _reversed),  # OpenCV's order, B, G, R, by convention
    "16UC1": _Encoding(1, 16, _same),
}
for _depth in _BYTES:
    _ENCODINGS |= {
        f"mono{_depth}": _Encoding(1, _depth, _same),
        f"rgb{_depth}": _Encoding(3, _depth, _same),
        f"bgr{_depth}": _Encoding(3, _depth, _reversed),
        f"rgba{_depth}": _Encoding(4, _depth, _without_alpha),
        f"bgra{_depth}": _Encoding(4, _depth, _reversed_without_alpha),
        f"bayer_rggb{_depth}": _Encoding(1, _depth, _mosaic(cv2.COLOR_BayerRGGB2RGB)),
        f"bayer_bggr{_depth}": _Encoding(1, _depth, _mosaic(cv2.COLOR_BayerBGGR2RGB)),
        f"bayer_gbrg{_depth}": _Encoding(1, _depth, _mosaic(cv2.COLOR_BayerGBRG2RGB)),
        f"bayer_grbg{_depth}": _Encoding(1, _depth, _mosaic(cv2.COLOR_BayerGRBG2RGB)),
    }
ENCODINGS = tuple(_ENCODINGS)
"""Encodings of Image messages that are read. Of the others, a depth is no picture, and YUV has many forms."""


@dataclass(frozen=True)
class Stamp:
    """The time in a message's header, in nanoseconds; 0 if none was set."""

    nanoseconds: int

    @classmethod
    def of(cls, message: Any) -> "Stamp":
        """Read the header."""
        stamp = message.header.stamp
        return cls(stamp.sec * 10**9 + stamp.nanosec)


def image_picture(message: Any, name: str) -> Picture:
    """Convert a `sensor_msgs/Image`.

    Alpha is left out, as ROS does when it converts to RGB: cameras fill it with anything. Of 16 bits the
    upper 8 are kept. A Bayer mosaic is interpolated bilinearly by OpenCV. The channels of ``8UC3``, which
    the encoding does not name, are B, G, R, as OpenCV has them.

    Raises
    ------
    ImageError
        Another encoding; a size out of range; rows that are shorter than their pixels, or missing.
    """
    encoding = _ENCODINGS.get(message.encoding)
    if encoding is None:
        must = f"must be one of {', '.join(ENCODINGS)}"
        raise ImageError(f"{name}: encoding", value=message.encoding, must=must, remedy="Convert it to rgb8.")
    check_size(message.height, message.width, name)
    return as_rgb(encoding.to_rgb(_pixels(message, encoding, name)), name)


def _pixels(message: Any, encoding: _Encoding, name: str) -> NDArray[Any]:
    """The pixels (height, width, channels) in the machine's byte order, without the padding of the rows."""
    row = message.width * encoding.channels * _BYTES[encoding.depth]
    step, height = message.step, message.height
    if step < row:
        must = f"must be at least {row} bytes, {message.width} pixels of {message.encoding}"
        raise ImageError(f"{name}: step", value=step, must=must)
    data, needed = np.asarray(message.data, dtype=np.uint8), step * (height - 1) + row
    if len(data) < needed:
        must = f"must hold {height} rows of {step} bytes, of which the last may end after {row}"
        raise ImageError(f"{name}: data", value=f"{len(data)} bytes", must=must, remedy="It is truncated.")
    rows = np.lib.stride_tricks.as_strided(
        data[:needed], (height, row), (step * data.strides[0], data.strides[0])
    )
    if encoding.depth == 8:
        return rows.reshape(height, message.width, encoding.channels)
    order = ">" if message.is_bigendian else "<"
    deep = np.ascontiguousarray(rows).view(f"{order}u2").astype(np.uint16)
    return deep.reshape(height, message.width, encoding.channels)


def compressed_picture(message: Any, name: str) -> Picture:
    """Decode a `sensor_msgs/CompressedImage`: JPEG or PNG, or what else `read_image` reads.

    A `format` such as ``rgb8; jpeg compressed bgr8`` says what the pixels were, and in which order OpenCV
    was given them. With ``compressed rgb8``, red and blue stand exchanged in the file, and are exchanged
    again, as ROS's own decoder does.

    Raises
    ------
    ImageError
        A compressed depth, by its format; a damaged, truncated or empty picture.
    """
    stated = message.format
    if "compresseddepth" in stated.lower() or stated.startswith(("32FC1", "64FC1")):
        must, remedy = "must be a picture: a depth has no colors", "Choose the topic of the color camera."
        raise ImageError(f"{name}: format", value=stated, must=must, remedy=remedy)
    data = bytes(message.data)
    if not data:
        raise ImageError(name, value="0 bytes", must="must be a picture")
    pixels = decode(data, name)
    if "compressed rgb" in stated and pixels.ndim == 3:
        pixels = pixels[..., [2, 1, 0, 3][: pixels.shape[2]]]
    return as_rgb(pixels, name)


READERS: dict[str, Callable[[Any, str], Picture]] = {IMAGE: image_picture, COMPRESSED: compressed_picture}
"""What reads the picture of each type of message."""
