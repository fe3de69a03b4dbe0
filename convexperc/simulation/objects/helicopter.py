"""A toy helicopter."""

from collections.abc import Iterator
from math import cos, radians, sin

from convexperc.simulation.parts import Part, both_sides, box, disc, rod
from convexperc.simulation.pose import placed
from convexperc.simulation.skins import Station, rounded, swept

CABIN: tuple[Station, ...] = (
    (-0.14, 0.15, 0.0, 0.0), (-0.13, 0.15, 0.07, 0.07), (-0.05, 0.137, 0.14, 0.145),
    (0.04, 0.132, 0.165, 0.17), (0.12, 0.112, 0.135, 0.13), (0.165, 0.095, 0.075, 0.07),
    (0.18, 0.092, 0.0, 0.0),
)  # fmt: skip
"""Cross sections of the cabin, in metres."""
GLAZING: tuple[Station, ...] = (
    (0.02, 0.152, 0.0, 0.0), (0.025, 0.152, 0.12, 0.1), (0.06, 0.148, 0.165, 0.135),
    (0.12, 0.136, 0.158, 0.132), (0.175, 0.117, 0.1, 0.085), (0.192, 0.11, 0.0, 0.0),
)  # fmt: skip
"""Cross sections of the glazed nose, in metres."""
COWLING: tuple[Station, ...] = (
    (-0.12, 0.2, 0.0, 0.0), (-0.11, 0.2, 0.06, 0.03), (-0.01, 0.211, 0.09, 0.065), (0.06, 0.206, 0.055, 0.04),
    (0.08, 0.205, 0.0, 0.0),
)  # fmt: skip
"""Cross sections of the engine's cowling, in metres."""
BOOM: tuple[Station, ...] = (
    (-0.36, 0.172, 0.022, 0.024), (-0.2, 0.165, 0.034, 0.038), (-0.05, 0.15, 0.07, 0.075),
)  # fmt: skip
"""Cross sections of the tail boom, in metres."""


def helicopter() -> Iterator[Part]:
    """Yield a helicopter on skids, 0.55 m from nose to tail, its nose to +y and its right side to +x."""
    parts = [*_fuselage(), *_tail(), *_rotor((0.0, 0.03, 0.268)), *both_sides(list(_skid()))]
    yield from placed(parts, (0.0, 0.075, 0.0))


def _fuselage() -> Iterator[Part]:
    """Yield the cabin with its glazed nose, a window on each side and the engine's cowling."""
    yield rounded("toy-red", CABIN)
    yield rounded("pane", GLAZING)
    yield rounded("toy-white", COWLING)
    yield box("pane", (0.167, 0.06, 0.052), (0.0, 0.0, 0.152))
    yield box("toy-red", (0.169, 0.008, 0.052), (0.0, 0.0, 0.152))


def _tail() -> Iterator[Part]:
    """Yield the boom, the fins and the tail rotor."""
    yield rounded("toy-red", BOOM)
    yield swept("toy-white", [(0.0, -0.335, 0.165), (0.0, -0.355, 0.26)], (0.018, 0.012))
    yield box("toy-white", (0.008, 0.05, 0.1), (0.0, -0.35, 0.21), (18.0, 0.0, 0.0))
    yield box("toy-white", (0.15, 0.035, 0.006), (0.0, -0.29, 0.172))
    yield rod("steel", 0.004, (0.0, -0.355, 0.205), (0.022, -0.355, 0.205))
    for angle in (25.0, 115.0):
        yield box("rubber", (0.004, 0.13, 0.014), (0.022, -0.355, 0.205), (angle, 0.0, 0.0))


def _rotor(hub: tuple[float, float, float]) -> Iterator[Part]:
    """Yield the mast and four blades, two of which lie nearly along the body."""
    x, y, z = hub
    yield disc("steel", 0.008, 0.06, (x, y, z - 0.025), axis="z")
    yield disc("seam", 0.02, 0.016, hub, axis="z")
    for angle in (20.0, 110.0, 200.0, 290.0):
        blade = box("seam", (0.25, 0.026, 0.005), (0.135, 0.0, 0.003), (6.0, 2.0, 0.0))
        yield from placed([blade], hub, (0.0, 0.0, angle))


def _skid() -> Iterator[Part]:
    """Yield the right skid and its two struts."""
    x, radius = 0.085, 0.007
    toe = [
        (x, 0.15 + 0.045 * sin(radians(a)), radius + 0.045 * (1 - cos(radians(a)))) for a in (0.0, 30.0, 65.0)
    ]
    yield swept("steel", [(x, -0.1, radius), (x, 0.08, radius), *toe], radius, steps=10)
    for y in (-0.04, 0.09):
        yield rod("steel", 0.006, (x, y, radius), (0.035, y, 0.085))
