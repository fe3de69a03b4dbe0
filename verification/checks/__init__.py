"""Checks: one file a kind of claim, each a function from a problem to observations."""

from convexperc.faces import attach

__getattr__, __dir__, __all__ = attach(__name__)
