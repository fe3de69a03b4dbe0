from .certificate import LassoCertificate
from .certifying import certify_lasso
from .conventions import CONVENTIONS, Convention

__all__ = [
    "CONVENTIONS",
    "Convention",
    "LassoCertificate",
    "certify_lasso",
]
