from .families import DEGENERATE, EXTREME, FAMILIES, RANDOM, SUMMARIES, seeded
from .sources import Seeded, Source
from .strategies import degenerate_problems, problems, random_problems

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
