"""Rotation and translation of several parts."""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from math import asin, atan2, degrees

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation

from convexperc.simulation.parts import Part, Point


def placed(
    parts: Iterable[Part], position: Point = (0.0, 0.0, 0.0), rotation: Point = (0.0, 0.0, 0.0)
) -> Iterator[Part]:
    """Yield parts rotated about the origin by `rotation` (degrees) and then moved by `position` (metres).

    Parameters
    ----------
    parts : iterable of Part
        What to place.
    position : tuple of float
        New position of the origin of the parts, in metres.
    rotation : tuple of float
        Euler angles in degrees, as those of a `Part`.
    """
    turn = Rotation.from_euler("XYZ", rotation, degrees=True)
    for part in parts:
        if part.shape == "mesh":
            corners = turn.apply(np.array(part.vertices)) + np.array(position)
            yield replace(part, vertices=tuple((float(x), float(y), float(z)) for x, y, z in corners))
        else:
            x, y, z = turn.apply(np.array(part.position)) + np.array(position)
            whole = turn * Rotation.from_euler("XYZ", part.rotation, degrees=True)
            yield replace(part, position=(float(x), float(y), float(z)), rotation=_angles(whole.as_matrix()))


def _angles(matrix: Float[np.ndarray, "3 3"]) -> Point:
    """Return Euler angles about x, the turned y and the turned z, in degrees; the last is 0 if y is at 90."""
    tilt = asin(float(np.clip(matrix[0, 2], -1.0, 1.0)))
    if abs(matrix[0, 2]) > 1.0 - 1e-12:
        return degrees(atan2(matrix[2, 1], matrix[1, 1])), degrees(tilt), 0.0
    about_x, about_z = atan2(-matrix[1, 2], matrix[2, 2]), atan2(-matrix[0, 1], matrix[0, 0])
    return degrees(about_x), degrees(tilt), degrees(about_z)
