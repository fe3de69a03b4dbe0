"""The places in which scenes are set."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from convexperc.simulation.lab import lab
from convexperc.simulation.park import park
from convexperc.simulation.parts import Part


@dataclass(frozen=True, slots=True)
class Surroundings:
    """What is around the object and the robots.

    Parameters
    ----------
    parts : tuple of Part
        What stands or lies there; the floor under the object has its upper face at z = 0.
    ground : str
        Material of the plane without end on which everything lies.
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
"""Every place by its name."""
