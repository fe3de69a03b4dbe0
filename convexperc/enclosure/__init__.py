"""Bounds of F* in ball arithmetic, with as many bits as it takes, and exact witnesses of them."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
