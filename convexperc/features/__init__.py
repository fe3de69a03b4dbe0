"""Feature vectors of pictures: colour, shape, texture and what a network sees, one row for each view."""

from convexperc.faces import attach

__getattr__, __dir__, __all__ = attach(__name__)
