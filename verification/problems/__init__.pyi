from .families import DEGENERATE, EXTREME, FAMILIES, RANDOM, seeded
from .sources import Seeded, Source
from .strategies import degenerate_problems, problems, random_problems
from .summaries import SUMMARIES

__all__ = [
    "DEGENERATE",
    "EXTREME",
    "FAMILIES",
    "RANDOM",
    "SUMMARIES",
    "Seeded",
    "Source",
    "degenerate_problems",
    "problems",
    "random_problems",
    "seeded",
]
