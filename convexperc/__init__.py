"""Convex multi-robot perception: certified recognition of an object from several robots' views.

The names below load their modules on first use, so that ``import convexperc`` costs nothing.
"""

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from convexperc.certificate.certificate import Certificate, certify
    from convexperc.certificate.lambda_max import critical_lambda2, critical_lambda3
    from convexperc.enclosure.enclosure import Enclosure, enclose
    from convexperc.errors import ConvexpercError
    from convexperc.features import FeatureConfiguration, extract
    from convexperc.problem.modalities import Modalities
    from convexperc.problem.optimality import optimality_residual
    from convexperc.problem.problem import Problem
    from convexperc.recognition.label import decided_by, recognize, recognize_path
    from convexperc.recognition.recognition import Recognition, Verdict
    from convexperc.recognition.references import References, perceive
    from convexperc.solution.answers import Answers
    from convexperc.solution.batch import solve_many, solve_path
    from convexperc.solution.single import solve
    from convexperc.solution.solution import Solution, Status
    from convexperc.solution.weights import WeightIntervals, weight_intervals
    from convexperc.solvers.conic import Conic
    from convexperc.solvers.newton.method import Newton
    from convexperc.solvers.osqp import Quadratic

__version__ = "0.1.0"

_HOMES = {
    "Answers": "solution.answers",
    "Certificate": "certificate.certificate",
    "Conic": "solvers.conic",
    "ConvexpercError": "errors",
    "Enclosure": "enclosure.enclosure",
    "FeatureConfiguration": "features",
    "Modalities": "problem.modalities",
    "Newton": "solvers.newton.method",
    "Problem": "problem.problem",
    "Quadratic": "solvers.osqp",
    "Recognition": "recognition.recognition",
    "References": "recognition.references",
    "Solution": "solution.solution",
    "Status": "solution.solution",
    "Verdict": "recognition.recognition",
    "WeightIntervals": "solution.weights",
    "certify": "certificate.certificate",
    "critical_lambda2": "certificate.lambda_max",
    "critical_lambda3": "certificate.lambda_max",
    "decided_by": "recognition.label",
    "enclose": "enclosure.enclosure",
    "extract": "features",
    "optimality_residual": "problem.optimality",
    "perceive": "recognition.references",
    "recognize": "recognition.label",
    "recognize_path": "recognition.label",
    "solve": "solution.single",
    "solve_many": "solution.batch",
    "solve_path": "solution.batch",
    "weight_intervals": "solution.weights",
}

__all__ = [
    "Answers",
    "Certificate",
    "Conic",
    "ConvexpercError",
    "Enclosure",
    "FeatureConfiguration",
    "Modalities",
    "Newton",
    "Problem",
    "Quadratic",
    "Recognition",
    "References",
    "Solution",
    "Status",
    "Verdict",
    "WeightIntervals",
    "certify",
    "critical_lambda2",
    "critical_lambda3",
    "decided_by",
    "enclose",
    "extract",
    "optimality_residual",
    "perceive",
    "recognize",
    "recognize_path",
    "solve",
    "solve_many",
    "solve_path",
    "weight_intervals",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'convexperc' has no attribute {name!r}")
    return getattr(importlib.import_module(f"convexperc.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
