"""The matrix of feature vectors: one row for each view, one block of columns for each modality."""

import math
from collections.abc import Iterable, Iterator, Mapping
from functools import partial

import numpy as np
from jaxtyping import Float

from convexperc.errors import FeatureError, check_type, entries, is_one_of
from convexperc.features.color import color_histogram
from convexperc.features.configuration import (
    NORMALISATIONS,
    UNIT_LENGTH,
    UNIT_SUM,
    UNIT_VIEW,
    FeatureConfiguration,
)
from convexperc.features.hog import hog_descriptor
from convexperc.features.lbp import lbp_histogram
from convexperc.features.network.model import network_features
from convexperc.features.network.weights import require_network
from convexperc.features.parallel import available_cores, side_by_side
from convexperc.features.pictures import AnyPicture, Picture, Pictures, as_rgb, resize, to_gray
from convexperc.features.recent import RecentFeatures, Row

BATCH = 2**26
"""Bytes of 8-bit pictures that are held at a time, or one picture."""
COST = 16
"""Of a pixel at the working size, which is described, in pixels as given, which are resized; about."""
LARGE = 2**18
"""Cost of a picture from which on threads pay, where there are four or as much work as in four: about a
millisecond. With less to do each, they wait longer for the interpreter than they save."""


def extract(
    images: Iterable[object], configuration: FeatureConfiguration, *, recent: RecentFeatures | None = None
) -> Float[np.ndarray, "n d"]:
    """Describe each view by its colour, shape and texture, several side by side on all cores.

    A picture is resized to the working size; R, G, B give the colour histogram, the gray values
    (`to_gray`) give HOG and LBP. Where the configuration names a network, its features are a fourth modality
    (`network_features`). The columns of each modality are ``configuration.modality_sizes``,
    in that order.

    Parameters
    ----------
    images : iterable of ndarray of uint8 or uint16
        n >= 1 pictures of any sizes, gray, RGB or RGB and alpha (see `as_rgb`).
    configuration : FeatureConfiguration
        The parameters of the features.
    recent : RecentFeatures, optional
        Pictures that it has from the call before are not described again, and it keeps those of this one, the
        last 64 MiB of them (`BATCH`). The result does not depend on it.

    Returns
    -------
    ndarray of float64, (n, d), read-only
        With "unit length by modality", each block of a row has Euclidean length 1 or is zero, like the HOG of
        a uniform picture; see `normalise`.

    Raises
    ------
    FeatureError
        There is no picture, or one array was given in place of several.
    ImageError
        A picture cannot be used; the error names it as ``images[i]``.
    MissingExtraError, FileFormatError
        The configuration names a network, and its package is not installed, or holds other weights.

    Notes
    -----
    Paper: Section IV
    """
    if isinstance(images, np.ndarray) and images.ndim < 4:
        remedy = "For one view, pass a list with one picture."
        raise FeatureError(
            "images", value=images.shape, must="must be several pictures, not one", remedy=remedy
        )
    numbered = enumerate(entries(images, "images", FeatureError))
    return describe((as_rgb(image, f"images[{i}]") for i, image in numbered), configuration, recent)


def describe(
    pictures: Iterable[AnyPicture], configuration: FeatureConfiguration, recent: RecentFeatures | None = None
) -> Float[np.ndarray, "n d"]:
    """`extract` for pictures that `as_rgb` has made already; they must not change.

    Raises
    ------
    FeatureError
        There is no picture.
    MissingExtraError, FileFormatError
        See `extract`.
    """
    check_type(configuration, FeatureConfiguration, "configuration", FeatureError)
    check_type(recent, (RecentFeatures, type(None)), "recent", FeatureError)
    if configuration.network is not None:
        require_network()
    describe_all = partial(_describe_all, configuration=configuration)
    rows: list[Row] = []
    for batch in _batches(pictures):
        rows += describe_all(batch) if recent is None else recent.rows(batch, configuration, describe_all)
    if not rows:
        raise FeatureError("images", value=rows, must="must hold at least one picture")
    matrix = np.stack(rows)
    matrix.flags.writeable = False
    return matrix


def unit_length(vector: Float[np.ndarray, " d"]) -> Float[np.ndarray, " d"]:
    """Return ``v / ||v||_2``, shape (d,); zero stays zero.

    The vector is first divided by a power of two, exactly, so that the squares of large entries do not
    overflow and those of subnormal entries do not underflow.

    Raises
    ------
    FeatureError
        An entry is NaN or infinite.
    """
    check_type(vector, np.ndarray, "feature vector", FeatureError)
    if isinstance(vector, np.ma.MaskedArray) or vector.ndim != 1 or vector.dtype != np.float64:
        must = "must be a NumPy array of float64 with one dimension"
        raise FeatureError("feature vector", value=vector, must=must)
    largest = np.abs(vector).max(initial=0.0)
    if not np.isfinite(largest):
        raise FeatureError("feature vector", value=largest, must="must be finite")
    if largest == 0.0:
        return np.zeros_like(vector)
    scaled = np.ldexp(vector, -np.frexp(largest)[1])
    unit: Float[np.ndarray, " d"] = scaled / np.linalg.norm(scaled)
    return unit


def raw_blocks(
    image: object, configuration: FeatureConfiguration, name: str = "image"
) -> dict[str, Float[np.ndarray, " _"]]:
    """Return the modalities of one picture before normalisation.

    Parameters
    ----------
    image : ndarray of uint8 or uint16
        A picture of any size, gray, RGB or RGB and alpha (see `as_rgb`).
    configuration : FeatureConfiguration
        Its normalisation is not used.
    name : str
        How an error names the picture.

    Returns
    -------
    dict of str to ndarray of float64
        Counts of pixels, HOG values and, if any, means of a network's channels, named and sized as
        ``configuration.modality_sizes``.

    Raises
    ------
    ImageError
        The picture cannot be used.
    MissingExtraError, FileFormatError
        See `extract`.
    """
    check_type(configuration, FeatureConfiguration, "configuration", FeatureError)
    return _blocks(as_rgb(image, name), configuration)


def normalise(blocks: Mapping[str, Float[np.ndarray, " _"]], normalisation: str) -> Float[np.ndarray, " d"]:
    """Return the feature vector of one view from its modalities.

    Parameters
    ----------
    blocks : mapping of str to ndarray of float64
        Entries >= 0, as `raw_blocks` gives them.
    normalisation : str
        See `FeatureConfiguration`. A modality or view that is zero stays zero.

    Returns
    -------
    ndarray of float64, (d,)

    Raises
    ------
    FeatureError
        There is no modality, an entry is not finite, or there is no such normalisation.
    """
    check_type(blocks, Mapping, "blocks", FeatureError)
    if not blocks:
        raise FeatureError("blocks", value=blocks, must="must hold at least one modality")
    if not is_one_of(normalisation, NORMALISATIONS):
        must = f"must be one of {', '.join(map(repr, NORMALISATIONS))}"
        raise FeatureError("normalisation", value=normalisation, must=must)
    found = list(blocks.values())
    for name, block in blocks.items():
        check_type(block, np.ndarray, f"modality {name!r}", FeatureError)
        if block.ndim != 1:
            must = "must have one dimension"
            raise FeatureError(f"modality {name!r}", value=block.shape, must=must)
    if normalisation == UNIT_LENGTH:
        found = [unit_length(block) for block in found]
    if normalisation == UNIT_SUM:
        found = [block / (block.sum() or 1.0) for block in found]
    row = np.concatenate(found)
    return unit_length(row) if normalisation == UNIT_VIEW else row


def _batches(pictures: Iterable[AnyPicture]) -> Iterator[Pictures]:
    batch: Pictures = []
    held = 0
    for picture in pictures:
        if batch and held + picture.nbytes > BATCH:
            yield batch
            batch, held = [], 0
        batch.append(picture)
        held += picture.nbytes
    if batch:
        yield batch


def _describe_all(pictures: Pictures, configuration: FeatureConfiguration) -> list[Row]:
    given = sum(picture.size // 3 for picture in pictures)
    cost = given + COST * len(pictures) * math.prod(configuration.working_size)
    workers = available_cores() if cost >= LARGE * max(len(pictures), 4) else 1
    return side_by_side(partial(_describe, configuration=configuration), pictures, workers)


def _describe(picture: Picture, configuration: FeatureConfiguration) -> Row:
    row = normalise(_blocks(picture, configuration), configuration.normalisation)
    row.flags.writeable = False
    return row


def _blocks(picture: Picture, configuration: FeatureConfiguration) -> dict[str, Float[np.ndarray, " _"]]:
    small = resize(picture, configuration.working_size)
    gray = to_gray(small)
    blocks = {
        "color": color_histogram(small, configuration),
        "hog": hog_descriptor(gray, configuration),
        "lbp": lbp_histogram(gray, configuration),
    }
    if configuration.network is not None:
        blocks["cnn"] = network_features(picture, configuration)
    return blocks
