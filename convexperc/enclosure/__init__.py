"""Bounds of F* in ball arithmetic, with as many bits as it takes, and exact witnesses of them."""

from convexperc.faces import attach

__getattr__, __dir__, __all__ = attach(__name__)
