"""One run of the verifier: everything that a judgement needs."""

from convexperc.faces import attach

__getattr__, __dir__, __all__ = attach(__name__)
