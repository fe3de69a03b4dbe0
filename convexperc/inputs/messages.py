"""The picture in a ROS message: `sensor_msgs` Image and CompressedImage."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from convexperc.errors import ImageError, check_type, is_integer
from convexperc.features.decoding.decode import decode
from convexperc.features.decoding.sizes import check_size
from convexperc.features.pictures import Picture, as_rgb

IMAGE, COMPRESSED = "sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"


class _Encoding(NamedTuple):
    """How the pixels of an encoding are stored."""

    channels: int
    depth: int
    to_rgb: Callable[[NDArray[Any]], NDArray[Any]]
    multiple: int = 1
    """Of which the width must be one."""


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


def _luma_and_chroma(code: int) -> _Encoding:
    """Y of every pixel, U and V of every two, 8 bits each (4:2:2, packed)."""
    return _Encoding(2, 8, lambda pixels: np.asarray(cv2.cvtColor(pixels, code)), 2)


_BYTES = {8: 1, 16: 2}
_ENCODINGS: dict[str, _Encoding] = {
    "8UC1": _Encoding(1, 8, _same),
    "8UC3": _Encoding(3, 8, _reversed),  # OpenCV's order, B, G, R, by convention
    "16UC1": _Encoding(1, 16, _same),
    "yuv422": _luma_and_chroma(cv2.COLOR_YUV2RGB_UYVY),
    "uyvy": _luma_and_chroma(cv2.COLOR_YUV2RGB_UYVY),
    "yuv422_yuy2": _luma_and_chroma(cv2.COLOR_YUV2RGB_YUY2),
    "yuyv": _luma_and_chroma(cv2.COLOR_YUV2RGB_YUY2),
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
"""Encodings of Image messages that are read, by their names in sensor_msgs; a depth is no picture."""


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
    upper 8 are kept. Y, U and V are those of ITU-R BT.601 with Y from 16 to 235, for which OpenCV and ROS
    take them. A Bayer mosaic is interpolated bilinearly by OpenCV. The channels of ``8UC3``, which
    the encoding does not name, are B, G, R, as OpenCV has them.

    Raises
    ------
    ImageError
        Another encoding; a size out of range; an odd width where two pixels share U and V; rows that are
        shorter than their pixels, or missing.
    """
    stated, height, width = (_part(message, part, name) for part in ("encoding", "height", "width"))
    encoding = _ENCODINGS.get(stated) if isinstance(stated, str) else None
    if encoding is None:
        must = f"must be one of {', '.join(ENCODINGS)}"
        raise ImageError(f"{name}: encoding", value=stated, must=must, remedy="Convert it to rgb8.")
    check_size(_integer(height, f"{name}: height"), _integer(width, f"{name}: width"), name)
    if message.width % encoding.multiple:
        must = f"must be a multiple of {encoding.multiple} with the encoding {message.encoding}"
        raise ImageError(f"{name}: width", value=message.width, must=must)
    return as_rgb(encoding.to_rgb(_pixels(message, encoding, name)), name)


def _pixels(message: Any, encoding: _Encoding, name: str) -> NDArray[Any]:
    """The pixels (height, width, channels) in the machine's byte order, without the padding of the rows."""
    width, height = int(message.width), int(message.height)
    row = width * encoding.channels * _BYTES[encoding.depth]
    step = _integer(_part(message, "step", name), f"{name}: step")
    if step < row:
        must = f"must be at least {row} bytes, {message.width} pixels of {message.encoding}"
        raise ImageError(f"{name}: step", value=step, must=must)
    data, needed = _bytes(_part(message, "data", name), f"{name}: data"), step * (height - 1) + row
    if len(data) < needed:
        must = f"must hold {height} rows of {step} bytes, of which the last may end after {row}"
        raise ImageError(f"{name}: data", value=f"{len(data)} bytes", must=must, remedy="It is truncated.")
    rows = np.lib.stride_tricks.as_strided(
        data[:needed], (height, row), (step * data.strides[0], data.strides[0])
    )
    if encoding.depth == 8:
        return rows.reshape(height, width, encoding.channels)
    order = ">" if _integer(_part(message, "is_bigendian", name), f"{name}: is_bigendian") else "<"
    deep = np.ascontiguousarray(rows).view(f"{order}u2").astype(np.uint16)
    return deep.reshape(height, width, encoding.channels)


def _part(message: Any, part: str, name: str) -> Any:
    """A field of a message."""
    if not hasattr(message, part):
        must = f"must be a message with the field {part}, as sensor_msgs has it"
        raise ImageError(name, value=type(message).__name__, must=must)
    return getattr(message, part)


def _integer(value: Any, what: str) -> int:
    if not isinstance(value, bool | np.bool_) and not is_integer(value):
        raise ImageError(what, value=value, must="must be an integer")
    return int(value)


def _bytes(data: Any, what: str) -> NDArray[np.uint8]:
    """What ROS calls uint8[]: bytes in ROS 1, an array of them in ROS 2."""
    try:
        found = np.frombuffer(data, np.uint8) if isinstance(data, (bytes, bytearray)) else np.asarray(data)
    except ValueError:  # ragged
        found = np.empty(0)
    if found.dtype != np.uint8 or found.ndim != 1:
        value = type(data).__name__ if found.ndim == 0 else f"{found.dtype.name} {found.shape}"
        raise ImageError(what, value=value, must="must be bytes, or an array of uint8 with one dimension")
    return found


def compressed_picture(message: Any, name: str) -> Picture:
    """Decode a `sensor_msgs/CompressedImage`: JPEG or PNG, or what else `read_image` reads.

    A `format` such as ``rgb8; jpeg compressed bgr8`` says what the pixels were, and in which order OpenCV
    was given them. With ``compressed rgb8``, red and blue stand exchanged in the file, and are exchanged
    again, as ROS's own decoder does. Alpha is left out, as of an Image.

    Raises
    ------
    ImageError
        A compressed depth, by its format; a damaged, truncated or empty picture.
    """
    stated = _part(message, "format", name)
    check_type(stated, str, f"{name}: format", ImageError)
    if "compresseddepth" in stated.lower() or stated.startswith(("32FC1", "64FC1")):
        must, remedy = "must be a picture: a depth has no colors", "Choose the topic of the color camera."
        raise ImageError(f"{name}: format", value=stated, must=must, remedy=remedy)
    data = _bytes(_part(message, "data", name), f"{name}: data").tobytes()
    if not data:
        raise ImageError(name, value="0 bytes", must="must be a picture")
    pixels = decode(data, name, alpha=False)
    if "compressed rgb" in stated and pixels.ndim == 3:
        pixels = pixels[..., ::-1]
    return as_rgb(pixels, name)


READERS: dict[str, Callable[[Any, str], Picture]] = {IMAGE: image_picture, COMPRESSED: compressed_picture}
"""What reads the picture of each type of message."""
