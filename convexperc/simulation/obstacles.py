"""What may stand between a robot and the object.

Each builder yields a thing that stands on z = 0 and faces +x, given its full width and height in metres.
"""

from collections.abc import Callable, Iterator, Mapping
from math import atan2, ceil, degrees, hypot
from types import MappingProxyType
from typing import Literal

from convexperc.simulation.parts import Part, box, disc

ObstacleKind = Literal["crate", "barrel", "wall"]


def crate(width: float, height: float) -> Iterator[Part]:
    """Yield planks inside a frame of beams, with a brace across each side."""
    beam = 0.09
    centre = (0.0, 0.0, height / 2)
    yield box("wood", (width - 0.04, width - 0.04, height - 0.04), centre)
    edge = width / 2 - beam / 2
    for a in (-edge, edge):
        for b in (-edge, edge):
            yield box("beam", (beam, beam, height), (a, b, height / 2))
        for z in (beam / 2, height - beam / 2):
            yield box("beam", (beam, width, beam), (a, 0.0, z))
            yield box("beam", (width, beam, beam), (0.0, a, z))
    length = hypot(width - beam, height - beam)
    slope = degrees(atan2(height - beam, width - beam))
    yield box("beam", (width - 0.01, length, beam), centre, (slope, 0.0, 0.0))
    yield box("beam", (length, width - 0.01, beam), centre, (0.0, slope, 0.0))


def barrel(width: float, height: float) -> Iterator[Part]:
    """Yield a drum with four ribs and a light band."""
    centre = (0.0, 0.0, height / 2)
    yield disc("drum", width / 2 - 0.015, height - 0.02, centre, axis="z")
    yield disc("drum-band", width / 2 - 0.01, height * 0.16, centre, axis="z")
    for share in (0.02, 0.34, 0.66, 0.98):
        yield disc("drum-rib", width / 2, 0.035, (0.0, 0.0, share * height), axis="z")


def wall(width: float, height: float) -> Iterator[Part]:
    """Yield a wall of bricks, 0.5 m x 0.2 m, on a concrete foot and under a coping."""
    foot, coping, brick, course, joint = 0.12, 0.1, 0.5, 0.2, 0.025
    top = height - coping
    yield box("brick", (0.25, width, top), (0.0, 0.0, top / 2))
    yield box("concrete", (0.3, width + 0.04, foot), (0.0, 0.0, foot / 2))
    yield box("concrete", (0.34, width + 0.1, coping), (0.0, 0.0, height - coping / 2))
    for row in range(max(0, ceil((top - foot) / course))):
        low = foot + row * course
        high = min(low + course, top)
        yield box("mortar", (0.256, width, joint), (0.0, 0.0, low))
        first = -width / 2 + (0.5 if row % 2 else 1.0) * brick
        for k in range(int((width / 2 - first) / brick) + 1):
            yield box("mortar", (0.256, joint, high - low), (0.0, first + k * brick, (low + high) / 2))


OBSTACLES: Mapping[ObstacleKind, Callable[[float, float], Iterator[Part]]] = MappingProxyType(
    {"crate": crate, "barrel": barrel, "wall": wall}
)
"""Every obstacle by its kind, as a function of its full width and height in metres."""
