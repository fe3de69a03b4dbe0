"""Bounds of F* in float64, rounding included, at any point from anywhere; knows no solver."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
