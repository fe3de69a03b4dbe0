from .enclosure import Enclosure, certify_in_balls, enclose, finite_start
from .witness import Witnesses, witnesses

__all__ = [
    "Enclosure",
    "Witnesses",
    "certify_in_balls",
    "enclose",
    "finite_start",
    "witnesses",
]
