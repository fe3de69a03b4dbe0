"""From pictures to recognition: references prepared once, then each set of views recognised against them."""

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Unpack

import numpy as np
from jaxtyping import Float, UInt8

from convexperc.errors import ImageError, InputError
from convexperc.features.configuration import FeatureConfiguration
from convexperc.features.extraction import extract
from convexperc.features.pictures import list_images, read_image
from convexperc.features.recent import RecentFeatures
from convexperc.problem.library import TemplateLibrary
from convexperc.recognition.label import Options, recognize
from convexperc.recognition.recognition import Recognition

NamedPictures = Mapping[str, UInt8[np.ndarray, "_ _ 3"]]
"""Pictures by name, each of its own size."""


@dataclass(frozen=True, eq=False)
class References:
    """The known objects, one picture each, as columns of features.

    Attributes
    ----------
    library : TemplateLibrary
        At least two objects; column j of its O describes the object ``names[j]``.
    configuration : FeatureConfiguration
        How the library was made, and how the views will be described.
    recent : RecentFeatures
        The views of the last call of `perceive`: one whose pixels have not changed is not described again.
    """

    library: TemplateLibrary
    configuration: FeatureConfiguration
    recent: RecentFeatures = field(default_factory=RecentFeatures, repr=False)

    @classmethod
    def of(cls, pictures: NamedPictures, configuration: FeatureConfiguration) -> "References":
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
        sizes = configuration.modality_sizes
        library = TemplateLibrary.of(columns, names=tuple(pictures), modalities=sizes)
        return cls(library, configuration)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the objects, all different."""
        return self.library.names

    @property
    def O(self) -> Float[np.ndarray, "d p"]:  # noqa: E743, N802 - the paper's symbol
        """Reference features, one column an object."""
        return np.asarray(self.library.O)


def read_pictures(folder: str | os.PathLike[str]) -> NamedPictures:
    """Read all pictures of a folder, sorted by file name; each is named by its stem, whatever that holds.

    Raises
    ------
    ImageError
        The folder cannot be read or holds no picture, a picture is unsound, or two files have the same stem.
    """
    places: dict[str, Path] = {}
    for path in list_images(folder):
        if path.stem in places:
            must = f"must not have the stem of {places[path.stem].name}: it is the name"
            raise ImageError(f"picture {path}", value=path.stem, must=must, remedy="Rename one of the two.")
        places[path.stem] = path
    return {name: read_image(path) for name, path in places.items()}


def perceive(
    views: NamedPictures,
    references: References,
    *,
    lambda1: float,
    lambda2: float,
    lambda3: float,
    start: Recognition | None = None,
    **options: Unpack[Options],
) -> Recognition:
    """Recognise the object that the views show.

    Parameters
    ----------
    views : mapping of str to uint8 (h, w, 3)
        Each robot's name and picture; one view is enough.
    references : References
        Its `recent` keeps these views and their features until the next call.
    lambda1, lambda2, lambda3, start, **options
        See `recognize`.

    Returns
    -------
    Recognition

    Raises
    ------
    FeatureError
        No view at all.
    ProblemError, DecisionError, ToleranceError, StartError, SolverError
        See `recognize`.
    """
    return recognize(
        extract(views.values(), references.configuration, recent=references.recent),
        references.library,
        lambda1=lambda1,
        lambda2=lambda2,
        lambda3=lambda3,
        views=tuple(views),
        start=start,
        **options,
    )
