"""The paper's algorithm in every variant, its faults kept and named."""

from convexperc.faces import attach

__getattr__, __dir__, __all__ = attach(__name__)
