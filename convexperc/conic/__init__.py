"""A certified solver for CVXPY: a proved interval of the optimal value beside the answer of another."""

from convexperc.faces import attach

__getattr__, __dir__, __all__ = attach(__name__)
