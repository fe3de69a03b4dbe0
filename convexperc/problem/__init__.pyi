from .files import AnswerFile, ProblemFile, problem_record, read_answer, read_problem
from .formulation import Terms, objective, residuals, terms
from .library import TemplateLibrary
from .modalities import Modalities
from .optimality import OptimalityResidual, optimality_residual
from .penalties import Penalties
from .problem import Problem
from .reduced import ReducedData
from .reduction import Reduction
from .scaling import Scaling
from .views import Views

__all__ = [
    "AnswerFile",
    "Modalities",
    "OptimalityResidual",
    "Penalties",
    "Problem",
    "ProblemFile",
    "ReducedData",
    "Reduction",
    "Scaling",
    "TemplateLibrary",
    "Terms",
    "Views",
    "objective",
    "optimality_residual",
    "problem_record",
    "read_answer",
    "read_problem",
    "residuals",
    "terms",
]
