"""A desk lamp."""

from collections.abc import Iterator

from convexperc.simulation.parts import Part, blob, disc, rod
from convexperc.simulation.pose import placed
from convexperc.simulation.skins import turned


def desk_lamp() -> Iterator[Part]:
    """Yield a lamp on two jointed arms, 0.44 m high, its shade to +y."""
    foot, elbow, head = (0.0, -0.08, 0.03), (0.0, -0.15, 0.23), (0.0, 0.02, 0.4)
    yield turned("toy-red", [(0.085, 0.0), (0.085, 0.014), (0.07, 0.024), (0.02, 0.03)], (0.0, -0.08, 0.0))
    for x in (-0.012, 0.012):
        yield rod("steel", 0.005, (x, *foot[1:]), (x, *elbow[1:]))
        yield rod("steel", 0.005, (x, *elbow[1:]), (x, *head[1:]))
    for joint in (foot, elbow, head):
        yield disc("seam", 0.016, 0.04, joint)
    shade = [(0.0, 0.012), (0.03, 0.01), (0.068, -0.09), (0.072, -0.09), (0.072, -0.09), (0.036, 0.02)]
    shade += [(0.03, 0.03), (0.028, 0.055), (0.028, 0.055), (0.0, 0.058)]
    bulb = blob("lamp", (0.055, 0.055, 0.065), (0.0, 0.0, -0.045))
    tilted = [turned("toy-red", shade), bulb]
    yield from placed(tilted, (0.0, 0.055, 0.37), (32.0, 0.0, 0.0))
