"""The light of a scene: bright, dim or coloured."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from jaxtyping import Float

from convexperc.simulation.camera import place
from convexperc.simulation.checks import check_name, check_range
from convexperc.simulation.materials import Colour


@dataclass(frozen=True, slots=True)
class Light:
    """The light of a scene. Strengths are for red, green and blue; a white surface in light 1 is just white.

    Attributes
    ----------
    name : str
        Its name in a data set.
    ambient : tuple of float
        Light from all directions.
    fill : tuple of float
        Weak light from the camera's side, without shadows.
    sun : tuple of float
        Light of the sun outdoors and of the lamp indoors, which casts shadows.
    azimuth : float
        Direction from the object to the sun, in degrees, anticlockwise from above.
    elevation : float
        Height of the sun above the horizon, in degrees.
    sky : tuple of float
        Factors of the colours of the sky.

    Raises
    ------
    InputError
        A value is not finite or outside its range.
    """

    name: str
    ambient: Colour
    fill: Colour
    sun: Colour
    azimuth: float
    elevation: float
    sky: Colour

    def __post_init__(self) -> None:
        check_name("light", self.name)
        for name in ("ambient", "fill", "sun", "sky"):
            for strength in getattr(self, name):
                check_range(f"light's {name}", strength, 0.0, 2.0)
        check_range("light's azimuth", self.azimuth, -360.0, 360.0)
        check_range("light's elevation", self.elevation, 5.0, 90.0)

    def direction(self) -> Float[np.ndarray, "3"]:
        """Return the unit vector along which the sun shines, from the sun to the object."""
        upright = np.radians(self.elevation)
        return -place(self.azimuth, float(np.cos(upright)), float(np.sin(upright)))


BRIGHT = Light(
    name="bright",
    ambient=(0.41, 0.42, 0.44),
    fill=(0.3, 0.3, 0.3),
    sun=(0.62, 0.6, 0.56),
    azimuth=25.5,
    elevation=60.0,
    sky=(1.0, 1.0, 1.0),
)
"""Daylight."""
DIM = Light(
    name="dim",
    ambient=(0.18, 0.19, 0.21),
    fill=(0.13, 0.13, 0.14),
    sun=(0.26, 0.26, 0.26),
    azimuth=25.5,
    elevation=48.0,
    sky=(0.42, 0.44, 0.5),
)
"""About 0.43 of the light of `BRIGHT`."""
WARM = Light(
    name="warm",
    ambient=(0.44, 0.38, 0.3),
    fill=(0.28, 0.24, 0.19),
    sun=(0.72, 0.56, 0.37),
    azimuth=-50.0,
    elevation=38.0,
    sky=(1.0, 0.87, 0.72),
)
"""Reddish light."""
GREEN = Light(
    name="green",
    ambient=(0.33, 0.42, 0.34),
    fill=(0.22, 0.29, 0.23),
    sun=(0.46, 0.62, 0.48),
    azimuth=60.0,
    elevation=60.0,
    sky=(0.78, 1.0, 0.82),
)
"""Greenish light."""

LIGHTS: Mapping[str, Light] = MappingProxyType({light.name: light for light in (BRIGHT, DIM, WARM, GREEN)})
"""Every preset by its name."""
