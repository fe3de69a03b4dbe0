"""The conformance kit: anyone's solver, asked and judged by proved optima."""

from convexperc.faces import attach

__getattr__, __dir__, __all__ = attach(__name__)
