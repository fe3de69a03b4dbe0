from .asserting import assert_conforms
from .doors import Command, Door, Function, Module, Reply, Results
from .judge import Finding, Level
from .profiles import FLOAT32, FLOAT64, PROFILES, Profile
from .request import Request
from .searching import Searched, search
from .suite import Report, Selection, run
from .vectors import Malformed, RecognitionSet, Vector, Vectors, all_vectors

__all__ = [
    "FLOAT32",
    "FLOAT64",
    "PROFILES",
    "Command",
    "Door",
    "Finding",
    "Function",
    "Level",
    "Malformed",
    "Module",
    "Profile",
    "RecognitionSet",
    "Reply",
    "Report",
    "Request",
    "Results",
    "Searched",
    "Selection",
    "Vector",
    "Vectors",
    "all_vectors",
    "assert_conforms",
    "run",
    "search",
]
