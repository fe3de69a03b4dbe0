"""Scenes made of the references themselves, where labelled scenes are too few to calibrate by."""

from collections.abc import Iterator
from typing import Any, Unpack

import numpy as np
from jaxtyping import Bool

from convexperc.errors import CalibrationError
from convexperc.problem.library import TemplateLibrary
from convexperc.recognition.label import Options, recognize
from convexperc.recognition.recognition import Recognition


def held_out_scenes(
    library: TemplateLibrary,
    robots: int = 1,
    *,
    lambda1: Any,
    lambda2: Any,
    lambda3: Any,
    **options: Unpack[Options],
) -> Iterator[tuple[Recognition, str]]:
    """Recognise references as if they were views, each time without them in the library.

    An object with r references, r > `robots`, gives r scenes: scene i takes the references i, ...,
    i + robots - 1 (mod r) as its views.

    Parameters
    ----------
    library : TemplateLibrary
    robots : int
        Views of a scene, at least 1.
    lambda1, lambda2, lambda3, **options
        See `recognize`; every optimum is bounded (``prune=False``).

    Yields
    ------
    Recognition, str
        The outcome and the object.

    Raises
    ------
    CalibrationError
        No object has more references than `robots`.
    ProblemError, DecisionError, ToleranceError
        See `recognize`.

    Notes
    -----
    The references of an object are often pictures of one occasion without obstacles. Thresholds set by them
    hold for views like that, and only nearly, since these scenes share references.
    """
    if type(robots) is not int or robots < 1:
        raise CalibrationError("robots", value=robots, must="must be an integer of at least 1")
    if not isinstance(library, TemplateLibrary):
        must = "must be a TemplateLibrary"
        raise CalibrationError("library", value=type(library).__name__, must=must)
    sizes = np.bincount(library.owners)
    if not (sizes > robots).any():
        must = f"must have more than {robots} references for at least one object"
        remedy = "Calibrate by labelled scenes, or take fewer robots."
        raise CalibrationError("library", value=f"at most {sizes.max()}", must=must, remedy=remedy)
    options["prune"] = False
    for place, name in enumerate(library.objects):
        own = (library.owners == place).nonzero()[0]
        for i in range(own.size if own.size > robots else 0):
            out = np.full(library.owners.size, fill_value=False)
            out[np.roll(own, -i)[:robots]] = True
            found = recognize(
                np.asarray(library.O[:, out], dtype=np.float64).T, _without(library, out),
                lambda1=lambda1, lambda2=lambda2, lambda3=lambda3, **options,
            )  # fmt: skip
            yield found, name


def _without(library: TemplateLibrary, out: Bool[np.ndarray, " p"]) -> TemplateLibrary:
    """The other references."""
    kept = (~out).nonzero()[0].tolist()
    return TemplateLibrary(
        library.O[:, kept],
        names=[library.names[j] for j in kept],
        objects=[library.shown[j] for j in kept],
        modalities=library.modalities,
    )
