"""Arrays as text, to the last bit: for a journal of plain JSON."""

import zlib
from base64 import b64decode, b64encode
from typing import Any, TypedDict

import numpy as np
from numpy.typing import NDArray


class Packed(TypedDict):
    """An array: its type, its shape, and its bytes, little-endian and compressed, in Base64."""

    dtype: str
    shape: list[int]
    data: str


def packed(array: NDArray[Any]) -> Packed:
    """Pack an array of numbers."""
    little = np.ascontiguousarray(array, dtype=array.dtype.newbyteorder("<"))
    text = b64encode(zlib.compress(little.tobytes(), 9)).decode("ascii")
    return {"dtype": little.dtype.str, "shape": list(array.shape), "data": text}


def unpacked(found: Packed) -> NDArray[Any]:
    """The array that was packed."""
    data = zlib.decompress(b64decode(found["data"]))
    return np.frombuffer(data, dtype=found["dtype"]).reshape(found["shape"])
