"""Bounds of F* in float64, rounding included, at any point from anywhere; knows no solver."""

from convexperc.faces import attach

__getattr__, __dir__, __all__ = attach(__name__)
