"""Texture: a histogram of local binary patterns."""

import math
from typing import no_type_check

import numpy as np
import skimage.feature
from jaxtyping import Float, Int, Integer, UInt8, UInt32
from numpy.typing import NDArray

from convexperc.errors import FeatureError, check_type
from convexperc.features.configuration import FeatureConfiguration
from convexperc.features.pictures import GrayPicture, check_picture
from convexperc.kernels.kernel import Kernel

BAND = 2**15
"""Pixels whose patterns are computed before they are counted, about; it limits the memory."""
PLACES = 5
"""Decimals to which the positions on the circle are rounded."""
SECONDS = 7e-9
"""What scikit-image takes for a pixel and a neighbour, about."""

Patterns = UInt32[np.ndarray, "rows columns"]
"""Bit i of an entry is that of the i-th neighbour."""


def lbp_histogram(gray: GrayPicture, configuration: FeatureConfiguration) -> Float[np.ndarray, " lbp"]:
    """Count the codes of the pixels that have a full circle of neighbours.

    P neighbours on a circle of radius R, interpolated linearly, each give one bit: at least as bright
    as the centre, or not. The border of width ``ceil(R)`` is excluded, because its pixels lack neighbours.

    Parameters
    ----------
    gray : ndarray of uint8, (h, w)
        The picture at the working size.
    configuration : FeatureConfiguration
        Its ``lbp_...`` values.

    Returns
    -------
    ndarray of float64, (lbp_bins,)
        Counts of pixels; their sum is ``(h - 2 ceil(R)) (w - 2 ceil(R))``.

    Notes
    -----
    The counts are those of scikit-image's ``local_binary_pattern``, also where machine code does the same
    operations in the same order, in double precision, at positions rounded to five decimals. Where an
    interpolated neighbour equals the centre but for rounding, as in all flat areas, rounding determines the
    bit.

    Source: T. Ojala, M. Pietikäinen and D. Harwood, Performance evaluation of texture measures, ICPR
    1994; uniform codes by T. Ojala, M. Pietikäinen and T. Mäenpää, 2002.
    Paper: Section IV
    """
    check_picture(gray, "gray picture", 1)
    check_type(configuration, FeatureConfiguration, "configuration", FeatureError)
    if comparing_kernel.replaces(SECONDS * gray.size * configuration.lbp_points):
        counts = _by_machine_code(gray, configuration)
    else:
        counts = _by_scikit_image(gray, configuration)
    return counts.astype(np.float64)


def _by_scikit_image(gray: GrayPicture, configuration: FeatureConfiguration) -> Int[np.ndarray, " lbp"]:
    codes = skimage.feature.local_binary_pattern(  # type: ignore[no-untyped-call]
        gray,
        P=configuration.lbp_points,
        R=configuration.lbp_radius,
        method=configuration.lbp_method,
    )
    margin = configuration.lbp_margin
    inner = codes[margin:-margin, margin:-margin].astype(np.int64)
    return np.bincount(inner.ravel(), minlength=configuration.lbp_bins)


def _by_machine_code(gray: GrayPicture, configuration: FeatureConfiguration) -> Int[np.ndarray, " lbp"]:
    height, width = gray.shape
    margin, (down, right) = configuration.lbp_margin, _circle(configuration)
    rows, columns = max(BAND // width, 2 * margin), width - 2 * margin
    counts = np.zeros(configuration.lbp_bins, dtype=np.int64)
    for top in range(margin, height - margin, rows):
        end = min(top + rows, height - margin)
        values = np.ascontiguousarray(gray[top - margin : end + margin], dtype=np.float64)
        patterns = np.zeros((end - top, columns), dtype=np.uint32)
        comparing_kernel.compiled(values, top - margin, down, right, np.empty(columns), patterns)
        counts += np.bincount(_codes(patterns, configuration).ravel(), minlength=counts.size)
    return counts


def _circle(configuration: FeatureConfiguration) -> tuple[Float[np.ndarray, " P"], Float[np.ndarray, " P"]]:
    """Return how far down and right of the centre each neighbour is."""
    angles = 2 * np.pi * np.arange(configuration.lbp_points, dtype=np.float64) / configuration.lbp_points
    down = np.round(-configuration.lbp_radius * np.sin(angles), PLACES)
    return down, np.round(configuration.lbp_radius * np.cos(angles), PLACES)


def _codes(patterns: Patterns, configuration: FeatureConfiguration) -> Integer[np.ndarray, "rows columns"]:
    """Map each pattern to its code.

    A pattern is uniform if its bits change at most twice along the circle. Its "uniform" code is the number
    of its ones, its "nri_uniform" code also says where they are; all other patterns share the last code.
    "ror" is the least number among the rotations of the pattern, "default" the pattern itself.
    """
    points, method = configuration.lbp_points, configuration.lbp_method
    if method == "default":
        return patterns
    if method == "ror":
        return np.asarray(np.min([_rotated(patterns, turn, points) for turn in range(points)], axis=0))
    ones: UInt8[np.ndarray, "rows columns"] = np.bitwise_count(patterns)
    bits_but_last = np.uint32(2 ** (points - 1) - 1)
    # From the last bit to the first there is a change if and only if the others are odd in number.
    changes = np.bitwise_count((patterns ^ (patterns >> 1)) & bits_but_last)
    codes = ones if method == "uniform" else _directed(patterns, ones, points)
    codes[changes > 2] = configuration.lbp_bins - 1
    return codes


def _rotated(patterns: Patterns, turn: int, points: int) -> Patterns:
    """Rotate the `points` bits of each pattern to the right."""
    return (patterns >> turn) | ((patterns << (points - turn)) & np.uint32(2**points - 1))


def _directed(
    patterns: Patterns, ones: UInt8[np.ndarray, "rows columns"], points: int
) -> Int[np.ndarray, "rows columns"]:
    """Return the codes of uniform patterns by the number of ones and the place of the first one or zero."""
    count = ones.astype(np.int64)
    turn = np.where(patterns & 1, count - _trailing_zeros(~patterns), points - _trailing_zeros(patterns))
    codes = 1 + (count - 1) * points + turn
    codes[ones == 0], codes[ones == points] = 0, points * (points - 1) + 1
    return codes


def _trailing_zeros(patterns: Patterns) -> Int[np.ndarray, "rows columns"]:
    """Return the place of the lowest bit that is 1."""
    return np.asarray(np.bitwise_count(~patterns & (patterns - np.uint32(1))), dtype=np.int64)


@no_type_check
def compare(values, first, down, right, share, patterns):
    """Set bit i of `patterns` (rows, columns), all zero before, where neighbour i >= the centre.

    `values` are the gray values of the rows of a picture from `first` on, with a margin on all sides that
    holds all neighbours; `share` (columns) is working memory. As in scikit-image, the shares of the four
    pixels around a position are those of the rounded sum of the pixel's place in the picture and the offset.
    """
    rows, columns = patterns.shape
    margin = (values.shape[0] - rows) // 2
    for i in range(down.size):
        for k in range(columns):
            place = (margin + k) + right[i]
            share[k] = place - math.floor(place)
        left = margin + math.floor(right[i])
        beside = left + (1 if share[0] > 0.0 else 0)
        for j in range(rows):
            place = (first + margin + j) + down[i]
            drop = place - math.floor(place)
            above = margin + j + math.floor(down[i])
            below = above + (1 if drop > 0.0 else 0)
            corners = (
                values[above, left : left + columns], values[above, beside : beside + columns],
                values[below, left : left + columns], values[below, beside : beside + columns],
            )  # fmt: skip
            set_bit(i, values[margin + j, margin : margin + columns], corners, share, drop, patterns[j])


@no_type_check
def set_bit(i, centres, corners, share, drop, patterns):
    """Set bit i of the patterns of a row where the value between the four corners is >= the centre."""
    bit, rest = np.uint32(1 << i), 1.0 - drop
    upper_left, upper_right, lower_left, lower_right = corners
    for k in range(centres.size):
        upper = (1.0 - share[k]) * upper_left[k] + share[k] * upper_right[k]
        lower = (1.0 - share[k]) * lower_left[k] + share[k] * lower_right[k]
        patterns[k] |= bit if rest * upper + drop * lower >= centres[k] else np.uint32(0)


def _interpreted_seconds(
    values: NDArray[np.float64], first: int, down: NDArray[np.float64], *rest: object
) -> float:
    """About what `compare` takes interpreted."""
    return 2e-6 * values.size * down.size


comparing_kernel = Kernel(
    compare,
    _interpreted_seconds,
    compile_seconds=0.5,
    smallest=(np.zeros((3, 3)), 0, np.zeros(1), np.zeros(1), np.zeros(1), np.zeros((1, 1), np.uint32)),
)
"""`compare`, which replaces scikit-image where it is compiled."""
