"""Placement of obstacles that hide an object from a camera, and tests of overlap."""

import math
from collections.abc import Sequence
from typing import Literal

import numpy as np

from convexperc.simulation.camera import Camera
from convexperc.simulation.scenes import Obstacle
from convexperc.simulation.setting import Setting

Cover = Literal["all", "side", "foot"]
"""The part of the object that an obstacle hides: all, one side of a vertical line, or below a height."""


def hiding_obstacle(
    camera: Camera, radius: float, height: float, setting: Setting, random: np.random.Generator, cover: Cover
) -> Obstacle | None:
    """Return an obstacle between a camera and an object that hides all or a part of it.

    The object is approximated by the upright cylinder that contains it, so that the visible share may differ
    from the intended one and has to be measured.

    Parameters
    ----------
    camera : Camera
        Looks at the object.
    radius, height : float
        Of the object's cylinder, in metres.
    setting : Setting
        Determines the kinds of obstacles.
    random : numpy.random.Generator
        Chooses the position on the line of sight, and how much a partial obstacle hides.
    cover : {"all", "side", "foot"}
        What to hide.

    Returns
    -------
    Obstacle or None
        None if there is no space for it between the robot and the object.
    """
    reach = camera.distance
    near, far = radius + setting.margin, reach - setting.robot_reach - setting.margin
    distance = near + float(random.uniform(0.3, 0.8)) * (far - near)
    gap = reach - distance
    half = gap * math.tan(math.asin(min(radius / reach, 0.99)))
    share = float(random.uniform(0.4, 0.65))
    top = _line_of_sight(camera, radius, height * (share if cover == "foot" else 1.0), gap)
    width = 2.12 * half + setting.margin
    aside = 0.0
    if cover == "side":
        width *= float(random.uniform(share, 1.0))
        aside = float(random.choice([-1.0, 1.0])) * (half * (1.0 - 2.0 * share) + width / 2)
    tall = 1.06 * top + setting.margin
    solid = width <= setting.widest and near + width / 2 <= distance <= far - width / 2
    solid = bool(solid and random.random() < 0.75)
    if not solid and not near + setting.thickness / 2 <= distance <= far - setting.thickness / 2:
        return None
    aslant = math.degrees(math.atan2(aside, distance))
    return Obstacle(
        setting.solid if solid else setting.flat,
        azimuth=round((camera.azimuth + aslant + 180.0) % 360.0 - 180.0, 3),
        distance=round(math.hypot(distance, aside), 4),
        width=round(max(width, 0.06), 4),
        height=round(max(tall, 0.06), 4),
        turn=round(-aslant + float(random.uniform(-6.0, 6.0)), 3),
    )


def _line_of_sight(camera: Camera, radius: float, height: float, gap: float) -> float:
    """Return the height, `gap` metres from a camera, of its line of sight to an object's top at `height`."""
    edge = camera.distance + (radius if height < camera.height else -radius)
    return camera.height + (height - camera.height) * gap / edge


def stand_apart(cameras: Sequence[Camera], obstacles: Sequence[Obstacle], setting: Setting) -> bool:
    """Return whether no two robots or obstacles overlap.

    Each is approximated by a circle: a robot by its reach about the lens, an obstacle by half its width about
    its centre.
    """
    circles = [(camera.position()[:2], setting.robot_reach) for camera in cameras]
    circles += [(thing.position()[:2], thing.width / 2) for thing in obstacles]
    for k, (centre, reach) in enumerate(circles):
        for other, other_reach in circles[:k]:
            if float(np.hypot(*(centre - other))) < reach + other_reach:
                return False
    return True
