"""Faults in the features of pictures."""

from collections.abc import Callable
from dataclasses import replace
from importlib import import_module
from typing import Any

import numpy as np
from skimage.feature import local_binary_pattern

from convexperc.features import color, extraction, hog, lbp
from convexperc.features import pictures as images
from convexperc.kernels.kernel import Kernel
from verification.faults.fault import Fault, Plant, everywhere, replaced, together, wrapped

skimage_hog, skimage_lbp = (import_module(f"skimage.feature.{name}") for name in ("_hog", "texture"))
"""Where scikit-image computes; `skimage.feature` has functions of these names."""


def _configured(module: Any, name: str, **values: Callable[[Any], Any]) -> Plant:
    """Describe with other settings than those asked for."""
    original = getattr(module, name)

    def describe(picture: Any, configuration: Any) -> Any:
        changed = {key: value(configuration) for key, value in values.items()}
        return original(picture, replace(configuration, **changed))

    return replaced(module, name, describe)


def _patterns(
    gray: Any, configuration: Any, *, points: int = 0, radius: float = 0.0, rim: bool = True, levels: int = 1
) -> Any:
    """The histogram of patterns with other points, radius, rim or levels of gray."""
    codes = local_binary_pattern(  # type: ignore[no-untyped-call]
        gray // levels,
        P=configuration.lbp_points + points,
        R=configuration.lbp_radius + radius,
        method=configuration.lbp_method,
    )
    margin = configuration.lbp_margin if rim else 0
    inner = codes[margin : codes.shape[0] - margin, margin : codes.shape[1] - margin].astype(np.int64)
    counts = np.bincount(inner.ravel(), minlength=configuration.lbp_bins)[: configuration.lbp_bins]
    return counts.astype(np.float64)


def _described(**changes: Any) -> Plant:
    return replaced(lbp, "lbp_histogram", lambda gray, settings: _patterns(gray, settings, **changes))


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


BY_SCIKIT_IMAGE = replaced(Kernel, "replaces", lambda kernel, seconds: False)
"""Machine code, which gives the same bits, would not show what is wrong in the library."""


def _of_the_negative(setter: Any) -> None:
    """Codes of the negative: a bit is 1 where a neighbour is no brighter, inside of scikit-image."""
    original = skimage_lbp._local_binary_pattern
    setter.setattr(skimage_lbp, "_local_binary_pattern", lambda image, *a: original(-image, *a))


HISTOGRAM = color.color_histogram

PICTURE = (
    Fault(
        "the image library doubles one half of the gradient",
        "B5/hog",
        together(BY_SCIKIT_IMAGE, wrapped(skimage_hog, "_hog_channel_gradient", _rows_doubled)),
        may=("B5/partition",),
    ),
    Fault(
        "the image library compares the wrong way round",
        "B5/lbp",
        together(BY_SCIKIT_IMAGE, _of_the_negative),
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
        _described(levels=16),
        may=("B5/partition",),
    ),
    Fault(
        "LBP with a radius one larger",
        "B5/lbp",
        _described(radius=1.0),
        may=("B5/partition",),
    ),
    Fault(
        "LBP with one neighbour more",
        "B5/lbp",
        _described(points=1),
        may=("B5/partition",),
    ),
    Fault(
        "LBP with the rim of the picture",
        "B5/lbp",
        _described(rim=False),
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
