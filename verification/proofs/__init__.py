"""Written proofs of claims: algebraic steps that a machine checked, cited theorems, and named joints."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
