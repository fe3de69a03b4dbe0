"""Matplotlib without a backend: where it is missing, and where its variable names one that is."""

import importlib
import os
import sys
from contextlib import suppress

from convexperc.errors import require


def require_matplotlib() -> None:
    """Raise `MissingExtraError` if Matplotlib is not installed; it is not imported."""
    require("matplotlib", "plot", "the picture")


def load_matplotlib() -> None:
    """Import Matplotlib, also where ``MPLBACKEND`` names a backend that is not installed.

    A notebook sets that variable for what it starts, and Matplotlib cannot be imported then. No figure here
    needs a backend; one that is valid stays the caller's.
    """
    require_matplotlib()
    if "matplotlib" in sys.modules:
        return
    backend = os.environ.pop("MPLBACKEND", None)
    try:
        matplotlib = importlib.import_module("matplotlib")
    finally:
        if backend is not None:
            os.environ["MPLBACKEND"] = backend
    if backend:
        with suppress(ValueError):
            matplotlib.rcParams["backend"] = backend
