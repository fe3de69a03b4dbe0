from .certificate import Certificate, certify
from .lambda_max import critical_lambda2, critical_lambda3, lambda2_max, lambda3_max, zero_is_optimal
from .tolerances import Tolerances

__all__ = [
    "Certificate",
    "Tolerances",
    "certify",
    "critical_lambda2",
    "critical_lambda3",
    "lambda2_max",
    "lambda3_max",
    "zero_is_optimal",
]
