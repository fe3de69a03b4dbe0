from .conic import Conic
from .interface import Solver, SolverResult
from .newton import Newton
from .osqp import Quadratic, is_quadratic

__all__ = [
    "Conic",
    "Newton",
    "Quadratic",
    "Solver",
    "SolverResult",
    "is_quadratic",
]
