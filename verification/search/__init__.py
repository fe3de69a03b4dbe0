"""The search: checks on problems that Hypothesis draws, in shards that can be resumed in any order."""

from convexperc.faces import attach

__getattr__, __dir__, __all__ = attach(__name__)
