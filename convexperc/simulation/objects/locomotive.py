"""A toy steam locomotive."""

from collections.abc import Iterator

from convexperc.simulation.parts import Part, blob, both_sides, box, disc, rod
from convexperc.simulation.skins import hull, turned


def locomotive() -> Iterator[Part]:
    """Yield an engine 0.46 m long, its front to +y and its right side to +x."""
    yield box("engine-black", (0.12, 0.42, 0.024), (0.0, -0.01, 0.072))
    yield disc("engine-green", 0.052, 0.25, (0.0, 0.065, 0.142), axis="y")
    yield turned("engine-black", [(0.054, 0.185), (0.054, 0.212), (0.03, 0.22)], (0.0, 0.0, 0.142), axis="y")
    for y in (0.005, 0.09, 0.17):
        yield disc("brass", 0.0535, 0.008, (0.0, y, 0.142), axis="y")
    chimney = [(0.018, 0.185), (0.017, 0.235), (0.034, 0.262), (0.034, 0.262), (0.03, 0.275)]
    yield turned("engine-black", chimney, (0.0, 0.155, 0.0))
    yield turned("brass", [(0.024, 0.185), (0.024, 0.205), (0.016, 0.218), (0.0, 0.222)], (0.0, 0.05, 0.0))
    yield disc("lamp", 0.013, 0.016, (0.0, 0.222, 0.155), axis="y")
    yield from _cab()
    yield from _front()
    yield from both_sides(list(_side()))


def _cab() -> Iterator[Part]:
    """Yield the driver's cab with its windows and its roof."""
    yield box("engine-green", (0.13, 0.135, 0.075), (0.0, -0.13, 0.12))
    for x in (-0.06, 0.06):
        for y in (-0.192, -0.068):
            yield box("engine-green", (0.012, 0.012, 0.085), (x, y, 0.195))
    yield box("engine-green", (0.13, 0.012, 0.04), (0.0, -0.07, 0.17))
    yield box("pane", (0.116, 0.118, 0.075), (0.0, -0.13, 0.193))
    yield box("toy-red", (0.155, 0.175, 0.012), (0.0, -0.13, 0.243))
    yield box("toy-red", (0.11, 0.165, 0.01), (0.0, -0.13, 0.253))


def _front() -> Iterator[Part]:
    """Yield the buffer beam, the buffers and the cowcatcher."""
    yield box("toy-red", (0.14, 0.014, 0.036), (0.0, 0.203, 0.07))
    for x in (-0.045, 0.045):
        yield rod("engine-black", 0.006, (x, 0.2, 0.072), (x, 0.228, 0.072))
        yield disc("engine-black", 0.014, 0.006, (x, 0.23, 0.072), axis="y")
    low = [(-0.055, 0.2, 0.012), (0.055, 0.2, 0.012), (0.0, 0.245, 0.012)]
    yield hull("engine-black", [*low, (-0.035, 0.2, 0.055), (0.035, 0.2, 0.055)])


def _side() -> Iterator[Part]:
    """Yield the wheels and the rods on the right."""
    x = 0.052
    for y, radius in ((-0.15, 0.042), (-0.055, 0.042), (0.04, 0.042), (0.15, 0.028)):
        yield disc("engine-black", radius, 0.018, (x, y, radius))
        yield disc("toy-red", 0.82 * radius, 0.02, (x, y, radius))
        yield disc("engine-black", 0.3 * radius, 0.024, (x, y, radius))
    yield box("steel", (0.008, 0.2, 0.011), (x + 0.014, -0.055, 0.028))
    yield box("steel", (0.008, 0.13, 0.009), (x + 0.018, 0.09, 0.045), (8.0, 0.0, 0.0))
    yield disc("engine-black", 0.02, 0.06, (x + 0.002, 0.15, 0.065), axis="y")
    yield blob("brass", (0.012, 0.03, 0.03), (x + 0.012, -0.13, 0.12))
