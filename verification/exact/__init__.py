"""The method derived a second time, over the rationals and in balls, with no formula of the library."""

from convexperc.faces import attach

__getattr__, __dir__, __all__ = attach(__name__)
