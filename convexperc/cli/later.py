"""Puts off an import until something of the module is asked for, so that ``--help`` answers at once."""

from importlib import import_module
from typing import Any


class Later:
    """A module of this package that is imported when something of it is first asked for.

    Parameters
    ----------
    name : str
        Its name below ``convexperc``.
    """

    def __init__(self, name: str) -> None:
        self._name = name

    def __getattr__(self, attribute: str) -> Any:
        return getattr(import_module(f"convexperc.{self._name}"), attribute)
