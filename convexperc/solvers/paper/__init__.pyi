from .loop import run
from .readings import Reading
from .trace import PaperTrace

__all__ = [
    "PaperTrace",
    "Reading",
    "run",
]
