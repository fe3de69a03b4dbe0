"""A scene as data: one object, robots with cameras on a ring around it, obstacles in between.

Paper: Section IV-A, the scenes of the multi-robot simulation and of the physical robots (the layouts of
robots and obstacles are ours).
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float

from convexperc.errors import InputError
from convexperc.simulation.camera import Camera, place
from convexperc.simulation.checks import check_name, check_range
from convexperc.simulation.light import BRIGHT, Light
from convexperc.simulation.obstacles import OBSTACLES, ObstacleKind
from convexperc.simulation.robots import ROBOTS
from convexperc.simulation.surroundings import SURROUNDINGS

RobotKind = Literal["husky", "rover"]

LENS_HEIGHTS: dict[RobotKind, tuple[float, float]] = {"husky": (0.5, 3.0), "rover": (0.1, 0.5)}
"""Lowest and highest lens of each kind of robot, in metres."""

OVERHEAD = Camera(azimuth=-28.0, distance=15.0, height=21.0, field_of_view=39.0)
"""Default overhead camera, for scenes in the park."""


def _check_choice(name: str, value: str, choices: tuple[str, ...]) -> None:
    if value not in choices:
        raise InputError(name, value=value, must=f"must be one of {', '.join(choices)}")


@dataclass(frozen=True, slots=True)
class Robot:
    """A wheeled robot that stands under its camera's lens and faces where the camera looks.

    Attributes
    ----------
    kind : {"husky", "rover"}
        A robot of a metre's length, or one of a quarter of a metre.
    camera : Camera
        Its camera, which determines its position.

    Raises
    ------
    InputError
        There is no such kind, or its lens cannot be at that height.
    """

    kind: RobotKind
    camera: Camera

    def __post_init__(self) -> None:
        _check_choice("robot", self.kind, tuple(ROBOTS))
        check_range(f"lens height of a {self.kind}", self.camera.height, *LENS_HEIGHTS[self.kind])


@dataclass(frozen=True, slots=True)
class Obstacle:
    """Something near the object that may hide it.

    Attributes
    ----------
    kind : str
        A name of `convexperc.simulation.obstacles.OBSTACLES`.
    azimuth : float
        Direction from the object to the obstacle, in degrees.
    distance : float
        Horizontal distance from the object's centre, in metres.
    width, height : float
        Full extents, in metres.
    elevation : float
        Height of its foot above the floor, in metres, for one on top of another.
    turn : float
        Rotation in degrees from facing outwards.

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
        _check_choice("obstacle", self.kind, tuple(OBSTACLES))
        check_range("azimuth", self.azimuth, -360.0, 360.0)
        check_range("distance", self.distance, 0.05, 40.0)
        check_range("width", self.width, 0.05, 20.0)
        check_range("height", self.height, 0.05, 20.0)
        check_range("elevation", self.elevation, 0.0, 20.0)
        check_range("turn", self.turn, -180.0, 180.0)

    def position(self) -> Float[np.ndarray, "3"]:
        """Return the centre (3,) of its foot, in metres."""
        return place(self.azimuth, self.distance, self.elevation)


@dataclass(frozen=True, slots=True)
class Scene:
    """One object, the reference camera, the robots, the obstacles, the surroundings and the light.

    The same description gives the same pixels on the same engine.

    Attributes
    ----------
    name : str
        Name of the scene and of its folder.
    object : str
        A name of `convexperc.simulation.objects.OBJECTS`, or of a folder of meshes.
    target_height : float
        Height in metres of the point at which all cameras look.
    reference : Camera
        Takes the reference, with neither robots nor obstacles present.
    robots : tuple of Robot
        Robot k (from 1) and its camera are called ``robot-k``.
    obstacles : tuple of Obstacle
        What may hide the object.
    overhead : Camera
        Looks at the whole scene from above.
    surroundings : str
        A name of `convexperc.simulation.surroundings.SURROUNDINGS`.
    turn : float
        Rotation of the surroundings about the object in degrees, anticlockwise from above.
    light : Light
        The light.
    seed : int
        Seed of the cameras' noise, not negative.
    mesh_sha256 : str
        Hash of the object's folder of meshes; empty for an object of the package.

    Raises
    ------
    InputError
        A value is out of range, or there are no such surroundings.
    """

    name: str
    object: str
    target_height: float
    reference: Camera
    robots: tuple[Robot, ...]
    obstacles: tuple[Obstacle, ...] = ()
    overhead: Camera = OVERHEAD
    surroundings: str = "park"
    turn: float = 0.0
    light: Light = BRIGHT
    seed: int = 0
    mesh_sha256: str = ""

    def __post_init__(self) -> None:
        check_name("scene", self.name)
        check_name("object", self.object)
        check_range("target_height", self.target_height, 0.0, 40.0)
        _check_choice("surroundings", self.surroundings, tuple(SURROUNDINGS))
        check_range("turn", self.turn, -360.0, 360.0)
        check_range("seed", self.seed, 0, 2**63 - 1)

    def cameras(self) -> dict[str, Camera]:
        """Return every camera by name: ``reference``, ``overhead``, ``robot-1``, ``robot-2``, ..."""
        return {"reference": self.reference, "overhead": self.overhead, **self.views()}

    def views(self) -> dict[str, Camera]:
        """Return the robots' cameras by name: ``robot-1``, ``robot-2``, ..."""
        return {f"robot-{k}": robot.camera for k, robot in enumerate(self.robots, start=1)}
