"""Certificates for the lasso family: proved bounds for an answer from any package."""

from convexperc.faces import attach

__getattr__, __dir__, __all__ = attach(__name__)
