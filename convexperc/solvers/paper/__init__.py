"""The paper's algorithm in every variant, its faults kept and named."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
