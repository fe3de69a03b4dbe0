from .case import Case
from .cases import CASES

__all__ = [
    "CASES",
    "Case",
]
