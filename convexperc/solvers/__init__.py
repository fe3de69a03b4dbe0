"""Solvers: a point for a normalised problem, and no proof."""

from convexperc.faces import attach

__getattr__, __dir__, __all__ = attach(__name__)
