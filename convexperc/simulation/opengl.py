"""One OpenGL context a process, made when something is first drawn and kept: making one takes 0.1 s."""

import importlib
from dataclasses import dataclass
from functools import cache
from types import ModuleType
from typing import Any

from convexperc.errors import require
from convexperc.simulation.backends import INSTALL, Backend, RenderingError, choose_backend


@dataclass(frozen=True, slots=True)
class Engine:
    """What draws: with the same MuJoCo, renderer and OpenGL, pictures are the same to the bit.

    Parameters
    ----------
    mujoco : str
        Version of MuJoCo.
    backend : {"egl", "osmesa"}
        How a picture without a display is obtained.
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
    """Import MuJoCo, after the way to OpenGL has been chosen.

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
    """Return this process's OpenGL context, which is made current.

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
