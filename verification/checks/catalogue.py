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
