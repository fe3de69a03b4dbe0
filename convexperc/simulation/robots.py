"""The robots that carry the cameras."""

from collections.abc import Callable, Iterator, Mapping
from types import MappingProxyType

from convexperc.simulation.parts import Part, box, disc


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


ROBOTS: Mapping[str, Callable[[float], Iterator[Part]]] = MappingProxyType({"husky": husky})
"""Every robot by its name, as a function of the height of its lens in metres."""
