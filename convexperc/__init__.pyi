from .certificate import (
    Certificate,
    Tolerances,
    certify,
    critical_lambda2,
    critical_lambda3,
    lambda2_max,
    lambda3_max,
)
from .enclosure import Enclosure, enclose
from .errors import ConvexpercError
from .features import FeatureConfiguration, extract
from .problem import Modalities, Penalties, Problem, TemplateLibrary, optimality_residual
from .recognition import (
    Recognition,
    References,
    Verdict,
    decided_by,
    perceive,
    recognize,
    recognize_path,
    warm,
)
from .solution import (
    Answers,
    Solution,
    Status,
    WeightIntervals,
    solve,
    solve_many,
    solve_path,
    weight_intervals,
)
from .solvers import Conic, Newton, Quadratic

__all__ = [
    "Answers",
    "Certificate",
    "Conic",
    "ConvexpercError",
    "Enclosure",
    "FeatureConfiguration",
    "Modalities",
    "Newton",
    "Penalties",
    "Problem",
    "Quadratic",
    "Recognition",
    "References",
    "Solution",
    "Status",
    "TemplateLibrary",
    "Tolerances",
    "Verdict",
    "WeightIntervals",
    "certify",
    "critical_lambda2",
    "critical_lambda3",
    "decided_by",
    "enclose",
    "extract",
    "lambda2_max",
    "lambda3_max",
    "optimality_residual",
    "perceive",
    "recognize",
    "recognize_path",
    "solve",
    "solve_many",
    "solve_path",
    "warm",
    "weight_intervals",
]
__version__: str
