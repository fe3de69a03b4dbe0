"""Everything in a scene that is not a car: the sign, the robots, the obstacles, the park around."""

from collections.abc import Iterator
from math import atan2, ceil, cos, degrees, hypot, pi, radians, sin
from typing import Literal

from convexperc.simulation.parts import Part, blob, box, disc

ObstacleKind = Literal["crate", "barrel", "wall"]

PAVED = 34.0
"""Side of the paved square around the object, in metres."""


def sign() -> Iterator[Part]:
    """Yield a board of 3.0 m x 1.5 m on two posts that reads ICA when seen from +x."""
    yield from (box("steel", (0.1, 0.12, 2.25), (-0.08, y, 1.125)) for y in (-1.05, 1.05))
    yield from (box("steel", (0.06, 2.6, 0.08), (-0.07, 0.0, z)) for z in (1.1, 1.9))
    yield box("steel", (0.02, 2.94, 1.44), (-0.03, 0.0, 1.5))
    yield box("navy", (0.06, 3.0, 1.5), (0.0, 0.0, 1.5))
    yield box("board", (0.06, 2.84, 1.34), (0.012, 0.0, 1.5))
    yield from _letters(x=0.05, middle=1.5)


def _letters(x: float, middle: float) -> Iterator[Part]:
    """Yield I, C and A as raised bars, 0.9 m high; y grows to the reader's right."""
    height, bar, depth = 0.9, 0.19, 0.04
    yield box("navy", (depth, bar, height), (x, -1.02, middle))
    radius, steps = (height - bar) / 2, 24
    for step in range(steps + 1):
        angle = 48.0 + 264.0 * step / steps
        y, z = radius * cos(radians(angle)), radius * sin(radians(angle))
        yield box("navy", (depth, bar, 0.1), (x, y - 0.2, middle + z), (angle, 0.0, 0.0))
    for side in (-1, 1):
        yield box(
            "navy", (depth, 0.18, 0.92), (x, 0.84 + 0.168 * side, middle - 0.01), (21.0 * side, 0.0, 0.0)
        )
    yield box("navy", (depth, 0.42, 0.15), (x, 0.84, middle - 0.16))
    yield box("navy", (depth, 0.22, 0.12), (x, 0.84, middle + height / 2 - 0.06))


def husky(camera_height: float) -> Iterator[Part]:
    """Yield a four-wheeled robot that looks to -x.

    Parameters
    ----------
    camera_height : float
        Height in metres of its lens, which is straight above the origin; a mast carries it.
    """
    middle = 0.3
    yield box("husky", (0.9, 0.4, 0.2), (middle, 0.0, 0.3))
    yield box("seam", (0.96, 0.44, 0.1), (middle, 0.0, 0.2))
    yield box("seam", (0.7, 0.56, 0.04), (middle, 0.0, 0.42))
    for x in (middle - 0.27, middle + 0.27):
        for y in (-0.27, 0.27):
            yield Part("cylinder", "rubber", (0.17, 0.06), (x, y, 0.17), (90.0, 0.0, 0.0))
            yield Part("cylinder", "husky", (0.07, 0.065), (x, y, 0.17), (90.0, 0.0, 0.0))
    mast = camera_height - 0.44
    yield disc("steel", 0.03, mast, (0.12, 0.0, 0.44 + mast / 2), axis="z")
    yield box("seam", (0.1, 0.2, 0.09), (0.12, 0.0, camera_height))


def obstacle(kind: ObstacleKind, width: float, height: float) -> Iterator[Part]:
    """Yield a crate, a barrel or a wall that stands on z = 0 and faces +x.

    Parameters
    ----------
    kind : {"crate", "barrel", "wall"}
        What to build.
    width, height : float
        Full extents in metres; a crate is as deep as wide, a wall is 0.25 m thick.
    """
    builders = {"crate": _crate, "barrel": _barrel, "wall": _wall}
    return builders[kind](width, height)


def _crate(width: float, height: float) -> Iterator[Part]:
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


def _barrel(width: float, height: float) -> Iterator[Part]:
    """Yield a drum with four ribs and a light band."""
    centre = (0.0, 0.0, height / 2)
    yield disc("drum", width / 2 - 0.015, height - 0.02, centre, axis="z")
    yield disc("drum-band", width / 2 - 0.01, height * 0.16, centre, axis="z")
    for share in (0.02, 0.34, 0.66, 0.98):
        yield disc("drum-rib", width / 2, 0.035, (0.0, 0.0, share * height), axis="z")


def _wall(width: float, height: float) -> Iterator[Part]:
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


def park() -> Iterator[Part]:
    """Yield the surroundings: a paved square with a kerb, trees around it, three halls and hills far away."""
    half = PAVED / 2
    for side in (-half, half):
        yield box("concrete", (0.3, PAVED + 0.3, 0.16), (side, 0.0, 0.08))
        yield box("concrete", (PAVED + 0.3, 0.3, 0.16), (0.0, side, 0.08))
    for k in range(22):
        angle, reach = 2 * pi * k / 22 + 0.1 * (k % 3), 25.0 + 2.5 * ((k * 7) % 5)
        yield from _tree(reach * cos(angle), reach * sin(angle), 0.8 + 0.12 * ((k * 5) % 4))
    yield from _hall(-46.0, -14.0, 12.0)
    yield from _hall(-30.0, 44.0, -40.0)
    yield from _hall(38.0, -34.0, 48.0)
    for k in range(9):
        angle = radians(40.0 * k + 7.0 * (k % 2))
        size = (50.0, 50.0, 9.0 + 3.0 * (k % 3))
        yield blob("hill", size, (88.0 * cos(angle), 88.0 * sin(angle), 0.0))


def _tree(x: float, y: float, scale: float) -> Iterator[Part]:
    yield disc("bark", 0.25 * scale, 2.4 * scale, (x, y, 1.2 * scale), axis="z")
    yield blob("leaf-dark", (4.4 * scale, 4.4 * scale, 3.6 * scale), (x, y, 3.4 * scale))
    yield blob("leaf", (3.4 * scale, 3.4 * scale, 3.0 * scale), (x + 0.4, y - 0.3, 4.6 * scale))


def _hall(x: float, y: float, turn: float) -> Iterator[Part]:
    """Yield a long hall with a flat roof and a band of windows."""
    for material, size, z in (
        ("plaster", (9.0, 22.0, 5.0), 2.5),
        ("glass", (9.1, 20.0, 1.0), 3.3),
        ("concrete", (9.6, 22.6, 0.4), 5.2),
    ):
        yield box(material, size, (x, y, z), (0.0, 0.0, turn))
