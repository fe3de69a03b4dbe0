from .certified import Certified
from .proof import ConicInterval
from .reading import interval

__all__ = [
    "Certified",
    "ConicInterval",
    "interval",
]
