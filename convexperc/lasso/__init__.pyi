from .certificate import LassoCertificate
from .certifying import certify_lasso
from .conventions import CONVENTIONS, Convention
from .estimators import certify

__all__ = [
    "CONVENTIONS",
    "Convention",
    "LassoCertificate",
    "certify",
    "certify_lasso",
]
