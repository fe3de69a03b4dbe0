"""What is claimed, what is known of it, and the one rule between the two."""

from convexperc.faces import attach

__getattr__, __dir__, __all__ = attach(__name__)
