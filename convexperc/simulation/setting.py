"""What the scenes of one data set have in common: surroundings, robots, obstacles and distances."""

import math
from dataclasses import dataclass

from convexperc.simulation.obstacles import ObstacleKind
from convexperc.simulation.scenes import RobotKind

ASPECT = 4 / 3
"""Width of a picture divided by its height, for which distances are chosen: that of 160 x 120 pixels."""


@dataclass(frozen=True, slots=True)
class Setting:
    """Surroundings, robots and obstacles of the scenes of a data set.

    Attributes
    ----------
    surroundings : str
        A name of `convexperc.simulation.surroundings.SURROUNDINGS`.
    robot : {"husky", "rover"}
        Kind of every robot.
    robot_reach : float
        Radius in metres of the circle about the lens that contains the robot.
    lens : tuple of float
        Lowest and highest lens, in metres.
    field_of_view : float
        Vertical angle of view of every camera, in degrees.
    noise : float
        Standard deviation of every camera's noise, in gray levels.
    distances : tuple of float
        Least and greatest distance in metres from which a reference is taken.
    fill : float
        Fraction of the picture's height or width that the object fills in its reference.
    solid, flat : str
        Kinds of obstacles: as deep as wide, and thin.
    widest : float
        Greatest width in metres of a solid obstacle.
    thickness : float
        Depth in metres reserved for a flat obstacle.
    margin : float
        Least distance in metres between things.
    yard : tuple of float
        Least and greatest distance from the object in metres of obstacles that hide nothing.
    overhead : tuple of float
        Distance and height in metres of the overhead camera.
    """

    surroundings: str
    robot: RobotKind
    robot_reach: float
    lens: tuple[float, float]
    field_of_view: float
    noise: float
    distances: tuple[float, float]
    fill: float
    solid: ObstacleKind
    flat: ObstacleKind
    widest: float
    thickness: float
    margin: float
    yard: tuple[float, float]
    overhead: tuple[float, float]

    def distance_of(self, radius: float, height: float) -> float:
        """Return the distance in metres at which an object of a radius and height in metres fills `fill`."""
        slope = math.tan(math.radians(self.field_of_view / 2))
        wanted = max(height / 2, radius / ASPECT) / (slope * self.fill)
        return min(max(wanted, self.distances[0]), self.distances[1])


LAB = Setting(
    surroundings="lab",
    robot="rover",
    robot_reach=0.2,
    lens=(0.14, 0.3),
    field_of_view=32.0,
    noise=1.5,
    distances=(0.7, 1.35),
    fill=0.72,
    solid="box",
    flat="board",
    widest=0.4,
    thickness=0.08,
    margin=0.03,
    yard=(1.45, 1.9),
    overhead=(1.9, 4.1),
)
"""Small rovers around an object on the floor of a lab."""

PARK = Setting(
    surroundings="park",
    robot="husky",
    robot_reach=0.9,
    lens=(0.8, 1.25),
    field_of_view=36.0,
    noise=0.0,
    distances=(5.5, 8.0),
    fill=0.8,
    solid="crate",
    flat="wall",
    widest=1.5,
    thickness=0.35,
    margin=0.2,
    yard=(9.5, 12.0),
    overhead=(15.0, 21.0),
)
"""Huskies around an object as large as a car in a park."""
