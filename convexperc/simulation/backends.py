"""Choice of the OpenGL backend for drawing without a display, before MuJoCo is imported."""

import ctypes.util
import os
from typing import Literal, get_args

from convexperc.errors import ConvexpercError

Backend = Literal["egl", "osmesa"]

LIBRARIES: dict[Backend, str] = {"egl": "EGL", "osmesa": "OSMesa"}
"""System library of each backend, in the order in which they are tried."""

# The remedy of an error, for people who draw.
INSTALL = (
    "On Debian or Ubuntu: apt-get install libegl1 libgl1-mesa-dri (EGL), or libosmesa6 (MUJOCO_GL=osmesa)."
)


class RenderingError(ConvexpercError, RuntimeError):
    """There is no OpenGL library, or it failed; the remedy names the package of the operating system."""


def choose_backend() -> Backend:
    """Return the backend that ``MUJOCO_GL`` asks for, or the first one whose library is installed.

    Returns
    -------
    {"egl", "osmesa"}
        EGL is tried first when ``MUJOCO_GL`` is unset or empty.

    Raises
    ------
    RenderingError
        ``MUJOCO_GL`` names something else, or no system library is found.
    """
    asked = os.environ.get("MUJOCO_GL", "").strip().lower()
    if asked and asked not in get_args(Backend):
        remedy = "Unset it, and EGL is tried first, then OSMesa."
        raise RenderingError("MUJOCO_GL", value=asked, must="must be egl, osmesa or unset", remedy=remedy)
    backends = [backend for backend in LIBRARIES if asked in ("", backend)]
    for backend in backends:
        if ctypes.util.find_library(LIBRARIES[backend]):
            return backend
    raise RenderingError(
        "the OpenGL library",
        value=backends,
        must="must be installed to draw without a display",
        remedy=INSTALL,
    )
