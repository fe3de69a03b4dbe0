"""Reweighted algorithms, judged against their own objective: terms, loops, and programs.

A reweighted loop replaces each norm or loss by a weighted square, minimises, and computes the weights anew.
What is proved of them in general is in docs/reweighted.md.
"""

from convexperc.faces import attach

__getattr__, __dir__, __all__ = attach(__name__)
