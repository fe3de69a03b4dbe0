"""Extents of parts: points on their surfaces."""

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation

from convexperc.simulation.parts import Part

STEPS = 64
"""Points around a round part, and from pole to pole: an error of at most 0.2 % of its diameter."""


def surface_points(part: Part) -> Float[np.ndarray, "points 3"]:
    """Return points (points, 3) on the surface of a part, in metres, that span its extent.

    The corners of a box or a mesh are exact; a round part is sampled, which underestimates its extent by less
    than 0.2 % of its diameter.

    Parameters
    ----------
    part : Part
        What to measure.
    """
    if part.shape == "mesh":
        return np.array(part.vertices)
    turn = Rotation.from_euler("XYZ", part.rotation, degrees=True)
    return np.asarray(turn.apply(_local_points(part)) + np.array(part.position))


def _local_points(part: Part) -> Float[np.ndarray, "points 3"]:
    """Return points on a box, a cylinder, a capsule or an ellipsoid about its own centre."""
    size = np.array(part.size)
    if part.shape == "box":
        corners = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
        return np.asarray(corners * size)
    around = np.linspace(0.0, 2 * np.pi, STEPS, endpoint=False)
    if part.shape == "cylinder":
        ends = np.repeat([-size[1], size[1]], STEPS)
        circle = np.tile(size[0] * np.stack([np.cos(around), np.sin(around)]), 2)
        return np.stack([*circle, ends], axis=-1)
    polar, turn = (grid.ravel() for grid in np.meshgrid(np.linspace(0.0, np.pi, STEPS + 1), around))
    sphere = np.stack([np.sin(polar) * np.cos(turn), np.sin(polar) * np.sin(turn), np.cos(polar)], -1)
    if part.shape == "ellipsoid":
        return np.asarray(sphere * size)
    return np.asarray(sphere * size[0] + np.array([0.0, 0.0, size[1]]) * np.sign(sphere[:, 2:]))
