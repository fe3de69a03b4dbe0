"""One OpenGL context for each process, created at the first picture and kept: creating one takes 0.1 s."""

import importlib
from dataclasses import dataclass
from functools import cache
from types import ModuleType
from typing import Any

from convexperc.errors import require
from convexperc.simulation.backends import INSTALL, Backend, RenderingError, choose_backend


@dataclass(frozen=True, slots=True)
class Engine:
    """The versions that draw: if they are equal, so are all pixels.

    Attributes
    ----------
    mujoco : str
        Version of MuJoCo.
    backend : {"egl", "osmesa"}
        OpenGL without a display.
    renderer : str
        OpenGL's name of the renderer, for example ``"llvmpipe (LLVM 15.0.6, 256 bits)"``.
    opengl : str
        OpenGL's version with that of its driver.
    """

    mujoco: str
    backend: Backend
    renderer: str
    opengl: str


def load_mujoco() -> ModuleType:
    """Import MuJoCo, after the choice of the OpenGL backend.

    Raises
    ------
    MissingExtraError
        MuJoCo is not installed.
    RenderingError
        There is no OpenGL library, or MuJoCo cannot be loaded.
    """
    require("mujoco", "sim", "drawing a scene")
    backend = choose_backend()
    try:
        return importlib.import_module("mujoco")
    except Exception as problem:
        raise failure(backend, problem) from problem


def window() -> Any:
    """Make this process's OpenGL context current and return it.

    Raises
    ------
    MissingExtraError
        MuJoCo is not installed.
    RenderingError
        There is no OpenGL library, or it failed.
    """
    load_mujoco()
    backend = choose_backend()
    context = _context(backend)
    context.make_current()
    return context


@cache
def _context(backend: Backend) -> Any:
    try:
        return importlib.import_module(f"mujoco.{backend}").GLContext(1, 1)
    except Exception as problem:
        raise failure(backend, problem) from problem


def engine() -> Engine:
    """Return the versions on which the pictures depend.

    Raises
    ------
    MissingExtraError
        MuJoCo is not installed.
    RenderingError
        There is no OpenGL library, or it failed.
    """
    mujoco = load_mujoco()
    window()
    gl = importlib.import_module("OpenGL.GL")
    renderer, opengl = (gl.glGetString(name).decode() for name in (gl.GL_RENDERER, gl.GL_VERSION))
    return Engine(mujoco.mj_versionString(), choose_backend(), renderer, opengl)


def failure(backend: Backend, problem: Exception) -> RenderingError:
    """Return the error for a backend that does not work."""
    detail = f"{type(problem).__name__}: {problem}"
    return RenderingError(f"the OpenGL backend {backend}", value=detail, must="must start", remedy=INSTALL)
