"""X, o, the modalities and the lambdas; F; exact scaling; what all templates of one set of views share."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
