"""Convex multi-robot perception: certified recognition of an object from several robots' views.

The names are loaded on first use, so that ``import convexperc`` costs nothing.
"""

from convexperc.faces import attach

__version__ = "0.1.0"
__getattr__, __dir__, __all__ = attach(__name__)
