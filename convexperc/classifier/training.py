"""From training samples to a library of references: of each view, of each sample, or of each class."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from jaxtyping import Int, Shaped
from numpy.typing import NDArray

from convexperc.errors import InputError, is_one_of
from convexperc.problem.library import TemplateLibrary

Samples = Shaped[np.ndarray, "samples n d"]
"""The views of each sample."""
Found = tuple[NDArray[Any], NDArray[np.intp], list[str]]
"""References (p, d), the place of each one's class, and what its name has behind that of the class."""


def _of_views(samples: Samples, owners: Int[np.ndarray, " samples"]) -> Found:
    count, n, d = samples.shape
    names = [f"/row {row}/robot {robot}" for row in range(count) for robot in range(1, n + 1)]
    return samples.reshape(count * n, d), np.repeat(owners, n), names


def _of_samples(samples: Samples, owners: Int[np.ndarray, " samples"]) -> Found:
    names = [f"/row {row}" for row in range(samples.shape[0])]
    return samples.mean(axis=1, dtype=np.float64), owners, names


def _of_classes(samples: Samples, owners: Int[np.ndarray, " samples"]) -> Found:
    classes = np.unique(owners)
    means = [samples[owners == each].mean(axis=(0, 1), dtype=np.float64) for each in classes]
    return np.stack(means), classes, [""] * classes.size


KINDS: dict[str, Callable[[Samples, Int[np.ndarray, " samples"]], Found]] = {
    "view": _of_views,
    "sample": _of_samples,
    "class": _of_classes,
}
"""What becomes a reference, by its name."""


def check_kind(kind: object) -> None:
    """Check what is to become a reference.

    Raises
    ------
    InputError
        There is no such kind.
    """
    if not is_one_of(kind, KINDS):
        must = f"must be one of {', '.join(map(repr, KINDS))}"
        raise InputError("references", value=kind, must=must)


def trained_library(
    samples: Samples,
    owners: Int[np.ndarray, " samples"],
    classes: Sequence[str],
    kind: str,
    modalities: Any = None,
) -> TemplateLibrary:
    """Make the references of labelled samples, class by class in the order of `classes`.

    Parameters
    ----------
    samples : array of real numbers (samples, n, d)
    owners : int (samples,)
        The place in `classes` of each sample's class; every class has a sample.
    classes : sequence of str
    kind : {"view", "sample", "class"}
        See `MultiViewClassifier`. Means are taken in float64.
    modalities : see `Modalities.of`

    Raises
    ------
    InputError
        There is no such kind.
    ProblemError
        A mean overflows, or a number is one that float64 does not hold.
    ModalityError, TemplateNameError
        See `TemplateLibrary`.
    """
    check_kind(kind)
    with np.errstate(over="ignore"):
        rows, places, names = KINDS[kind](samples, owners)
    order = np.argsort(places, kind="stable")
    columns = rows[order].T  # a copy: the caller may change the samples
    columns.flags.writeable = False
    shown = [classes[place] for place in places[order].tolist()]
    own = [f"{name}{names[row]}" for name, row in zip(shown, order.tolist(), strict=True)]
    library = TemplateLibrary(columns, names=own, objects=shown, modalities=modalities)
    _ = library.lengths  # refuses now what is not finite
    return library
