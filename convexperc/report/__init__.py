"""Records, proof files, tables and the figure of what was found."""

from convexperc.faces import attach

__getattr__, __dir__, __all__ = attach(__name__)
