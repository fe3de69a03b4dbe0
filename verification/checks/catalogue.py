"""All checks, by name."""

from verification.checks import descent, loop
from verification.checks.interface import Check

CHECKS: tuple[Check, ...] = (*descent.CHECKS, *loop.CHECKS)
