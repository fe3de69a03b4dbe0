"""The park: a paved square among trees and halls."""

from collections.abc import Iterator
from math import cos, pi, radians, sin

from convexperc.simulation.parts import Part, blob, box, disc

PAVED_SIDE = 34.0
"""Side of the paved square around the object, in metres."""


def park() -> Iterator[Part]:
    """Yield the surroundings: a paved square with a kerb, trees around it, three halls and hills far away."""
    yield box("paving", (PAVED_SIDE, PAVED_SIDE, 0.1), (0.0, 0.0, -0.05))
    half = PAVED_SIDE / 2
    for side in (-half, half):
        yield box("concrete", (0.3, PAVED_SIDE + 0.3, 0.16), (side, 0.0, 0.08))
        yield box("concrete", (PAVED_SIDE + 0.3, 0.3, 0.16), (0.0, side, 0.08))
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
