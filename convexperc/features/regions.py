"""The part of a picture that shows the object: a rectangle, or a mask."""

import os
import re
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Bool, UInt8
from numpy.typing import NDArray

from convexperc.errors import ImageError, check_type, is_integer
from convexperc.features.decoding.sizes import MIN_SIDE
from convexperc.features.pictures import Picture, check_picture, read_image

Mask = Bool[np.ndarray, "h w"]
"""True where a pixel shows the object."""
AnyMask = NDArray[Any]
"""bool or uint8, (h, w) or (h, w, 1); 0 or False outside of the object."""
Part = UInt8[np.ndarray, "height width 3"]
"""A part of a picture."""


@dataclass(frozen=True)
class Region:
    """A rectangle of pixels.

    Attributes
    ----------
    x, y : int
        Column and row of its upper left pixel, counted from 0 at the upper left of the picture.
    width, height : int
        Pixels, at least `MIN_SIDE` (8) each, as of a picture.
    """

    x: int
    y: int
    width: int
    height: int

    def __post_init__(self) -> None:
        for side in ("x", "y", "width", "height"):
            value = getattr(self, side)
            if not is_integer(value):
                raise ImageError(f"region: {side}", value=value, must="must be an integer: a count of pixels")
        if min(self.x, self.y) < 0 or min(self.width, self.height) < MIN_SIDE:
            must = f"must have x, y >= 0 and a width and a height of at least {MIN_SIDE} pixels"
            raise ImageError("region", value=str(self), must=must)

    def __str__(self) -> str:
        return f"{self.x},{self.y},{self.width},{self.height}"

    @classmethod
    def parse(cls, text: str) -> "Region":
        """Read ``x,y,width,height``.

        Raises
        ------
        ImageError
            These are not four integers, or they are out of range.
        """
        check_type(text, str, "region", ImageError)
        parts = text.split(",")
        if len(parts) != 4 or not all(re.fullmatch(r"\s*\d{1,9}\s*", part, re.ASCII) for part in parts):
            must = "must be x,y,width,height: four integers from 0 to 999999999"
            raise ImageError("region", value=text, must=must)
        return cls(*map(int, parts))

    @classmethod
    def around(cls, mask: Bool[np.ndarray, "_ _"], name: str = "mask") -> "Region":
        """The smallest rectangle that holds every pixel of a mask.

        Raises
        ------
        ImageError
            The mask is empty, or its rectangle has a side under `MIN_SIDE`.
        """
        check_type(mask, np.ndarray, name, ImageError)
        if mask.dtype != np.bool_ or mask.ndim != 2:
            raise ImageError(name, value=mask, must="must be a NumPy array of bool, (h, w)")
        columns, rows = (np.flatnonzero(mask.any(axis=axis)) for axis in (0, 1))
        if not len(rows):
            raise ImageError(name, value="no pixel", must="must mark the object: pixels other than 0")
        x, y = int(columns[0]), int(rows[0])
        width, height = int(columns[-1]) + 1 - x, int(rows[-1]) + 1 - y
        if min(width, height) < MIN_SIDE:
            must = f"must mark an object of at least {MIN_SIDE} pixels in width and height"
            raise ImageError(name, value=f"{width} x {height} (width x height)", must=must)
        return cls(x, y, width, height)


def read_mask(path: str | os.PathLike[str]) -> Mask:
    """Read a picture as a mask: true where any channel is other than 0.

    Raises
    ------
    ImageError
        See `convexperc.features.read_image`.
    """
    return np.asarray(read_image(path).any(axis=2))


def cut_out(picture: Picture, shown: object, name: str = "picture") -> Part:
    """`cropped` for a region, `masked` for a mask; read-only.

    Raises
    ------
    ImageError
        See there.
    """
    return cropped(picture, shown, name) if isinstance(shown, Region) else masked(picture, shown, name)


def cropped(picture: Picture, region: Region, name: str = "picture") -> Part:
    """Cut out a region; read-only. The references should be cut in the same way, see `masked`.

    Raises
    ------
    ImageError
        The region is not within the picture.
    """
    check_picture(picture, name)
    check_type(region, Region, f"{name}: region", ImageError)
    height, width = picture.shape[:2]
    if region.x + region.width > width or region.y + region.height > height:
        must = f"must lie within the picture of {width} x {height} pixels (width x height)"
        raise ImageError(f"{name}: region x,y,width,height", value=str(region), must=must)
    part = picture[region.y : region.y + region.height, region.x : region.x + region.width]
    return _frozen(part.copy())


def masked(picture: Picture, mask: object, name: str = "picture") -> Part:
    """Make black what a mask leaves out, and cut out the mask's bounding box; read-only.

    Without the cut, the share of black pixels in the histograms, and the place and scale of the object in the
    grid of HOG, would tell where the object is in the view and how far away, instead of what it is. The
    references should be treated in the same way: against pictures with their surroundings, a masked view
    explains less than a whole one.

    Parameters
    ----------
    picture : ndarray of uint8, (h, w, 3)
    mask : ndarray of bool or uint8, (h, w) or (h, w, 1)
        0 or False outside of the object, anything else inside.
    name : str
        How an error names the picture.

    Raises
    ------
    ImageError
        The mask has another type or size, is empty, or its bounding box has a side under `MIN_SIDE`.
    """
    check_picture(picture, name)
    if not isinstance(mask, np.ndarray) or mask.dtype not in (np.bool_, np.uint8):
        value = mask.dtype.name if isinstance(mask, np.ndarray) else type(mask).__name__
        must = "must be a NumPy array of bool or uint8, or a rectangle as Region(x, y, width, height)"
        remedy = "In a mask, 0 or False is outside, all else inside."
        raise ImageError(f"{name}: mask", value=value, must=must, remedy=remedy)
    flat = mask[..., 0] if mask.ndim == 3 and mask.shape[2] == 1 else mask
    if flat.shape != picture.shape[:2]:
        must = f"must have the size of the picture, {picture.shape[:2]} (height, width)"
        remedy = "Resize it without interpolation."
        raise ImageError(f"{name}: mask", value=mask.shape, must=must, remedy=remedy)
    inside = flat != 0
    region = Region.around(inside, f"{name}: mask")
    part = cropped(picture, region).copy()
    part[~inside[region.y : region.y + region.height, region.x : region.x + region.width]] = 0
    return _frozen(part)


def _frozen(picture: Part) -> Part:
    picture.flags.writeable = False
    return picture
