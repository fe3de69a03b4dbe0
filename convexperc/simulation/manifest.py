"""The head of a manifest: everything that determines the files of a data set."""

from collections.abc import Iterable
from dataclasses import asdict
from typing import Any

import cv2

from convexperc.errors import InputError
from convexperc.simulation.catalogue import Catalogue, mesh_sha256
from convexperc.simulation.image_size import ImageSize
from convexperc.simulation.opengl import Engine

# Explains the numbers of a manifest to its readers.
UNITS = (
    "metres; degrees; azimuth anticlockwise from above, 0 where the reference is taken; a view is fully"
    " obstructed where at most 0.05 of the object is visible, not at all from 0.9 on"
)


def overhead_size(size: ImageSize) -> ImageSize:
    """Return the size of the overhead picture, twice that of the views."""
    return ImageSize(2 * size.width, 2 * size.height, size.supersampling)


def manifest_head(
    kind: str, seed: int, names: Iterable[str], size: ImageSize, engine: Engine, objects: Catalogue
) -> dict[str, Any]:
    """Return the head of a manifest, plain JSON values.

    Parameters
    ----------
    kind : str
        ``"physical"``, ``"case-study"`` or ``"scene"``.
    seed : int
        Seed of the random layouts.
    names : iterable of str
        The objects.
    size : ImageSize
        Size of the views.
    engine : Engine
        The versions that draw.
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
        "image": asdict(size),
        "overhead_image": asdict(overhead_size(size)),
        "units": UNITS,
        "objects": {name: mesh_sha256(objects[name]) for name in chosen},
    }
