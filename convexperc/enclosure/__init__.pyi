from .budget import Budget
from .enclosure import certify_in_balls, enclose
from .result import Enclosure
from .witness import Witnesses, witnesses

__all__ = [
    "Budget",
    "Enclosure",
    "Witnesses",
    "certify_in_balls",
    "enclose",
    "witnesses",
]
