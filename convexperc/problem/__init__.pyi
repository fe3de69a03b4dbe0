from .files import AnswerFile, ProblemFile, problem_record, read_answer, read_problem
from .formulation import Terms, objective, residuals, terms
from .gram import Reduction
from .library import Projection
from .modalities import Modalities
from .optimality import OptimalityResidual, optimality_residual
from .problem import Problem
from .scaling import Scaling

__all__ = [
    "AnswerFile",
    "Modalities",
    "OptimalityResidual",
    "Problem",
    "ProblemFile",
    "Projection",
    "Reduction",
    "Scaling",
    "Terms",
    "objective",
    "optimality_residual",
    "problem_record",
    "read_answer",
    "read_problem",
    "residuals",
    "terms",
]
