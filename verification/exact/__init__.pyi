from .algorithm import Update
from .balls import UnresolvedError
from .formulation import dual_objective, is_dual_feasible, objective
from .loop import Iterate, Rise, image, iterates, rise_confirmed, start, step
from .numbers import Enclosure
from .optimality import is_optimal, optimum_bounds
from .problem import ExactProblem
from .referee import Optimum, optimum, violations
from .reweighting import SingularStepError

__all__ = [
    "Enclosure",
    "ExactProblem",
    "Iterate",
    "Optimum",
    "Rise",
    "SingularStepError",
    "UnresolvedError",
    "Update",
    "dual_objective",
    "image",
    "is_dual_feasible",
    "is_optimal",
    "iterates",
    "objective",
    "optimum",
    "optimum_bounds",
    "rise_confirmed",
    "start",
    "step",
    "violations",
]
