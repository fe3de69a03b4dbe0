"""Where the robots' pictures come from: files, videos, cameras, streams and bags, joined by their times."""

from convexperc.faces import attach

__getattr__, __dir__, __all__ = attach(__name__)
