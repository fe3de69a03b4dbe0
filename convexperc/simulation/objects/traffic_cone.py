"""A traffic cone."""

from collections.abc import Iterator
from itertools import pairwise

from convexperc.simulation.parts import Part, box
from convexperc.simulation.skins import turned

HEIGHT = 0.36
"""Total height, in metres."""


def traffic_cone() -> Iterator[Part]:
    """Yield a cone with two white bands on a square foot."""
    foot, low, high, top = 0.022, 0.095, 0.022, HEIGHT
    yield box("cone-foot", (0.25, 0.25, foot), (0.0, 0.0, foot / 2))

    def radius(z: float) -> float:
        return low + (high - low) * (z - foot) / (top - foot)

    yield turned("cone", [(low + 0.012, foot), (low + 0.012, foot + 0.008), (low, foot + 0.012)])
    cuts = (foot, 0.115, 0.185, 0.245, 0.295, top)
    for k, (start, end) in enumerate(pairwise(cuts)):
        paint = "toy-white" if k % 2 else "cone"
        yield turned(paint, [(radius(start), start), (radius(end), end)])
