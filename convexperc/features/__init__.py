"""Feature vectors of pictures: colour, shape and texture, one row for each view."""

from convexperc.faces import attach

__getattr__, __dir__, __all__ = attach(__name__)
