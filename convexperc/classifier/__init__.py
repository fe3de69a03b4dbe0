"""Recognition as a classifier of scikit-learn (extra ``sklearn``)."""

from convexperc.faces import attach

__getattr__, __dir__, __all__ = attach(__name__)
