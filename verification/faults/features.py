"""Faults in the features of pictures."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from convexperc.features import color, extraction, hog, lbp
from convexperc.features import pictures as images
from verification.faults.fault import Fault, Plant, everywhere, replaced, wrapped


def _configured(module: Any, name: str, **values: Callable[[Any], Any]) -> Plant:
    """Describe with other settings than those asked for."""
    original = getattr(module, name)

    def describe(picture: Any, configuration: Any) -> Any:
        changed = {key: value(configuration) for key, value in values.items()}
        return original(picture, replace(configuration, **changed))

    return replaced(module, name, describe)


def _with_one_neighbour_more(gray: Any, configuration: Any) -> Any:
    """The histogram of P + 1 neighbours, cut to the length of that of P."""
    points, uniform = configuration.lbp_points + 1, configuration.lbp_method == "uniform"
    more = replace(configuration, lbp_points=points, lbp_bins=points + 2 if uniform else 2**points)
    return PATTERNS(gray, more)[: configuration.lbp_bins]


def _with_the_rim(gray: Any, configuration: Any) -> Any:
    """The histogram of all pixels, in front of black."""
    return PATTERNS(np.pad(gray, configuration.lbp_margin), configuration)


def _brighter(image: Any) -> Any:
    """Every intensity one higher, up to 255."""
    return np.minimum(image, 254) + np.uint8(1)


def _plain_gray(picture: Any) -> Any:
    """The mean of R, G and B."""
    return np.asarray(picture.mean(axis=2).round(), dtype=np.uint8)


def _exchanged(X: Any, configuration: Any) -> Any:
    """The last block first."""
    ends = np.cumsum(list(configuration.modality_sizes.values()))
    first, middle, last = np.split(X, ends[:-1], axis=1)
    return np.concatenate([last, middle, first], axis=1)


def _rows_doubled(found: Any, *arguments: Any) -> Any:
    """Gradients with the step down taken twice."""
    return 2.0 * found[0], found[1]


HISTOGRAM, PATTERNS, COMPARE = color.color_histogram, lbp.lbp_histogram, lbp._compare

PICTURE = (
    Fault(
        "HOG with one half of the gradient doubled",
        "B5/hog",
        wrapped(hog, "_gradient", _rows_doubled),
        may=("B5/partition",),
    ),
    Fault(
        "LBP with neighbours compared the wrong way round",
        "B5/lbp",
        replaced(lbp, "_compare", lambda values, *rest: COMPARE(-values, *rest)),
    ),
    Fault(
        "red and blue exchanged",
        "B5/histogram",
        replaced(
            color, "color_histogram", lambda image, c: HISTOGRAM(np.ascontiguousarray(image[:, :, ::-1]), c)
        ),
    ),
    Fault(
        "intensities one bin off",
        "B5/histogram",
        replaced(color, "color_histogram", lambda image, settings: HISTOGRAM(_brighter(image), settings)),
    ),
    Fault(
        "HOG in single precision",
        "B5/hog",
        wrapped(hog, "hog_descriptor", lambda h, *a: np.float32(h)),
    ),
    Fault(
        "HOG with cells of another size",
        "B5/hog",
        _configured(hog, "hog_descriptor", hog_pixels_per_cell=lambda c: (4, 4)),
    ),
    Fault(
        "HOG with another norm of its blocks",
        "B5/hog",
        _configured(hog, "hog_descriptor", hog_block_norm=lambda c: "L1"),
    ),
    Fault(
        "gray as the mean of R, G, B",
        "B5/hog",
        everywhere(images.to_gray, _plain_gray),
        ("B5/lbp", "B5/partition"),
    ),
    Fault(
        "LBP of gray values in 16 levels",
        "B5/lbp",
        replaced(lbp, "lbp_histogram", lambda gray, settings: PATTERNS(gray // 16, settings)),
        may=("B5/partition",),
    ),
    Fault(
        "LBP with a radius one larger",
        "B5/lbp",
        _configured(lbp, "lbp_histogram", lbp_radius=lambda c: c.lbp_radius + 1.0),
        may=("B5/partition",),
    ),
    Fault(
        "LBP with one neighbour more",
        "B5/lbp",
        replaced(lbp, "lbp_histogram", _with_one_neighbour_more),
        may=("B5/partition",),
    ),
    Fault(
        "LBP with the rim of the picture",
        "B5/lbp",
        replaced(lbp, "lbp_histogram", _with_the_rim),
        may=("B5/partition",),
    ),
    Fault(
        "blocks of colour and texture exchanged",
        "B5/partition",
        wrapped(extraction, "extract", lambda X, images, c: _exchanged(X, c)),
    ),
    Fault(
        "blocks without unit length",
        "B5/partition",
        replaced(extraction, "unit_length", lambda block: block),
    ),
)
