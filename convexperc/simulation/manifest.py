"""The head of a manifest: everything on which a data set's bytes depend."""

from collections.abc import Iterable
from dataclasses import asdict
from typing import Any

import cv2

from convexperc.errors import InputError
from convexperc.simulation.catalogue import Catalogue, mesh_sha256
from convexperc.simulation.image_size import ImageSize
from convexperc.simulation.opengl import Engine

UNITS = (
    "metres; degrees; azimuth anticlockwise from above, 0 where the reference is taken; a view is fully"
    " obstructed where at most 0.05 of the object is visible, not at all from 0.9 on"
)


def overhead_frame(frame: ImageSize) -> ImageSize:
    """Return the size of the overhead picture that goes with views of size `frame`."""
    return ImageSize(2 * frame.width, 2 * frame.height, frame.supersampling)


def manifest_head(
    kind: str, seed: int, names: Iterable[str], frame: ImageSize, engine: Engine, objects: Catalogue
) -> dict[str, Any]:
    """Return what a manifest begins with, plain JSON values.

    Parameters
    ----------
    kind : str
        ``"physical"``, ``"case-study"`` or ``"scene"``.
    seed : int
        Seed of what is random.
    names : iterable of str
        The objects.
    frame : ImageSize
        Size of the views.
    engine : Engine
        What draws.
    objects : mapping of str to Model or MeshModel
        The known objects by name.

    Raises
    ------
    InputError
        An object is not known.
    """
    chosen = list(names)
    unknown = [name for name in chosen if name not in objects]
    if unknown:
        must = f"must be among {', '.join(objects)}"
        remedy = "Give the folder of meshes that holds it, if it is not one of the package."
        raise InputError("objects", value=unknown, must=must, remedy=remedy)
    return {
        "format": 1,
        "set": kind,
        "seed": seed,
        "engine": asdict(engine),
        "opencv": cv2.__version__,
        "image": asdict(frame),
        "overhead_image": asdict(overhead_frame(frame)),
        "units": UNITS,
        "objects": {name: mesh_sha256(objects[name]) for name in chosen},
    }
