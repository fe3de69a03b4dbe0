from .certificate import Certificate, certify
from .lambda_max import critical_lambda2, critical_lambda3, lambda2_max, lambda3_max, zero_is_optimal

__all__ = [
    "Certificate",
    "certify",
    "critical_lambda2",
    "critical_lambda3",
    "lambda2_max",
    "lambda3_max",
    "zero_is_optimal",
]
