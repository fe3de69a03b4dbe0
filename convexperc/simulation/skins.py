"""Parts with a skin of triangles: convex hulls and lofted bodies."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float, Int

from convexperc.simulation.parts import Part, Point


def hull(material: str, corners: Sequence[Point]) -> Part:
    """Return the convex hull of `corners` (metres)."""
    return Part("mesh", material, vertices=tuple(corners))


def loft(material: str, rings: Float[np.ndarray, "stations corners 3"]) -> Part:
    """Return the closed skin over a row of rings with equally many corners each.

    Parameters
    ----------
    material : str
        Name of the paint.
    rings : ndarray, shape (stations, corners, 3)
        Corners in metres; anticlockwise in the (x, z) plane seen from -y, stations in growing y.

    Returns
    -------
    Part
        A mesh whose two ends are closed by fans.
    """
    vertices = tuple((float(x), float(y), float(z)) for x, y, z in rings.reshape(-1, 3))
    faces = _loft_faces(rings.shape[0], rings.shape[1])
    return Part(
        "mesh", material, vertices=vertices, faces=tuple((int(a), int(b), int(c)) for a, b, c in faces)
    )


def _loft_faces(stations: int, corners: int) -> Int[np.ndarray, "faces 3"]:
    index = np.arange(stations * corners).reshape(stations, corners)
    here, there = index[:-1], index[1:]
    here_next, there_next = np.roll(here, -1, axis=1), np.roll(there, -1, axis=1)
    sides = [np.stack([here, there, here_next], -1), np.stack([here_next, there, there_next], -1)]
    first, last = index[0], index[-1]
    fan = [(first[0], first[k], first[k + 1]) for k in range(1, corners - 1)]
    fan += [(last[0], last[k + 1], last[k]) for k in range(1, corners - 1)]
    return np.concatenate([side.reshape(-1, 3) for side in sides] + [np.array(fan)])
