"""A scene as data: one object, robots with cameras on a ring around it, obstacles in between.

The object stands at the origin of a floor; z points up. Azimuths are degrees, anticlockwise from above;
0 is the direction from which the reference is taken: the side of a car, the front of the sign.

Paper: Section IV-A, the scenes of the multi-robot simulation (the layout of robots and obstacles is ours).
"""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float

from convexperc.errors import InputError
from convexperc.simulation.obstacles import ObstacleKind

ObjectKind = Literal["red-car", "gray-car", "ica-sign"]

LOWEST_CAMERA = 0.5
"""A lens, in metres, stands no lower than the deck of its robot."""


def _place(azimuth: float, distance: float, height: float) -> Float[np.ndarray, "3"]:
    angle = math.radians(azimuth)
    return np.array([distance * math.cos(angle), distance * math.sin(angle), height])


def _check(name: str, value: float, low: float, high: float) -> None:
    if not low <= value <= high:
        raise InputError(name, value=value, must=f"must lie in [{low:g}, {high:g}]")


@dataclass(frozen=True, slots=True)
class Camera:
    """A camera that looks at the object.

    Parameters
    ----------
    azimuth : float
        Direction from the object to the camera, in degrees.
    distance : float
        Horizontal distance from the object's centre, in metres.
    height : float
        Height of the lens above the floor, in metres.
    field_of_view : float
        Vertical angle of view, in degrees.
    pan : float
        Degrees by which the camera looks past the object, anticlockwise from above.

    Raises
    ------
    InputError
        A value is not finite or outside its range.
    """

    azimuth: float
    distance: float
    height: float
    field_of_view: float = 36.0
    pan: float = 0.0

    def __post_init__(self) -> None:
        _check("azimuth", self.azimuth, -360.0, 360.0)
        _check("distance", self.distance, 0.5, 40.0)
        _check("height", self.height, LOWEST_CAMERA, 40.0)
        _check("field_of_view", self.field_of_view, 1.0, 120.0)
        _check("pan", self.pan, -90.0, 90.0)

    def position(self) -> Float[np.ndarray, "3"]:
        """Return the place of the lens, in metres."""
        return _place(self.azimuth, self.distance, self.height)

    def axes(self, target_height: float) -> Float[np.ndarray, "2 3"]:
        """Return the picture's unit vectors to the right and upwards, as rows.

        Parameters
        ----------
        target_height : float
            Height in metres of the point above the origin at which the camera looks.
        """
        forward = _place(self.azimuth + self.pan, -self.distance, target_height - self.height)
        forward /= np.linalg.norm(forward)
        right = np.cross(forward, [0.0, 0.0, 1.0])
        right /= np.linalg.norm(right)
        return np.stack([right, np.cross(right, forward)])


@dataclass(frozen=True, slots=True)
class Obstacle:
    """A crate, a barrel or a wall near the object.

    Parameters
    ----------
    kind : {"crate", "barrel", "wall"}
        What it is.
    azimuth : float
        Direction from the object to the obstacle, in degrees.
    distance : float
        Horizontal distance from the object's centre, in metres.
    width, height : float
        Full extents, in metres.
    elevation : float
        Height of its foot above the floor, in metres: on top of another one.
    turn : float
        Degrees by which its face is turned away from facing outwards.

    Raises
    ------
    InputError
        A value is not finite or outside its range.
    """

    kind: ObstacleKind
    azimuth: float
    distance: float
    width: float
    height: float
    elevation: float = 0.0
    turn: float = 0.0

    def __post_init__(self) -> None:
        _check("azimuth", self.azimuth, -360.0, 360.0)
        _check("distance", self.distance, 0.5, 40.0)
        _check("width", self.width, 0.2, 20.0)
        _check("height", self.height, 0.2, 20.0)
        _check("elevation", self.elevation, 0.0, 20.0)
        _check("turn", self.turn, -180.0, 180.0)

    def position(self) -> Float[np.ndarray, "3"]:
        """Return the centre of its foot, in metres."""
        return _place(self.azimuth, self.distance, self.elevation)


@dataclass(frozen=True, slots=True)
class Scene:
    """One object, the reference camera, the robots and the obstacles.

    Parameters
    ----------
    name : {"red-car", "gray-car", "ica-sign"}
        The object, and the name of the scene.
    target_height : float
        Height in metres of the point at which all cameras look.
    reference : Camera
        Takes the reference, with neither robots nor obstacles present.
    robots : tuple of Camera
        One camera a robot; robot k (from 1) is called ``robot-k``.
    obstacles : tuple of Obstacle
        What may hide the object.
    overhead : Camera
        Looks at the whole scene from above.

    Raises
    ------
    InputError
        There is no robot.
    """

    name: ObjectKind
    target_height: float
    reference: Camera
    robots: tuple[Camera, ...]
    obstacles: tuple[Obstacle, ...] = ()
    overhead: Camera = Camera(azimuth=-28.0, distance=15.0, height=17.0, field_of_view=39.0)

    def __post_init__(self) -> None:
        if not self.robots:
            raise InputError("robots", value=self.robots, must="must hold at least one camera")

    def cameras(self) -> dict[str, Camera]:
        """Return every camera by name: ``reference``, ``overhead``, ``robot-1``, ``robot-2``, ..."""
        robots = {f"robot-{k}": camera for k, camera in enumerate(self.robots, start=1)}
        return {"reference": self.reference, "overhead": self.overhead, **robots}
