"""Types and shapes are checked while a test runs, by `beartype`: the first calls of each test.

A loop of a solver repeats the same few calls tens of thousands of times, and checking each of them took a
fifth of the suite.
"""

from collections.abc import Callable
from functools import wraps
from typing import Any

from beartype import beartype
from jaxtyping import config

MOST = 1_000
"""Checks, of arguments or of what is returned, in one test."""


class _Test:
    """The one that runs."""

    done = 0


def checked(function: Callable[..., Any]) -> Callable[..., Any]:
    """What `jaxtyping` checks a function by; see the option ``--jaxtyping-packages``."""
    check = beartype(function)

    @wraps(function)
    def counted(*args: Any, **options: Any) -> Any:
        _Test.done += 1
        if _Test.done == MOST:
            config.update("jaxtyping_disable", True)
        return check(*args, **options)

    return counted


def begin() -> None:
    """Check again, from the first call of a test on."""
    _Test.done = 0
    config.update("jaxtyping_disable", False)
