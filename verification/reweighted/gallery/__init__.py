"""Reweighted loops of the literature in our words: objective, update as printed, what repairs it."""

from convexperc.faces import attach

__getattr__, __dir__, __all__ = attach(__name__)
