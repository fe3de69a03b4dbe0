"""All checks, by name."""

from verification.checks import (
    agreement,
    certificates,
    clarabel,
    convexity,
    derivatives,
    descent,
    features,
    label,
    lemmas,
    loop,
    objective,
    scaling,
    zeros,
)
from verification.checks.interface import Check

TOPICS = (
    convexity,
    agreement,
    zeros,
    derivatives,
    lemmas,
    descent,
    loop,
    objective,
    scaling,
    certificates,
    label,
    features,
    clarabel,
)
CHECKS: tuple[Check, ...] = tuple(check for topic in TOPICS for check in topic.CHECKS)
FORMULAS = frozenset(part for check in CHECKS for part in check.parts if not check.product)
"""Parts whose counts are evaluations of a formula of the paper, and no cases of the code."""
