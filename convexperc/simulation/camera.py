"""A camera on a ring around the object: position, direction, and image quality.

The object stands at the origin of a floor; z points up. Azimuths are degrees, anticlockwise from above;
0 is the direction from which the reference is taken: the side of a car, the front of a sign.
"""

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from convexperc.simulation.checks import check_range


def place(azimuth: float, distance: float, height: float = 0.0) -> Float[np.ndarray, "3"]:
    """Return the point (3,) at an azimuth (degrees), a horizontal distance and a height (metres)."""
    angle = math.radians(azimuth)
    return np.array([distance * math.cos(angle), distance * math.sin(angle), height])


@dataclass(frozen=True, slots=True)
class Camera:
    """A camera that looks at the object.

    Attributes
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
        Angle between the camera's direction and the object, in degrees, anticlockwise from above.
    exposure : float
        Exposure in stops: the light is multiplied by 2^exposure.
    blur : float
        Standard deviation of a Gaussian blur, in pixels.
    noise : float
        Standard deviation of the sensor's noise, in gray levels of 255.

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
    exposure: float = 0.0
    blur: float = 0.0
    noise: float = 0.0

    def __post_init__(self) -> None:
        check_range("azimuth", self.azimuth, -360.0, 360.0)
        check_range("distance", self.distance, 0.2, 40.0)
        check_range("height", self.height, 0.02, 40.0)
        check_range("field_of_view", self.field_of_view, 1.0, 120.0)
        check_range("pan", self.pan, -90.0, 90.0)
        check_range("exposure", self.exposure, -8.0, 8.0)
        check_range("blur", self.blur, 0.0, 20.0)
        check_range("noise", self.noise, 0.0, 100.0)

    def position(self) -> Float[np.ndarray, "3"]:
        """Return the position (3,) of the lens, in metres."""
        return place(self.azimuth, self.distance, self.height)

    def axes(self, target_height: float) -> Float[np.ndarray, "2 3"]:
        """Return the picture's unit vectors to the right and upwards, as rows.

        Parameters
        ----------
        target_height : float
            Height in metres of the point above the origin at which the camera looks.
        """
        forward = place(self.azimuth + self.pan, -self.distance, target_height - self.height)
        forward /= np.linalg.norm(forward)
        right = np.cross(forward, [0.0, 0.0, 1.0])
        right /= np.linalg.norm(right)
        return np.stack([right, np.cross(right, forward)])

    def bearing(self) -> float:
        """Return the azimuth in (-180, 180], in degrees."""
        return 180.0 - (180.0 - self.azimuth) % 360.0
