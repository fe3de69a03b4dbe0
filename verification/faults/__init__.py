"""Faults to plant on purpose: a verifier is worth what it catches."""

from convexperc.faces import attach

__getattr__, __dir__, __all__ = attach(__name__)
