"""Limits of the size of a picture, by which a file is refused before any pixel is decoded."""

from convexperc.errors import ImageError

MIN_SIDE = 8
"""Least side in pixels, as of a working size."""
MAX_PIXELS = 2**26
"""Largest number of pixels: 192 MiB as RGB."""
MAX_BYTES = 8 * MAX_PIXELS
"""Largest file in bytes: that many pixels as uncompressed 16-bit RGBA."""
SIZES = f"must have sides of at least {MIN_SIDE} pixels and at most {MAX_PIXELS} pixels in all"


def check_size(height: int, width: int, name: str) -> None:
    """Raise unless a size in pixels is within `MIN_SIDE` and `MAX_PIXELS`.

    Raises
    ------
    ImageError
        It is not.
    """
    if min(height, width) < MIN_SIDE or height * width > MAX_PIXELS:
        value = f"{height} x {width} (height x width)"
        raise ImageError(name, value=value, must=SIZES, remedy="Use another size.")
