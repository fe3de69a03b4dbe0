"""X, o, the modalities and the lambdas; F; exact scaling; what all templates of one set of views share."""

from convexperc.faces import attach

__getattr__, __dir__, __all__ = attach(__name__)
