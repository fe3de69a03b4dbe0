"""Drawing of scenes with MuJoCo, without a display.

MuJoCo is installed by the extra ``sim`` (``pip install 'convexperc[sim]'``). It needs an OpenGL library of
the operating system, which the environment variable ``MUJOCO_GL`` selects: ``egl`` or ``osmesa``. If it is
unset, EGL is used if its library is installed, otherwise OSMesa. Neither needs a graphics card. On Debian and
Ubuntu, ``apt-get install libegl1 libgl1-mesa-dri`` installs EGL and ``apt-get install libosmesa6`` OSMesa.
"""

from collections.abc import Collection
from dataclasses import dataclass
from types import TracebackType
from typing import Any, final

import cv2
import numpy as np
from jaxtyping import Bool, UInt8

from convexperc.errors import InputError
from convexperc.simulation.backends import INSTALL, RenderingError, choose_backend
from convexperc.simulation.catalogue import Catalogue
from convexperc.simulation.effects import Picture, apply_effects
from convexperc.simulation.image_size import ImageSize
from convexperc.simulation.mujoco_xml import Group, mjcf
from convexperc.simulation.objects import OBJECTS
from convexperc.simulation.opengl import failure, load_mujoco, window
from convexperc.simulation.scenes import Scene

Mask = UInt8[np.ndarray, "height width"]
"""255 where at least half of a pixel's samples show the object, else 0."""


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """A camera's picture of a scene, and where the object is in it.

    Attributes
    ----------
    picture : ndarray of uint8, (height, width, 3)
        Red, green, blue.
    mask : ndarray of uint8, (height, width)
        255 where the object is seen, else 0.
    visible_share : float
        Number of samples that show the object, divided by their number when it is alone, in [0, 1].
    """

    picture: Picture
    mask: Mask
    visible_share: float


@final
class SceneRenderer:
    """Draws one scene; a context manager that releases OpenGL's memory.

    Parameters
    ----------
    scene : Scene
        What to draw.
    largest : ImageSize
        Upper limit of the samples on each side of a picture.
    objects : mapping of str to Model or MeshModel
        The known objects by name.

    Raises
    ------
    InputError
        The scene's object is not known, or its meshes cannot be used.
    MissingExtraError
        MuJoCo is not installed.
    RenderingError
        There is no OpenGL library, or it failed.

    Examples
    --------
    >>> with SceneRenderer(RED_CAR, ImageSize(160, 120)) as renderer:  # doctest: +SKIP
    ...     view = renderer.view("robot-1", ImageSize(160, 120))
    """

    def __init__(self, scene: Scene, largest: ImageSize, objects: Catalogue = OBJECTS) -> None:
        document = mjcf(scene, objects)
        self.scene, self._cameras = scene, scene.cameras()
        self._mujoco = mujoco = load_mujoco()
        self._window = window()
        try:
            self._model = mujoco.MjModel.from_xml_string(document.xml, dict(document.assets))
        except ValueError as problem:
            must, remedy = "must be such that MuJoCo can load it", str(problem)
            raise InputError(f"object {scene.object}", value=scene.object, must=must, remedy=remedy) from None
        self._model.vis.global_.offwidth = largest.columns
        self._model.vis.global_.offheight = largest.rows
        self._data = mujoco.MjData(self._model)
        mujoco.mj_forward(self._model, self._data)
        self._drawn = mujoco.MjvScene(self._model, self._model.ngeom)
        self._object = np.flatnonzero(self._model.geom_group == Group.OBJECT)
        self._context = self._new_context(largest)

    def __enter__(self) -> "SceneRenderer":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Release OpenGL's memory; afterwards nothing can be drawn."""
        self._window.make_current()
        self._context.free()

    def picture(self, camera: str, size: ImageSize, groups: Collection[Group] = tuple(Group)) -> Picture:
        """Draw a camera's picture, with its effects.

        Parameters
        ----------
        camera : str
            A name from `Scene.cameras`.
        size : ImageSize
            Size of the picture.
        groups : collection of Group
            The groups to draw; all by default.

        Raises
        ------
        InputError
            The scene has no such camera.
        """
        self._update(camera, groups)
        for geometry in self._drawn.geoms[: self._drawn.ngeom]:
            if self._model.geom_group[geometry.objid] == Group.SURROUNDINGS:
                # MuJoCo draws no shadows of decoration; shadows take most of the time.
                geometry.category = self._mujoco.mjtCatBit.mjCAT_DECOR.value
        side = size.supersampling
        blocks = self._read(size).reshape(size.height, side, size.width, side, 3)
        return apply_effects(blocks.mean(axis=(1, 3)), self._cameras[camera], camera, self.scene.seed)

    def view(self, camera: str, size: ImageSize, groups: Collection[Group] = tuple(Group)) -> View:
        """Draw a camera's picture and the mask of the object.

        Parameters
        ----------
        camera, size, groups
            As for `picture`.

        Raises
        ------
        InputError
            The scene has no such camera.
        RenderingError
            The object lies outside of the picture even when it is alone.
        """
        seen = self._object_samples(camera, size, groups)
        side = size.supersampling
        count = seen.reshape(size.height, side, size.width, side).sum(axis=(1, 3))
        mask = np.where(2 * count >= side * side, np.uint8(255), np.uint8(0))
        share = int(seen.sum()) / self._alone(camera, size)
        return View(self.picture(camera, size, groups), mask, share)

    def visible_share(self, camera: str, size: ImageSize) -> float:
        """Return the number of samples that show the object, divided by their number when it is alone.

        Raises
        ------
        InputError
            The scene has no such camera.
        RenderingError
            The object lies outside of the picture even when it is alone.
        """
        return int(self._object_samples(camera, size, tuple(Group)).sum()) / self._alone(camera, size)

    def _alone(self, camera: str, size: ImageSize) -> int:
        """Count the samples that show the object when it is alone; at least one."""
        alone = int(self._object_samples(camera, size, (Group.OBJECT,)).sum())
        if alone == 0:
            must, remedy = "must contain a part of the object", "Change its pan, distance or height."
            raise RenderingError(f"the picture of {camera}", value=alone, must=must, remedy=remedy)
        return alone

    def _object_samples(
        self, camera: str, size: ImageSize, groups: Collection[Group]
    ) -> Bool[np.ndarray, "rows columns"]:
        """Return at which samples the foremost surface is the object's."""
        self._update(camera, groups)
        flags = [self._mujoco.mjtRndFlag.mjRND_SEGMENT, self._mujoco.mjtRndFlag.mjRND_IDCOLOR]
        for flag in flags:
            self._drawn.flags[flag] = True
        samples = self._read(size)
        for flag in flags:
            self._drawn.flags[flag] = False
        codes = samples.astype(np.int32) @ np.array([1, 1 << 8, 1 << 16], dtype=np.int32)
        of_object = np.zeros(self._drawn.ngeom + 1, dtype=np.bool_)
        for geometry in self._drawn.geoms[: self._drawn.ngeom]:
            of_object[geometry.segid + 1] = geometry.objid in self._object
        return of_object[codes]

    def _update(self, camera: str, groups: Collection[Group]) -> None:
        """Set what is drawn and the camera."""
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
        mujoco.mjv_updateScene(self._model, self._data, option, None, view, everything, self._drawn)

    def _read(self, size: ImageSize) -> UInt8[np.ndarray, "rows columns 3"]:
        """Draw the scene with all samples; rows from the top."""
        samples = np.empty((size.rows, size.columns, 3), dtype=np.uint8)
        self._window.make_current()
        area = self._mujoco.MjrRect(0, 0, size.columns, size.rows)
        self._mujoco.mjr_render(area, self._drawn, self._context)
        self._mujoco.mjr_readPixels(samples, None, area, self._context)
        return np.ascontiguousarray(samples[::-1])

    def _new_context(self, largest: ImageSize) -> Any:
        """Upload the model's meshes and textures to OpenGL."""
        mujoco = self._mujoco
        try:
            context = mujoco.MjrContext(self._model, mujoco.mjtFontScale.mjFONTSCALE_50.value)
        except mujoco.FatalError as problem:
            raise failure(choose_backend(), problem) from problem
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN.value, context)
        if context.offWidth < largest.columns or context.offHeight < largest.rows:
            context.free()
            must = f"must hold {largest.columns} x {largest.rows} samples"
            raise RenderingError("OpenGL's picture", value=None, must=must, remedy=INSTALL)
        return context


def png(picture: Picture | Mask) -> bytes:
    """Return a picture or a mask as a PNG file.

    Raises
    ------
    RenderingError
        It cannot be encoded.
    """
    pixels = picture if picture.ndim == 2 else cv2.cvtColor(picture, cv2.COLOR_RGB2BGR)
    done, data = cv2.imencode(".png", pixels, [cv2.IMWRITE_PNG_COMPRESSION, 6])
    if not done:
        raise RenderingError("picture", value=picture.shape, must="must be encodable as PNG")
    return data.tobytes()
