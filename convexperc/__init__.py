"""Convex multi-robot perception: certified recognition of an object from several robots' views.

The names below load their modules on first use, so that ``import convexperc`` costs nothing.
"""

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from convexperc.answers import Answers
    from convexperc.certificate import Certificate, certify
    from convexperc.critical import critical_lambda2, critical_lambda3
    from convexperc.enclosure import Enclosure, enclose
    from convexperc.errors import ConvexpercError
    from convexperc.features import FeatureConfiguration, extract
    from convexperc.many import solve_many, solve_path
    from convexperc.modalities import Modalities
    from convexperc.optimality import optimality_residual
    from convexperc.perception import References, perceive
    from convexperc.problem import Problem
    from convexperc.recognition import Recognition, Verdict
    from convexperc.recognizing import decided_by, recognize, recognize_path
    from convexperc.solution import Solution, Status
    from convexperc.solvers.conic import Conic
    from convexperc.solvers.newton import Newton
    from convexperc.solvers.qp import Quadratic
    from convexperc.solving import solve
    from convexperc.weights import WeightIntervals, weight_intervals

__version__ = "0.1.0"

_HOMES = {
    "Answers": "answers",
    "Certificate": "certificate",
    "Conic": "solvers.conic",
    "ConvexpercError": "errors",
    "Enclosure": "enclosure",
    "FeatureConfiguration": "features",
    "Modalities": "modalities",
    "Newton": "solvers.newton",
    "Problem": "problem",
    "Quadratic": "solvers.qp",
    "Recognition": "recognition",
    "References": "perception",
    "Solution": "solution",
    "Status": "solution",
    "Verdict": "recognition",
    "WeightIntervals": "weights",
    "certify": "certificate",
    "critical_lambda2": "critical",
    "critical_lambda3": "critical",
    "decided_by": "recognizing",
    "enclose": "enclosure",
    "extract": "features",
    "optimality_residual": "optimality",
    "perceive": "perception",
    "recognize": "recognizing",
    "recognize_path": "recognizing",
    "solve": "solving",
    "solve_many": "many",
    "solve_path": "many",
    "weight_intervals": "weights",
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
