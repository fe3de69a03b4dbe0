"""A board on two posts that reads ICA."""

from collections.abc import Iterator
from math import cos, radians, sin

from convexperc.simulation.parts import Part, box


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
