"""A wooden chair."""

from collections.abc import Iterator

from convexperc.simulation.parts import Part, box, rod
from convexperc.simulation.pose import placed
from convexperc.simulation.skins import swept


def chair() -> Iterator[Part]:
    """Yield a doll's chair, 0.46 m high; its front is turned 40 degrees from +x."""
    yield from placed(_chair(), rotation=(0.0, 0.0, 40.0))


def _chair() -> Iterator[Part]:
    """Yield the chair with its front to +x: seat, legs with rungs, a back of rails and spindles."""
    half, seat = 0.1, 0.215
    yield box("chair-seat", (0.245, 0.245, 0.024), (0.0, 0.0, seat))
    for y in (-half, half):
        yield rod("chair", 0.013, (half + 0.01, 1.1 * y, 0.001), (half - 0.005, y, seat - 0.01))
        upright = [(-half - 0.02, 1.05 * y, 0.002), (-half, y, seat), (-half - 0.04, y, 0.45)]
        yield swept("chair", upright, 0.013)
        yield rod("chair", 0.008, (half, 1.05 * y, 0.09), (-half - 0.01, 1.02 * y, 0.09))
        yield rod("chair", 0.008, (half, 1.05 * y, 0.15), (-half - 0.01, 1.02 * y, 0.15))
    for x, z in ((half + 0.005, 0.115), (-half - 0.015, 0.07)):
        yield rod("chair", 0.008, (x, -half, z), (x, half, z))
    yield box("chair", (0.018, 0.235, 0.055), (-half - 0.036, 0.0, 0.43), (0.0, -9.0, 0.0))
    yield box("chair", (0.016, 0.2, 0.025), (-half - 0.012, 0.0, 0.285), (0.0, -9.0, 0.0))
    for y in (-0.05, 0.0, 0.05):
        yield rod("chair", 0.006, (-half - 0.012, y, 0.285), (-half - 0.034, y, 0.42))
