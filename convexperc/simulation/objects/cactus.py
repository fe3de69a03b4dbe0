"""A potted cactus."""

from collections.abc import Iterator
from math import cos, pi, sin

from convexperc.simulation.parts import Part, blob, rod
from convexperc.simulation.skins import swept, turned

RIBS = 10
"""Number of ribs of the trunk."""


def cactus() -> Iterator[Part]:
    """Yield a cactus with two arms along y, and a flower on top, in a pot; 0.4 m high."""
    yield turned("pot", [(0.06, 0.0), (0.06, 0.0), (0.082, 0.085), (0.082, 0.085), (0.07, 0.09)])
    rim = [(0.084, 0.085), (0.084, 0.085), (0.093, 0.087), (0.095, 0.12), (0.095, 0.12), (0.08, 0.122)]
    yield turned("pot", rim)
    yield turned("soil", [(0.081, 0.11), (0.081, 0.124)])
    trunk = [(0.035, 0.115), (0.043, 0.15), (0.05, 0.23), (0.046, 0.32), (0.03, 0.358), (0.0, 0.37)]
    yield turned("cactus", trunk)
    for k in range(RIBS):
        angle = 2 * pi * k / RIBS
        line = [(0.98 * r * cos(angle), 0.98 * r * sin(angle), z) for r, z in trunk[:-1]]
        yield swept("cactus-rib", [*line, (0.0, 0.0, 0.366)], 0.0065, steps=6)
    yield from _arm([(0.0, 0.04, 0.2), (0.0, 0.085, 0.205), (0.0, 0.108, 0.235), (0.0, 0.11, 0.31)], 0.026)
    yield from _arm([(0.0, -0.04, 0.23), (0.0, -0.08, 0.232), (0.0, -0.1, 0.26), (0.0, -0.102, 0.32)], 0.023)
    for k in range(5):
        x, y = 0.014 * cos(2 * pi * k / 5), 0.014 * sin(2 * pi * k / 5)
        yield blob("flower", (0.026, 0.026, 0.022), (x, y, 0.378))
    yield blob("duck", (0.016, 0.016, 0.02), (0.0, 0.0, 0.386))


def _arm(path: list[tuple[float, float, float]], radius: float) -> Iterator[Part]:
    """Yield an arm with a round end and spines in four rows along its upright part."""
    yield swept("cactus", path, radius, steps=20)
    x, y, z = path[-1]
    yield blob("cactus", (2 * radius, 2 * radius, 2 * radius), (x, y, z))
    for k in range(6):
        a, b = radius * cos(pi * k / 3), radius * sin(pi * k / 3)
        yield rod("cactus-rib", 0.005, (x + a, y + b, path[-2][2]), (x + a, y + b, z))
