"""Feature vectors of pictures: colour, shape and texture, one row for each view."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
