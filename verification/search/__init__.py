"""The search: checks on problems that Hypothesis draws, in shards that can be resumed in any order."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
