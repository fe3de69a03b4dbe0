"""The paper's experiments again: simulated scenes and photographs, paired comparisons."""

from convexperc.faces import attach

__getattr__, __dir__, __all__ = attach(__name__)
