"""Counterexamples to the paper's claims: records in exact numbers, and what confirms each kind."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
