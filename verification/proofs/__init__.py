"""Written proofs of claims: algebraic steps that a machine checked, cited theorems, and named joints."""

from convexperc.faces import attach

__getattr__, __dir__, __all__ = attach(__name__)
