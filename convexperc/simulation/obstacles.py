"""Obstacles between a robot and the object.

Each builder yields an obstacle that stands on z = 0 and faces +x, given its full width and height in metres.
"""

from collections.abc import Callable, Iterator, Mapping
from math import atan2, ceil, degrees, hypot
from types import MappingProxyType
from typing import Literal

from convexperc.simulation.parts import Part, box, disc

ObstacleKind = Literal["crate", "barrel", "wall", "box", "board"]
"""Crates, barrels and walls stand in the park, cardboard boxes and boards in the lab."""


def crate(width: float, height: float) -> Iterator[Part]:
    """Yield planks inside a frame of beams, with a brace across each side."""
    beam = min(0.09, 0.2 * min(width, height))
    centre = (0.0, 0.0, height / 2)
    yield box("wood", (width - 0.44 * beam, width - 0.44 * beam, height - 0.44 * beam), centre)
    edge, between = width / 2 - beam / 2, width - 2 * beam
    for a in (-edge, edge):
        for b in (-edge, edge):
            yield box("beam", (beam, beam, height), (a, b, height / 2))
        for z in (beam / 2, height - beam / 2):
            yield box("beam", (beam, between, beam), (a, 0.0, z))
            yield box("beam", (between, beam, beam), (0.0, a, z))
    length = hypot(width - beam, height - beam)
    slope = degrees(atan2(height - beam, width - beam))
    yield box("beam", (width - 0.11 * beam, length, beam), centre, (slope, 0.0, 0.0))
    yield box("beam", (length, width - 0.11 * beam, beam), centre, (0.0, slope, 0.0))


def barrel(width: float, height: float) -> Iterator[Part]:
    """Yield a drum with four ribs and a light band."""
    centre = (0.0, 0.0, height / 2)
    rib = min(0.035, 0.05 * height)
    yield disc("drum", 0.95 * width / 2, height - 0.6 * rib, centre, axis="z")
    yield disc("drum-band", 0.965 * width / 2, height * 0.16, centre, axis="z")
    for share in (0.0, 1 / 3, 2 / 3, 1.0):
        yield disc("drum-rib", width / 2, rib, (0.0, 0.0, rib / 2 + share * (height - rib)), axis="z")


def wall(width: float, height: float) -> Iterator[Part]:
    """Yield a wall of bricks, 0.5 m x 0.2 m, on a concrete foot and under a coping."""
    foot, coping, brick, course, joint = min(0.12, height / 4), min(0.1, height / 4), 0.5, 0.2, 0.025
    top = height - coping
    yield box("brick", (0.25, width, top), (0.0, 0.0, top / 2))
    yield box("concrete", (0.3, width + 0.04, foot), (0.0, 0.0, foot / 2))
    yield box("concrete", (0.34, width + 0.1, coping), (0.0, 0.0, height - coping / 2))
    for row in range(max(0, ceil((top - foot) / course))):
        low = foot + row * course
        high = min(low + course, top)
        yield box("mortar", (0.256, width, joint), (0.0, 0.0, low))
        first = -width / 2 + (0.5 if row % 2 else 1.0) * brick
        for k in range(max(0, ceil((width / 2 - joint / 2 - first) / brick))):
            yield box("mortar", (0.256, joint, high - low), (0.0, first + k * brick, (low + high) / 2))


def cardboard_box(width: float, height: float) -> Iterator[Part]:
    """Yield a closed carton with a strip of tape, a label and arrows on two sides; it is as deep as wide."""
    sheet = 0.004
    yield box("carton", (width, width, height), (0.0, 0.0, height / 2))
    yield box("tape", (width + sheet, 0.14 * width, 0.2 * height), (0.0, 0.0, 0.9 * height))
    yield box("tape", (width + sheet, 0.14 * width, sheet), (0.0, 0.0, height))
    yield box("ink", (0.02 * width, width - 0.03 * width, sheet / 2), (0.0, 0.0, height))
    for side in (-1, 1):
        face = side * (width / 2 + sheet / 4)
        place = (0.0, face, 0.35 * height)
        yield box("paper", (0.42 * width, sheet / 2, 0.3 * height), place)
        yield box(
            "paper", (sheet / 2, 0.34 * width, 0.24 * height), (face, -side * 0.24 * width, 0.3 * height)
        )
        for y in (0.2, 0.34):
            yield box(
                "ink", (sheet / 2, 0.03 * width, 0.26 * height), (face, side * y * width, 0.32 * height)
            )
            tip = (face, side * y * width, 0.47 * height)
            yield box("ink", (sheet / 2, 0.07 * width, 0.05 * height), tip)


def board(width: float, height: float) -> Iterator[Part]:
    """Yield an upright sheet of plywood on two feet, framed by battens; it is 0.16 of its height deep."""
    sheet, batten, foot = 0.04 * height, 0.07 * min(width, height), 0.05 * height
    yield box("plywood", (sheet, width, height - foot), (0.0, 0.0, (height + foot) / 2))
    for z in (foot + batten / 2, height - batten / 2):
        yield box("plywood-edge", (1.5 * sheet, width - 2 * batten, batten), (0.0, 0.0, z))
    for y in (-0.5, 0.5):
        upright = (1.5 * sheet, batten, height - foot)
        yield box("plywood-edge", upright, (0.0, y * (width - batten), (height + foot) / 2))
        yield box("plywood-edge", (0.16 * height, batten, foot), (0.0, 0.7 * y * width, foot / 2))


OBSTACLES: Mapping[ObstacleKind, Callable[[float, float], Iterator[Part]]] = MappingProxyType(
    {"crate": crate, "barrel": barrel, "wall": wall, "box": cardboard_box, "board": board}
)
"""Every obstacle by its kind, as a function of its full width and height in metres."""
