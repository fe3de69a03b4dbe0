"""A rubber duck."""

from collections.abc import Iterator

from convexperc.simulation.parts import Part, blob, both_sides
from convexperc.simulation.skins import Station, rounded, turned

BODY: tuple[Station, ...] = (
    (-0.125, 0.125, 0.0, 0.0), (-0.118, 0.12, 0.03, 0.022), (-0.09, 0.092, 0.1, 0.08),
    (-0.05, 0.064, 0.15, 0.122), (0.0, 0.058, 0.168, 0.116), (0.05, 0.06, 0.145, 0.112),
    (0.085, 0.062, 0.09, 0.078), (0.1, 0.062, 0.0, 0.0),
)  # fmt: skip
"""Cross sections from the raised tail to the breast, in metres."""


def rubber_duck() -> Iterator[Part]:
    """Yield a duck 0.24 m long that looks to +y, its right side to +x."""
    yield rounded("duck", BODY, steps=32, cuts=32)
    neck = [(0.05, 0.085), (0.048, 0.105), (0.043, 0.122), (0.044, 0.14), (0.0, 0.16)]
    yield turned("duck", neck, (0.0, 0.048, 0.0))
    yield blob("duck", (0.116, 0.12, 0.112), (0.0, 0.055, 0.176))
    yield blob("beak", (0.062, 0.07, 0.016), (0.0, 0.117, 0.168), (8.0, 0.0, 0.0))
    yield blob("beak", (0.05, 0.055, 0.014), (0.0, 0.11, 0.157), (-14.0, 0.0, 0.0))
    yield from both_sides(list(_side()))


def _side() -> Iterator[Part]:
    """Yield the right wing and the right eye."""
    yield blob("duck", (0.035, 0.11, 0.062), (0.074, -0.022, 0.078), (16.0, 0.0, 4.0))
    yield blob("duck", (0.025, 0.05, 0.035), (0.076, -0.07, 0.095), (30.0, 0.0, 8.0))
    yield blob("toy-white", (0.012, 0.026, 0.034), (0.047, 0.088, 0.192), (0.0, 0.0, 35.0))
    yield blob("lens", (0.01, 0.016, 0.022), (0.0505, 0.0925, 0.192), (0.0, 0.0, 35.0))
