"""Validation shared by the parts of a description: ranges of numbers, and names usable as file names."""

import re

from convexperc.errors import InputError

NAME = re.compile(r"[a-z0-9]+(-[a-z0-9]+)*")
"""Names that every file system can hold."""


def check_range(name: str, value: float | int, low: float | int, high: float | int) -> None:
    """Raise unless `value` is a number in [low, high]; NaN is refused.

    Raises
    ------
    InputError
        It is not.
    """
    if not low <= value <= high:
        raise InputError(name, value=value, must=f"must lie in [{low:g}, {high:g}]")


def check_name(name: str, value: str) -> None:
    """Raise unless `value` is a name in lower case with single hyphens, 64 characters at most.

    Raises
    ------
    InputError
        It is not.
    """
    if len(value) > 64 or not NAME.fullmatch(value):
        must = "must be letters a-z and digits, joined by single hyphens, at most 64"
        raise InputError(name, value=value, must=must, remedy="It becomes the name of a file or folder.")
