"""Triangle meshes: convex hulls, and lofted, turned and swept bodies."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from jaxtyping import Float, Int
from scipy.interpolate import PchipInterpolator

from convexperc.simulation.parts import Axis, Part, Point

Station = tuple[float, float, float, float]
"""A cross section at (0, y, z): y, z, full width and full height, in metres; an extent of 0 is a tip."""

Rings = Float[np.ndarray, "_ _ 3"]
"""Rows of corners in metres; each ring runs anticlockwise about the direction of growing station, and a ring
whose corners all coincide is a tip."""


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
    return _mesh(material, rings.reshape(-1, 3), _loft_faces(rings.shape[0], rings.shape[1]))


def _loft_faces(stations: int, corners: int) -> Int[np.ndarray, "faces 3"]:
    index = np.arange(stations * corners).reshape(stations, corners)
    here, there = index[:-1], index[1:]
    here_next, there_next = np.roll(here, -1, axis=1), np.roll(there, -1, axis=1)
    sides = [np.stack([here, there, here_next], -1), np.stack([here_next, there, there_next], -1)]
    first, last = index[0], index[-1]
    fan = [(first[0], first[k], first[k + 1]) for k in range(1, corners - 1)]
    fan += [(last[0], last[k + 1], last[k]) for k in range(1, corners - 1)]
    return np.concatenate([side.reshape(-1, 3) for side in sides] + [np.array(fan)])


def turned(
    material: str,
    profile: Sequence[tuple[float, float]],
    position: Point = (0.0, 0.0, 0.0),
    axis: Axis = "z",
    steps: int = 32,
) -> Part:
    """Return a body turned on a lathe: the surface of revolution of a profile about an axis.

    Parameters
    ----------
    material : str
        Name of the paint.
    profile : sequence of (radius, height)
        Points in metres, with the outside on the right hand of the way from the first to the last. A point
        given twice is a sharp edge. An end with a radius above 0 is closed by a flat disc.
    position : tuple of float
        Position of radius 0, height 0, in metres.
    axis : {"x", "y", "z"}
        Direction of growing height.
    steps : int
        Corners around the axis.
    """
    points = [(0.0, profile[0][1])] + [profile[0]] * 2 if profile[0][0] > 0 else [profile[0]]
    points += profile[1:-1]
    points += [profile[-1]] * 2 + [(0.0, profile[-1][1])] if profile[-1][0] > 0 else [profile[-1]]
    angle = np.linspace(0.0, 2 * np.pi, steps, endpoint=False)
    flat = np.array([[r * np.cos(angle), r * np.sin(angle), np.full(steps, z)] for r, z in points])
    rings = np.roll(flat.transpose(0, 2, 1), {"z": 0, "x": 1, "y": 2}[axis], axis=2) + np.array(position)
    sharp = [k for k, (here, there) in enumerate(pairwise(points), start=1) if here == there]
    return _skin(material, np.split(rings, sharp))


def swept(material: str, path: Sequence[Point], radius: float | Sequence[float], steps: int = 12) -> Part:
    """Return a tube with flat ends along a smooth path.

    Parameters
    ----------
    material : str
        Name of the paint.
    path : sequence of points
        Points in metres on the middle line, joined by a smooth curve.
    radius : float or sequence of float
        Radius in metres, everywhere or at each point of `path`.
    steps : int
        Corners around the tube.
    """
    knots = np.column_stack([np.array(path), np.broadcast_to(radius, len(path))])
    line = _smooth(knots, 6 * (len(path) - 1) + 1)
    middle, radii = line[:, :3], line[:, 3]
    tangent = np.gradient(middle, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    side = np.cross(tangent[0], np.eye(3)[np.argmin(np.abs(tangent[0]))])
    angle = np.linspace(0.0, 2 * np.pi, steps, endpoint=False)[:, None]
    rings = []
    for centre, ahead, size in zip(middle, tangent, radii, strict=True):
        side = side - (side @ ahead) * ahead
        side /= np.linalg.norm(side)
        rings.append(centre + size * (np.cos(angle) * side + np.sin(angle) * np.cross(ahead, side)))
    tips = [np.broadcast_to(middle[end], (steps, 3)) for end in (0, -1)]
    ends = [np.stack([tips[0], rings[0]]), np.stack([rings[-1], tips[1]])]
    return _skin(material, [ends[0], np.stack(rings), ends[1]])


def rounded(material: str, stations: Sequence[Station], steps: int = 24, cuts: int = 24) -> Part:
    """Return a smooth body of elliptic cross sections along y.

    Parameters
    ----------
    material : str
        Name of the paint.
    stations : sequence of Station
        Cross sections, y growing.
    steps : int
        Corners of a cross section.
    cuts : int
        Cross sections to draw, spread evenly along the skin.
    """
    y, z, width, height = _smooth(np.array(stations), cuts).T
    angle = -np.linspace(0.0, 2 * np.pi, steps, endpoint=False)[:, None]
    rings = np.stack([width / 2 * np.cos(angle), y + 0.0 * angle, z + height / 2 * np.sin(angle)], axis=-1)
    rings = rings.transpose(1, 0, 2)
    ends = [np.stack([np.broadcast_to(rings[k].mean(axis=0), rings[k].shape), rings[k]]) for k in (0, -1)]
    return _skin(material, [ends[0], rings, ends[1][::-1]])


def _smooth(knots: Float[np.ndarray, "knots values"], cuts: int) -> Float[np.ndarray, "cuts values"]:
    """Return points on a curve through `knots` that never overshoots them, evenly along its chords."""
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(knots, axis=0), axis=1))])
    return np.asarray(PchipInterpolator(length, knots)(np.linspace(0.0, length[-1], cuts)))


def _skin(material: str, sections: Sequence[Rings]) -> Part:
    """Return the mesh of sections that meet at sharp edges, and therefore share no corners."""
    vertices: list[Float[np.ndarray, "corners 3"]] = []
    faces: list[Int[np.ndarray, "faces 3"]] = []
    count = 0
    for rings in sections:
        rows = []
        for ring in rings:
            tip = bool(np.ptp(ring, axis=0).max() < 1e-12)
            rows.append(np.full(len(ring), count) if tip else count + np.arange(len(ring)))
            vertices.append(ring[:1] if tip else ring)
            count += len(vertices[-1])
        for here, there in pairwise(rows):
            here_next, there_next = np.roll(here, -1), np.roll(there, -1)
            faces += [np.stack([here, here_next, there], -1), np.stack([here_next, there_next, there], -1)]
    triangles = np.concatenate(faces)
    whole = (triangles != np.roll(triangles, 1, axis=1)).all(axis=1)
    return _mesh(material, np.concatenate(vertices), triangles[whole])


def _mesh(material: str, vertices: Float[np.ndarray, "corners 3"], faces: Int[np.ndarray, "faces 3"]) -> Part:
    """Return a mesh of the given corners (metres) and triangles."""
    corners = tuple((float(x), float(y), float(z)) for x, y, z in vertices)
    return Part(
        "mesh", material, vertices=corners, faces=tuple((int(a), int(b), int(c)) for a, b, c in faces)
    )
