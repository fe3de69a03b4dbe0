"""Arguments for the claims, step by step, each step checked by a machine or cited."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
