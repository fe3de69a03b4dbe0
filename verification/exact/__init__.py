"""The method derived a second time, over the rationals and in balls, with no formula of the library."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
