from .answers import Answers, Stages
from .batch import solve_many, solve_path
from .single import solve
from .solution import Solution, Status, Timings
from .weights import WeightIntervals, weight_intervals

__all__ = [
    "Answers",
    "Solution",
    "Stages",
    "Status",
    "Timings",
    "WeightIntervals",
    "solve",
    "solve_many",
    "solve_path",
    "weight_intervals",
]
