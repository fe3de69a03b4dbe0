"""Draws a scene with MuJoCo, without a display. The only module that imports mujoco.

MuJoCo comes with the extra ``sim`` (``pip install "convexperc[sim]"``). It needs an OpenGL library of the
system, which the environment variable ``MUJOCO_GL`` may choose: ``egl`` or ``osmesa``. When it is unset,
EGL is taken if its library is installed, otherwise OSMesa. Neither needs a graphics card. On Debian and
Ubuntu, ``apt-get install libegl1 libgl1-mesa-dri`` installs EGL and ``apt-get install libosmesa6`` OSMesa.
"""

import importlib
import importlib.util
from collections.abc import Collection
from dataclasses import dataclass
from types import ModuleType, TracebackType
from typing import Any, final

import cv2
import numpy as np
from jaxtyping import Int, UInt8

from convexperc.errors import InputError, MissingExtraError
from convexperc.simulation.backends import INSTALL, Backend, RenderingError, choose_backend
from convexperc.simulation.mjcf import Group, mjcf
from convexperc.simulation.scenes import Scene

Picture = UInt8[np.ndarray, "height width 3"]
"""Rows from the top, columns from the left, channels red, green, blue."""


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


@final
class SceneRenderer:
    """Draws one scene; a context manager, because OpenGL's memory has to be given back.

    Parameters
    ----------
    scene : Scene
        What to draw.
    width, height : int
        Size of a picture, in pixels.
    supersampling : int
        Each pixel is the mean of a square of this many samples a side.

    Raises
    ------
    MissingExtraError
        MuJoCo is not installed.
    RenderingError
        There is no OpenGL library, or it failed.

    Examples
    --------
    >>> with SceneRenderer(RED_CAR, 192, 144) as renderer:  # doctest: +SKIP
    ...     picture = renderer.picture("robot-1")
    """

    def __init__(self, scene: Scene, width: int, height: int, supersampling: int = 3) -> None:
        for name, value in (("width", width), ("height", height), ("supersampling", supersampling)):
            if not 1 <= value <= 4096:
                raise InputError(name, value=value, must="must be a whole number in 1..4096")
        self.width, self.height, self.supersampling = width, height, supersampling
        self._cameras = list(scene.cameras())
        mujoco, self._backend, self._window = _start()
        self._mujoco = mujoco
        self._model = mujoco.MjModel.from_xml_string(mjcf(scene))
        self._model.vis.global_.offwidth = width * supersampling
        self._model.vis.global_.offheight = height * supersampling
        self._data = mujoco.MjData(self._model)
        mujoco.mj_forward(self._model, self._data)
        self._scene = mujoco.MjvScene(self._model, self._model.ngeom)
        try:
            self._context = mujoco.MjrContext(self._model, mujoco.mjtFontScale.mjFONTSCALE_100.value)
        except mujoco.FatalError as problem:
            self._window.free()
            raise _failure(self._backend, problem) from problem
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN.value, self._context)

    def __enter__(self) -> "SceneRenderer":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Give OpenGL's memory back; nothing can be drawn any more."""
        self._window.make_current()
        self._context.free()
        self._window.free()

    def engine(self) -> Engine:
        """Return the versions on which the pictures depend."""
        self._window.make_current()
        gl = importlib.import_module("OpenGL.GL")
        renderer, opengl = (gl.glGetString(name).decode() for name in (gl.GL_RENDERER, gl.GL_VERSION))
        return Engine(self._mujoco.mj_versionString(), self._backend, renderer, opengl)

    def picture(self, camera: str, groups: Collection[Group] = tuple(Group)) -> Picture:
        """Draw what a camera sees.

        Parameters
        ----------
        camera : str
            A name from `Scene.cameras`.
        groups : collection of Group
            What is present; everything by default.

        Returns
        -------
        ndarray of uint8, shape (height, width, 3)
            Red, green, blue; rows from the top.

        Raises
        ------
        InputError
            The scene has no such camera.
        """
        self._update(camera, groups)
        samples = self._read()
        picture = cv2.resize(samples, (self.width, self.height), interpolation=cv2.INTER_AREA)
        return np.asarray(picture, dtype=np.uint8)

    def visible_fraction(self, camera: str) -> float:
        """Measure how much of the object a camera sees, of what it would see were nothing in between.

        Parameters
        ----------
        camera : str
            A name from `Scene.cameras`.

        Returns
        -------
        float
            Samples that show the object, divided by those that show it when it is alone; in [0, 1].

        Raises
        ------
        InputError
            The scene has no such camera.
        RenderingError
            The object lies outside of the picture even when it is alone.
        """
        alone = self._object_samples(camera, (Group.OBJECT,))
        if alone == 0:
            raise RenderingError(
                f"the picture of {camera}", value=alone, must="must contain a part of the object"
            )
        return self._object_samples(camera, tuple(Group)) / alone

    def _object_samples(self, camera: str, groups: Collection[Group]) -> int:
        """Count the samples at which the foremost surface is the object's."""
        self._update(camera, groups)
        for flag in (self._mujoco.mjtRndFlag.mjRND_SEGMENT, self._mujoco.mjtRndFlag.mjRND_IDCOLOR):
            self._scene.flags[flag] = True
        codes = self._read().astype(np.int64) @ np.array([1, 1 << 8, 1 << 16])
        for flag in (self._mujoco.mjtRndFlag.mjRND_SEGMENT, self._mujoco.mjtRndFlag.mjRND_IDCOLOR):
            self._scene.flags[flag] = False
        return int(np.isin(codes, self._object_codes()).sum())

    def _object_codes(self) -> Int[np.ndarray, " geometries"]:
        """Colour codes of the object's geometries in a segmented picture: identifier plus one."""
        geometry = self._mujoco.mjtObj.mjOBJ_GEOM
        drawn = [g for g in self._scene.geoms[: self._scene.ngeom] if g.objtype == geometry]
        codes = [g.segid + 1 for g in drawn if self._model.geom_group[g.objid] == Group.OBJECT]
        return np.array(codes, dtype=np.int64)

    def _update(self, camera: str, groups: Collection[Group]) -> None:
        if camera not in self._cameras:
            raise InputError("camera", value=camera, must=f"must be one of {', '.join(self._cameras)}")
        mujoco = self._mujoco
        option = mujoco.MjvOption()
        option.geomgroup[:] = 0
        option.geomgroup[[int(group) for group in groups]] = 1
        view = mujoco.MjvCamera()
        view.type = mujoco.mjtCamera.mjCAMERA_FIXED
        view.fixedcamid = mujoco.mj_name2id(self._model, mujoco.mjtObj.mjOBJ_CAMERA, camera)
        everything = mujoco.mjtCatBit.mjCAT_ALL.value
        mujoco.mjv_updateScene(self._model, self._data, option, None, view, everything, self._scene)

    def _read(self) -> UInt8[np.ndarray, "rows columns 3"]:
        """Draw the scene at the full number of samples; rows from the top."""
        columns, rows = self.width * self.supersampling, self.height * self.supersampling
        samples = np.empty((rows, columns, 3), dtype=np.uint8)
        self._window.make_current()
        area = self._mujoco.MjrRect(0, 0, columns, rows)
        self._mujoco.mjr_render(area, self._scene, self._context)
        self._mujoco.mjr_readPixels(samples, None, area, self._context)
        return np.ascontiguousarray(samples[::-1])


def _start() -> tuple[ModuleType, Backend, Any]:
    """Import MuJoCo and make an OpenGL context without a display."""
    if importlib.util.find_spec("mujoco") is None:
        remedy = 'Install the extra sim: pip install "convexperc[sim]".'
        raise MissingExtraError("mujoco", value=None, must="must be installed to draw a scene", remedy=remedy)
    backend = choose_backend()
    try:
        mujoco = importlib.import_module("mujoco")
        window = importlib.import_module(f"mujoco.{backend}").GLContext(1, 1)
        window.make_current()
    except Exception as problem:
        raise _failure(backend, problem) from problem
    return mujoco, backend, window


def _failure(backend: Backend, problem: Exception) -> RenderingError:
    detail = f"{type(problem).__name__}: {problem}"
    return RenderingError(f"the OpenGL backend {backend}", value=detail, must="must start", remedy=INSTALL)
