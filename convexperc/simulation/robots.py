"""The robots that carry the cameras."""

from collections.abc import Callable, Iterator, Mapping
from types import MappingProxyType

from convexperc.simulation.parts import Part, box, disc


def husky(lens_height: float) -> Iterator[Part]:
    """Yield a four-wheeled robot that looks to -x.

    Parameters
    ----------
    lens_height : float
        Height in metres of its lens, which is on a mast above the origin.
    """
    middle = 0.3
    yield box("husky", (0.9, 0.4, 0.2), (middle, 0.0, 0.3))
    yield box("seam", (0.96, 0.44, 0.1), (middle, 0.0, 0.2))
    yield box("seam", (0.7, 0.56, 0.04), (middle, 0.0, 0.42))
    for x in (middle - 0.27, middle + 0.27):
        for y in (-0.27, 0.27):
            yield Part("cylinder", "rubber", (0.17, 0.06), (x, y, 0.17), (90.0, 0.0, 0.0))
            yield Part("cylinder", "husky", (0.07, 0.065), (x, y, 0.17), (90.0, 0.0, 0.0))
    mast = lens_height - 0.44
    yield disc("steel", 0.03, mast, (0.12, 0.0, 0.44 + mast / 2), axis="z")
    yield box("seam", (0.1, 0.2, 0.09), (0.12, 0.0, lens_height))


def rover(lens_height: float) -> Iterator[Part]:
    """Yield a small four-wheeled robot with a board computer and a camera on a mast, which looks to -x.

    Parameters
    ----------
    lens_height : float
        Height in metres of its lens, which is above the origin; at least 0.11.
    """
    middle, wheel, deck = 0.08, 0.034, 0.075
    yield box("chassis", (0.22, 0.11, 0.006), (middle, 0.0, deck))
    yield box("chassis", (0.20, 0.10, 0.006), (middle, 0.0, 0.032))
    for x in (middle - 0.075, middle + 0.075):
        yield disc("steel", 0.005, deck - 0.03, (x * 0.9 + 0.008, 0.045, (deck + 0.03) / 2), axis="z")
        yield disc("steel", 0.005, deck - 0.03, (x * 0.9 + 0.008, -0.045, (deck + 0.03) / 2), axis="z")
        yield box("motor", (0.03, 0.1, 0.022), (x, 0.0, wheel + 0.012))
        for y in (-0.073, 0.073):
            yield disc("rubber", wheel, 0.028, (x, y, wheel), axis="y")
            yield disc("motor", 0.6 * wheel, 0.03, (x, y, wheel), axis="y")
            yield disc("seam", 0.2 * wheel, 0.033, (x, y, wheel), axis="y")
    yield from _electronics(middle, deck)
    yield box("chassis", (0.008, 0.04, lens_height - deck), (0.03, 0.0, (lens_height + deck) / 2))
    yield box("circuit", (0.006, 0.046, 0.036), (0.022, 0.0, lens_height))
    yield box("seam", (0.012, 0.026, 0.026), (0.014, 0.0, lens_height))
    yield disc("lens", 0.008, 0.008, (0.005, 0.0, lens_height), axis="x")


def _electronics(middle: float, deck: float) -> Iterator[Part]:
    """Yield the board computer with its sockets and the battery, on the deck and under it."""
    board = deck + 0.017
    yield box("circuit", (0.092, 0.062, 0.004), (middle + 0.03, 0.0, board))
    for x in (-0.04, 0.04):
        yield box("steel", (0.005, 0.05, 0.014), (middle + 0.03 + x, 0.0, deck + 0.009))
    for y in (-0.02, 0.003):
        yield box("chrome", (0.018, 0.017, 0.016), (middle + 0.067, y, board + 0.01))
    yield box("seam", (0.022, 0.018, 0.014), (middle + 0.067, 0.023, board + 0.009))
    yield box("seam", (0.02, 0.02, 0.006), (middle + 0.02, 0.0, board + 0.005))
    yield box("seam", (0.05, 0.006, 0.008), (middle + 0.02, -0.027, board + 0.006))
    yield box("book-blue", (0.08, 0.06, 0.022), (middle, 0.0, 0.047))


ROBOTS: Mapping[str, Callable[[float], Iterator[Part]]] = MappingProxyType({"husky": husky, "rover": rover})
"""Every robot by its name, as a function of the height of its lens in metres."""
