"""The frames of one moment, as robots deliver them: named, some missing, some masked, in RGB or in BGR."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from convexperc.errors import ImageError, RobotNameError
from convexperc.features.pictures import Channels, Picture, Pictures, as_rgb

Frame = NDArray[Any]
"""uint8 or uint16, (h, w), (h, w, 1), (h, w, 3) or (h, w, 4); see `as_rgb`."""
Frames = Mapping[str, Frame | None] | Sequence[Frame | None] | Frame
"""Each robot's frame by its name, or frames of robots without names (also as one array, frames first); None
where a robot has none."""
Masks = Mapping[str, NDArray[Any]]
"""Masks by the names of robots: (h, w), bool or uint8, 0 outside of the object."""


@dataclass(frozen=True, eq=False)
class Seen:
    """The frames that there are, ready to be described.

    Attributes
    ----------
    names : tuple of str
        Robots with a frame.
    pictures : list of uint8 (h, w, 3)
        RGB, in the same order; black outside of the masks.
    missing : tuple of str
        Robots without a frame.
    """

    names: tuple[str, ...]
    pictures: Pictures
    missing: tuple[str, ...]

    @classmethod
    def of(cls, views: Frames, channels: Channels = "RGB", masks: Masks | None = None) -> "Seen":
        """Convert the frames of one moment.

        Parameters
        ----------
        views : mapping of str to ndarray or None, or sequence of ndarray or None
            Robots of a sequence are called ``robot 1``, ``robot 2`` and so on, by their places.
        channels : {"RGB", "BGR"}
            Order of the channels of all frames.
        masks : mapping of str to ndarray, optional
            What of a robot's frame counts; the rest becomes black.

        Raises
        ------
        ImageError
            No robot has a frame, or a frame or a mask cannot be used; the robot is named.
        RobotNameError
            A mask for a robot that is not among the views.
        """
        named = _named(views)
        unknown = [name for name in masks or {} if name not in named]
        if unknown:
            must = f"must be for one of the robots {', '.join(named)}"
            raise RobotNameError("masks", value=unknown[0], must=must)
        names, pictures = list[str](), list[Picture]()
        for name, frame in named.items():
            if frame is None:
                continue
            what = f"the frame of robot {name!r}"
            picture = as_rgb(frame, what, channels)
            mask = None if masks is None else masks.get(name)
            names.append(name)
            pictures.append(picture if mask is None else masked(picture, mask, f"the mask of robot {name!r}"))
        missing = tuple(name for name in named if name not in names)
        if missing and not pictures:
            must, remedy = "must hold the frame of one robot at least", "Wait until a robot has a frame."
            raise ImageError("views", value=dict.fromkeys(missing), must=must, remedy=remedy)
        return cls(tuple(names), pictures, missing)

    @property
    def warnings(self) -> tuple[str, ...]:
        """One for each robot that is left out."""
        return tuple(f"robot {name!r} is left out: it has no frame" for name in self.missing)


def masked(picture: Picture, mask: object, name: str) -> Picture:
    """Return a picture that is black where the mask is 0, read-only.

    Parameters
    ----------
    picture : uint8 (h, w, 3)
    mask : ndarray of bool or uint8, (h, w) or (h, w, 1)
        0 or False outside of what counts, anything else inside.
    name : str
        How an error names the mask.

    Raises
    ------
    ImageError
        Another type, or another size than the picture.
    """
    if not isinstance(mask, np.ndarray) or mask.dtype not in (np.bool_, np.uint8):
        value = mask.dtype.name if isinstance(mask, np.ndarray) else type(mask).__name__
        must = "must be a NumPy array of bool or uint8"
        raise ImageError(name, value=value, must=must, remedy="0 or False is outside, all else inside.")
    inside = mask[..., 0] if mask.ndim == 3 and mask.shape[2] == 1 else mask
    if inside.shape != picture.shape[:2]:
        must = f"must have the size of the frame, {picture.shape[:2]} (height, width)"
        raise ImageError(name, value=mask.shape, must=must, remedy="Resize it without interpolation.")
    shown: Picture = cv2.bitwise_and(picture, picture, mask=np.ascontiguousarray(inside).view(np.uint8))
    shown.flags.writeable = False
    return shown


def _named(views: Frames) -> Mapping[str, Frame | None]:
    if isinstance(views, Mapping):
        return views
    if isinstance(views, np.ndarray) and views.ndim < 4:
        remedy = "For one view, pass a list with one frame, or a mapping of its robot's name to it."
        raise ImageError("views", value=views.shape, must="must be several frames, not one", remedy=remedy)
    return {f"robot {i}": frame for i, frame in enumerate(views, 1)}
