"""From answers to a label that is proved or not claimed."""

from convexperc.faces import attach

__getattr__, __dir__, __all__ = attach(__name__)
