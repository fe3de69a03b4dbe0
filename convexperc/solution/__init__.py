"""Answers with their proof: one template, all templates of a set of views, intervals of the weights."""

from convexperc.faces import attach

__getattr__, __dir__, __all__ = attach(__name__)
