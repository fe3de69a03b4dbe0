"""Counterexamples to the paper's claims: records in exact numbers, and what confirms each kind."""

from convexperc.faces import attach

__getattr__, __dir__, __all__ = attach(__name__)
