"""Proximal Newton on the reduced problem."""

from convexperc.faces import attach

__getattr__, __dir__, __all__ = attach(__name__)
