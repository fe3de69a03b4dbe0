"""A model: the parts of one object, and its extent."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from convexperc.errors import InputError
from convexperc.simulation.extents import surface_points
from convexperc.simulation.parts import Part


@dataclass(frozen=True, slots=True)
class Model:
    """An object that stands on z = 0 at the origin.

    Azimuth 0 (+x) is the direction of its reference, the most recognisable view, such as the side of a car or
    the front of a sign.

    Attributes
    ----------
    name : str
        Its name in scenes and data sets, in lower case with hyphens.
    parts : tuple of Part
        Its parts, at least one.
    radius : float
        Radius in metres of the upright cylinder about the origin that contains it.
    height : float
        Height in metres of that cylinder.

    Raises
    ------
    InputError
        There is no part, or an extent is not a positive number.
    """

    name: str
    parts: tuple[Part, ...]
    radius: float
    height: float

    def __post_init__(self) -> None:
        if not self.parts:
            raise InputError("parts", value=self.parts, must="must hold at least one part")
        for name, value in (("radius", self.radius), ("height", self.height)):
            if not 0.0 < value < float("inf"):
                raise InputError(name, value=value, must="must be a positive number of metres")


def model(name: str, parts: Iterable[Part]) -> Model:
    """Return the model made of `parts`, with its radius and height measured on their surfaces.

    Parameters
    ----------
    name : str
        Its name.
    parts : iterable of Part
        Its parts, at least one.
    """
    pieces = tuple(parts)
    if not pieces:
        raise InputError("parts", value=pieces, must="must hold at least one part")
    points = np.concatenate([surface_points(part) for part in pieces])
    radius = float(np.hypot(points[:, 0], points[:, 1]).max())
    return Model(name, pieces, radius, float(points[:, 2].max()))
