"""Problems by family, from seeded numbers or from Hypothesis."""

from convexperc.faces import attach

__getattr__, __dir__, __all__ = attach(__name__)
