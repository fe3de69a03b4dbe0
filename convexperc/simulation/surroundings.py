"""The surroundings of scenes."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from convexperc.simulation.lab import lab
from convexperc.simulation.park import park
from convexperc.simulation.parts import Part


@dataclass(frozen=True, slots=True)
class Surroundings:
    """The fixed parts around the object and the robots.

    Attributes
    ----------
    parts : tuple of Part
        The floor under the object has its upper face at z = 0.
    ground : str
        Material of the infinite plane below everything.
    ground_height : float
        Height of that plane in metres; it is at most 0.
    """

    parts: tuple[Part, ...]
    ground: str
    ground_height: float = 0.0


SURROUNDINGS: Mapping[str, Surroundings] = MappingProxyType(
    {
        "park": Surroundings(tuple(park()), "grass", ground_height=-0.03),
        "lab": Surroundings(tuple(lab()), "screed", ground_height=-0.1),
    }
)
"""All surroundings by name."""
