"""Shape: histograms of oriented gradients."""

from typing import no_type_check

import numpy as np
import skimage.feature
from jaxtyping import Float
from numpy.typing import NDArray

from convexperc.errors import FeatureError, check_type
from convexperc.features.configuration import FeatureConfiguration
from convexperc.features.pictures import GrayPicture, check_picture
from convexperc.kernels.kernel import Kernel

BAND = 2**18
"""Pixels whose gradients are held at a time, about, but at least one row of cells; it limits the memory."""
EPSILON = 1e-5
"""Added to the sum of a block (L1), or in its square to the sum of squares (L2), against division by 0."""
CLIPPED = 0.2
"""L2-Hys cuts the entries of a block of length 1 at this value, and divides by the length again."""
SECONDS = 8e-8
"""What scikit-image takes for a pixel, about."""


def hog_descriptor(gray: GrayPicture, configuration: FeatureConfiguration) -> Float[np.ndarray, " hog"]:
    """Return histograms of the gradient's direction in cells, normalised over overlapping blocks.

    Central differences of the 8-bit values (zero on the border), unsigned directions over 180 degrees,
    each pixel counted in one bin with its gradient's magnitude, blocks stepping by one cell. The order
    is block row, block column, cell row, cell column, orientation.

    Parameters
    ----------
    gray : ndarray of uint8, (h, w)
        The picture at the working size.
    configuration : FeatureConfiguration
        Its ``hog_...`` values.

    Returns
    -------
    ndarray of float64, (blocks * cells a block * orientations,)
        Dimensionless values >= 0; all zero for a uniform picture.

    Notes
    -----
    The values are those of scikit-image's ``hog``, also where machine code does the same operations in the
    same order. A cell is summed in single precision, row by row, all else is double precision.

    Source: N. Dalal and B. Triggs, Histograms of oriented gradients for human detection, CVPR 2005.
    Paper: Section IV
    """
    check_picture(gray, "gray picture", 1)
    check_type(configuration, FeatureConfiguration, "configuration", FeatureError)
    if summing_kernel.replaces(SECONDS * gray.size):
        return _by_machine_code(gray, configuration)
    return _by_scikit_image(gray, configuration)


def _by_scikit_image(gray: GrayPicture, configuration: FeatureConfiguration) -> Float[np.ndarray, " hog"]:
    descriptor = skimage.feature.hog(
        gray,
        orientations=configuration.hog_orientations,
        pixels_per_cell=configuration.hog_pixels_per_cell,
        cells_per_block=configuration.hog_cells_per_block,
        block_norm=configuration.hog_block_norm,
        visualize=False,
        transform_sqrt=configuration.hog_transform_sqrt,
        feature_vector=True,
        channel_axis=None,
    )
    return np.asarray(descriptor, dtype=np.float64)


def _by_machine_code(gray: GrayPicture, configuration: FeatureConfiguration) -> Float[np.ndarray, " hog"]:
    cells = _cells(gray, configuration)
    blocks = np.lib.stride_tricks.sliding_window_view(cells, configuration.hog_cells_per_block, axis=(0, 1))
    rows = np.moveaxis(blocks, 2, 4).reshape(blocks.shape[0] * blocks.shape[1], -1)
    rows = np.ascontiguousarray(rows)  # so that a block is summed in scikit-image's order
    return _normalised(rows, configuration.hog_block_norm).ravel()


def _cells(gray: GrayPicture, configuration: FeatureConfiguration) -> Float[np.ndarray, "down across bins"]:
    """Return the mean magnitude of each cell by direction."""
    (height, width), bins = configuration.hog_pixels_per_cell, configuration.hog_orientations
    sums = np.zeros((gray.shape[0] // height, gray.shape[1] // width, bins), dtype=np.float32)
    step = max(1, BAND // (height * gray.shape[1]))
    for top in range(0, sums.shape[0], step):
        band = sums[top : top + step]
        down, across = _gradient(gray, top * height, (top + band.shape[0]) * height, configuration)
        degrees = np.rad2deg(np.arctan2(down, across))
        summing_kernel.compiled(np.hypot(across, down), degrees, height, width, 180.0 / bins, band)
    return (sums / np.float32(height * width)).astype(np.float64)


def _gradient(
    gray: GrayPicture, start: int, stop: int, configuration: FeatureConfiguration
) -> tuple[Float[np.ndarray, "rows w"], Float[np.ndarray, "rows w"]]:
    """Return the central differences down and across in the rows from `start` to `stop`."""
    first, last = max(start - 1, 0), min(stop + 1, gray.shape[0])
    values = gray[first:last].astype(np.float64)
    if configuration.hog_transform_sqrt:
        values = np.sqrt(values)
    down, across = np.zeros((2, stop - start, gray.shape[1]))
    inner = slice(first + 1 - start, last - 1 - start)
    np.subtract(values[2:], values[:-2], out=down[inner])
    here = values[start - first : stop - first]
    np.subtract(here[:, 2:], here[:, :-2], out=across[:, 1:-1])
    return down, across


@no_type_check
def add_magnitudes(magnitudes, degrees, height, width, step, sums):
    """Add each pixel's magnitude to the bin of its direction, of `step` degrees, in its cell.

    `sums` (cells down, cells across, bins) are in single precision. The directions are from -180 to 180
    degrees; those that differ by 180 are the same.
    """
    down, across, bins = sums.shape
    per_degree = 1.0 / step
    for y in range(down * height):
        for j in range(across):
            cell = sums[y // height, j]
            for x in range(j * width, (j + 1) * width):
                angle = degrees[y, x]
                if angle < 0.0:
                    angle += 180.0
                elif angle == 180.0:
                    angle = 0.0
                b = int(angle * per_degree)
                if angle < step * b:
                    b -= 1
                elif angle >= step * (b + 1):
                    b += 1
                if b < bins:
                    cell[b] = np.float32(np.float64(cell[b]) + magnitudes[y, x])


def _interpreted_seconds(magnitudes: NDArray[np.float64], *rest: object) -> float:
    """About what `add_magnitudes` takes interpreted."""
    return 2e-6 * magnitudes.size


summing_kernel = Kernel(
    add_magnitudes,
    _interpreted_seconds,
    compile_seconds=0.4,
    smallest=(np.zeros((1, 1)), np.zeros((1, 1)), 1, 1, 180.0, np.zeros((1, 1, 1), np.float32)),
)
"""`add_magnitudes`, which replaces scikit-image where it is compiled."""


def _normalised(blocks: Float[np.ndarray, "blocks k"], norm: str) -> Float[np.ndarray, "blocks k"]:
    """Divide each block by its norm."""
    if norm in ("L1", "L1-sqrt"):
        found = blocks / (np.abs(blocks).sum(axis=1, keepdims=True) + EPSILON)
        return np.asarray(np.sqrt(found) if norm == "L1-sqrt" else found)
    found = _divided_by_length(blocks)
    return _divided_by_length(np.minimum(found, CLIPPED)) if norm == "L2-Hys" else found


def _divided_by_length(blocks: Float[np.ndarray, "blocks k"]) -> Float[np.ndarray, "blocks k"]:
    return np.asarray(blocks / np.sqrt(np.square(blocks).sum(axis=1, keepdims=True) + EPSILON**2))
