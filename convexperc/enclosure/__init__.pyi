from .budget import Budget
from .enclosure import NARROW, certify_in_balls, enclose, enclosed, finite_start
from .result import Enclosure
from .witness import Witnesses, witnesses

__all__ = [
    "NARROW",
    "Budget",
    "Enclosure",
    "Witnesses",
    "certify_in_balls",
    "enclose",
    "enclosed",
    "finite_start",
    "witnesses",
]
