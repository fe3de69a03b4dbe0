"""The frames of one moment, as robots deliver them: named, some missing, some cut out, in RGB or in BGR."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from convexperc.errors import ImageError, RobotNameError, check_type, entries
from convexperc.features.pictures import Channels, Picture, Pictures, as_rgb
from convexperc.features.regions import AnyMask, Region, cut_out

Frame = NDArray[Any]
"""uint8 or uint16, (h, w), (h, w, 1), (h, w, 3) or (h, w, 4); see `as_rgb`."""
Frames = Mapping[str, Frame | None] | Sequence[Frame | None] | Frame
"""Each robot's frame by its name, or frames of robots without names (also as one array, frames first); None
where a robot has none."""
Regions = Mapping[str, Region | AnyMask]
"""What shows the object, by the names of robots: a rectangle or a mask."""


@dataclass(frozen=True, eq=False)
class Seen:
    """The frames that there are, ready to be described.

    Attributes
    ----------
    names : tuple of str
        Robots with a frame.
    pictures : list of uint8 (h, w, 3)
        RGB, in the same order; what is outside of the regions is cut away.
    missing : tuple of str
        Robots without a usable frame.
    """

    names: tuple[str, ...]
    pictures: Pictures
    missing: tuple[str, ...]

    @classmethod
    def of(cls, views: Frames, channels: Channels = "RGB", regions: Regions | None = None) -> "Seen":
        """Convert the frames of one moment.

        Parameters
        ----------
        views : mapping of str to ndarray or None, or sequence of ndarray or None
            Robots of a sequence are called ``robot 1``, ``robot 2`` and so on, by their places.
        channels : {"RGB", "BGR"}
            Order of the channels of all frames.
        regions : mapping of str to Region or ndarray, optional
            What of a robot's frame counts; see `cut_out`.

        Raises
        ------
        ImageError
            No robot has a frame, or a frame or a region cannot be used; the robot is named.
        RobotNameError
            A robot that is not named by a string, or a region for a robot that is not among the views.
        """
        check_type(regions, (Mapping, type(None)), "regions", ImageError)
        named = _named(views)
        unknown = [name for name in regions or {} if name not in named]
        if unknown:
            must = f"must be for one of the robots {', '.join(named)}"
            raise RobotNameError("regions", value=unknown[0], must=must)
        names, pictures = list[str](), list[Picture]()
        for name, frame in named.items():
            if frame is None:
                continue
            what = f"the frame of robot {name!r}"
            picture = as_rgb(frame, what, channels)
            region = None if regions is None else regions.get(name)
            names.append(name)
            pictures.append(picture if region is None else cut_out(picture, region, what))
        missing = tuple(name for name in named if name not in names)
        if missing and not pictures:
            must, remedy = "must hold the frame of one robot at least", "Wait until a robot has a frame."
            raise ImageError("views", value=dict.fromkeys(missing), must=must, remedy=remedy)
        return cls(tuple(names), pictures, missing)

    @property
    def warnings(self) -> tuple[str, ...]:
        """One for each robot that is left out."""
        return tuple(f"robot {name!r} is left out: it has no usable frame" for name in self.missing)


def _named(views: Frames) -> Mapping[str, Frame | None]:
    if isinstance(views, Mapping):
        for name in views:
            if not isinstance(name, str):
                remedy = "Name each robot by a string, or pass a sequence of frames."
                raise RobotNameError("views", value=name, must="must name robots by strings", remedy=remedy)
        return views
    if isinstance(views, np.ndarray) and views.ndim < 4:
        remedy = "For one view, pass a list with one frame, or a mapping of its robot's name to it."
        raise ImageError("views", value=views.shape, must="must be several frames, not one", remedy=remedy)
    return {f"robot {i}": frame for i, frame in enumerate(entries(views, "views", ImageError), 1)}
