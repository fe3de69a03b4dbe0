"""From pictures to recognition: references prepared once, then each set of views recognised against them."""

import json
import os
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import as_file, files
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float, UInt8

from convexperc.errors import ImageError, InputError
from convexperc.features import FeatureConfiguration
from convexperc.features.extraction import extract
from convexperc.features.pictures import list_images, read_image
from convexperc.recognition.decision import Decision
from convexperc.recognition.label import recognize
from convexperc.recognition.recognition import Recognition
from convexperc.solvers.interface import Solver

Named = Mapping[str, UInt8[np.ndarray, "_ _ 3"]]
"""Pictures by name, each of its own size."""


@dataclass(frozen=True, eq=False)
class References:
    """The known objects, one picture each, as columns of features.

    Attributes
    ----------
    names : tuple of str
        At least two, all different.
    O : float64 (d, k), read-only
        Column j describes the object ``names[j]``.
    configuration : FeatureConfiguration
        How `O` was made, and how the views will be described.
    """

    names: tuple[str, ...]
    O: Float[np.ndarray, "d k"]  # noqa: E741 - the paper's symbol
    configuration: FeatureConfiguration

    @classmethod
    def of(cls, pictures: Named, configuration: FeatureConfiguration) -> "References":
        """Describe each object's picture.

        Parameters
        ----------
        pictures : mapping of str to uint8 (h, w, 3)
            Each object's name and picture.
        configuration : FeatureConfiguration

        Raises
        ------
        InputError
            Fewer than two objects: the only one would be recognised in any view.
        """
        if len(pictures) < 2:
            must = "must show at least two objects"
            remedy = "With one there is nothing to tell it from: it would be recognised in any view."
            raise InputError("references", value=list(pictures), must=must, remedy=remedy)
        columns = extract(pictures.values(), configuration).T
        columns.flags.writeable = False
        return cls(tuple(pictures), columns, configuration)


@dataclass(frozen=True, eq=False)
class SampleScene:
    """One scene of the sample that the package carries.

    Attributes
    ----------
    name : str
        Also the name of the object that the views show.
    references, views : mapping of str to uint8 (h, w, 3)
        A picture of each object; a picture from each robot.
    """

    name: str
    references: Named
    views: Named


def read_pictures(folder: str | os.PathLike[str]) -> Named:
    """Read all pictures of a folder, sorted by file name; each is named by its stem.

    Raises
    ------
    ImageError
        The folder cannot be read or holds no picture, a picture is unsound, two files have the same stem,
        or a name holds characters that cannot be printed.
    """
    places: dict[str, Path] = {}
    for path in list_images(folder):
        if not path.stem.isprintable():
            must, remedy = "must have a printable name", "It is a label; rename the file."
            raise ImageError("picture", value=os.fspath(path), must=must, remedy=remedy)
        if path.stem in places:
            must = f"must not have the stem of {places[path.stem].name}: it is the name"
            raise ImageError(f"picture {path}", value=path.stem, must=must, remedy="Rename one of the two.")
        places[path.stem] = path
    return {name: read_image(path) for name, path in places.items()}


def perceive(
    views: Named,
    references: References,
    *,
    lambda1: float,
    lambda2: float,
    lambda3: float,
    solver: Solver | None = None,
    prune: bool = True,
    start: Recognition | None = None,
    decision: Decision | str = Decision.OBJECTIVE,
    progress: Callable[[str], None] | None = None,
) -> Recognition:
    """Recognise the object that the views show.

    Parameters
    ----------
    views : mapping of str to uint8 (h, w, 3)
        Each robot's name and picture; one view is enough.
    references : References
    lambda1, lambda2, lambda3, solver, prune, start, decision, progress
        See `recognize`.

    Returns
    -------
    Recognition

    Raises
    ------
    FeatureError
        No view at all.
    ProblemError, SolverError
        See `recognize`.
    """
    return recognize(
        extract(views.values(), references.configuration),
        references.O,
        names=references.names,
        lambda1=lambda1,
        lambda2=lambda2,
        lambda3=lambda3,
        modalities=references.configuration.modality_sizes,
        views=tuple(views),
        solver=solver,
        prune=prune,
        start=start,
        decision=decision,
        progress=progress,
    )


def sample_names() -> tuple[str, ...]:
    """Names of the sample's scenes."""
    return tuple(_sample())


def sample_scene(name: str) -> SampleScene:
    """Read one scene of the sample.

    Raises
    ------
    InputError
        There is no such scene.
    """
    scenes = _sample()
    if name not in scenes:
        raise InputError("scene", value=name, must=f"must be one of {', '.join(scenes)}")
    views = ((view["name"], view["file"]) for view in scenes[name]["views"])
    references = ((known["object"], known["file"]) for known in _manifest()["references"])
    return SampleScene(name, _pictures(references), _pictures(views))


def _sample() -> dict[str, dict[str, Any]]:
    """The sample's scenes by name."""
    return {scene["name"]: scene for scene in _manifest()["scenes"]}


@cache
def _manifest() -> dict[str, Any]:
    """What the sample says of itself."""
    record: dict[str, Any] = json.loads((_folder() / "manifest.json").read_text(encoding="utf-8"))
    return record


def _folder() -> Traversable:
    return files("convexperc").joinpath("sample")


def _pictures(named: Iterable[tuple[str, str]]) -> Named:
    pictures = {}
    for name, place in named:
        with as_file(_folder().joinpath(*place.split("/"))) as path:
            pictures[name] = read_image(path)
    return pictures
