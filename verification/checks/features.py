"""B5 by cases: every block of the features against a direct computation on small pictures."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from skimage.feature import hog, local_binary_pattern

from convexperc.features import color, extraction
from convexperc.features import hog as shape
from convexperc.features import lbp as texture
from convexperc.features import pictures as images
from convexperc.features.configuration import BY_CHANNEL, JOINT, FeatureConfiguration
from convexperc.problem.problem import Problem
from verification.checks.interface import Check, Observation
from verification.checks.measures import LARGEST_MEASURE
from verification.ledger.evidence import Outcome
from verification.problems.sources import Source

PARTS = ("B5/histogram", "B5/hog", "B5/lbp", "B5/partition")
COUNTED, DESCRIBED = 1e-12, 1e-9
"""Largest differences allowed: of counts and of unit vectors; of HOG values."""
TURNED = 2e-6
"""Of the HOG of a turned picture: the order of scikit-image's sums, taken in single precision, changes."""
CELL = 8
"""Sides of pictures are multiples of it, so that cells fill them and a turned picture has the same cells."""

Pixels = NDArray[np.uint8]
Numbers = NDArray[np.float64]


def observe(problem: Problem, source: Source) -> Iterator[Observation]:
    """Draw a picture and a configuration; the problem gives nothing."""
    picture = _picture(source)
    settings = _configuration(source, picture.shape[0], picture.shape[1])
    gray = _gray(picture)
    counts, gradients, patterns = _histogram(picture, settings), _hog(gray, settings), _lbp(gray, settings)
    found = np.asarray(color.color_histogram(picture, settings))
    yield _same("B5/histogram", found, counts, COUNTED)
    upright = np.asarray(shape.hog_descriptor(images.to_gray(picture), settings))
    turned = np.asarray(shape.hog_descriptor(images.to_gray(_turned(picture)), settings))
    described = _same("B5/hog", upright, gradients, DESCRIBED)
    if upright.shape == turned.shape == gradients.shape:
        back = _same("B5/hog", _turned_back(turned, settings), gradients, TURNED)
        described = back if back.outcome is Outcome.FAILED else described
    yield described
    found = np.asarray(texture.lbp_histogram(images.to_gray(picture), settings))
    yield _same("B5/lbp", found, patterns, COUNTED)
    yield _partition(picture, settings, (counts, gradients, patterns))


def _picture(source: Source) -> Pixels:
    """16..32 pixels a side: flat tiles of drawn colours under a drawn texture."""
    height, width = (CELL * source.integer(2, 4) for _ in range(2))
    tiles = np.abs(source.matrix(4, 12)).reshape(4, 4, 3)
    rows, columns = np.arange(height) * 4 // height, np.arange(width) * 4 // width
    flat = np.floor(tiles[np.ix_(rows, columns)] * 80.0).astype(np.int64)
    steps = [source.integer(0, 60) for _ in range(3)]
    y, x = np.mgrid[:height, :width]
    pattern = steps[0] * y + steps[1] * x + steps[2] * (x * y % 7)
    return np.ascontiguousarray((flat + pattern[:, :, None] * np.array([1, 2, 3])) % 256, dtype=np.uint8)


def _configuration(source: Source, height: int, width: int) -> FeatureConfiguration:
    points, method = source.choice((8, 4)), source.choice(("uniform", "default"))
    histogram = source.choice((BY_CHANNEL, JOINT))
    return FeatureConfiguration(
        working_size=(height, width),
        color_histogram=histogram,
        color_bins=source.choice((8, 2, 32, 256) if histogram == BY_CHANNEL else (8, 2, 4, 16)),
        hog_pixels_per_cell=(CELL, CELL),
        hog_cells_per_block=source.choice(((2, 2), (1, 1), (1, 2))),
        hog_block_norm=source.choice(("L2-Hys", "L2", "L1", "L1-sqrt")),
        lbp_points=points,
        lbp_radius=float(source.integer(1, 2)),
        lbp_method=method,
        lbp_bins=points + 2 if method == "uniform" else 2**points,
    )


def _gray(picture: Pixels) -> Pixels:
    """Luma of ITU-R BT.601, rounded to the nearest integer, halves up."""
    red, green, blue = (picture[:, :, c].astype(np.int64) for c in range(3))
    return np.asarray((299 * red + 587 * green + 114 * blue + 500) // 1000, dtype=np.uint8)


def _histogram(picture: Pixels, settings: FeatureConfiguration) -> Numbers:
    """Count pixel by pixel."""
    bins = settings.color_bins
    joint = settings.color_histogram == JOINT
    counts = np.zeros((bins, bins, bins) if joint else (3, bins))
    for pixel in picture.reshape(-1, 3).tolist():
        found = tuple(value * bins // 256 for value in pixel)
        for place in (found,) if joint else enumerate(found):
            counts[place] += 1.0
    return counts.ravel()


def _hog(gray: Pixels, settings: FeatureConfiguration) -> Numbers:
    """scikit-image's own, with every argument named."""
    found = hog(
        gray,
        orientations=settings.hog_orientations,
        pixels_per_cell=settings.hog_pixels_per_cell,
        cells_per_block=settings.hog_cells_per_block,
        block_norm=settings.hog_block_norm,
        visualize=False,
        transform_sqrt=settings.hog_transform_sqrt,
        feature_vector=True,
        channel_axis=None,
    )
    return np.asarray(found, dtype=np.float64)


def _lbp(gray: Pixels, settings: FeatureConfiguration) -> Numbers:
    """scikit-image's codes, counted one by one where the circle of neighbours lies in the picture."""
    codes = local_binary_pattern(  # type: ignore[no-untyped-call]
        gray, P=settings.lbp_points, R=settings.lbp_radius, method=settings.lbp_method
    )
    rim = int(np.ceil(settings.lbp_radius))
    counts = np.zeros(settings.lbp_bins)
    for code in codes[rim : gray.shape[0] - rim, rim : gray.shape[1] - rim].ravel().tolist():
        counts[int(code)] += 1.0
    return counts


def _turned(picture: Pixels) -> Pixels:
    """Turned by 180 degrees: every gradient changes its sign, no unsigned direction changes."""
    return np.ascontiguousarray(picture[::-1, ::-1])


def _turned_back(descriptor: Numbers, settings: FeatureConfiguration) -> Numbers:
    """The descriptor with its blocks, and the cells of each block, in reverse order."""
    sides = zip(settings.working_size, settings.hog_cells_per_block, strict=True)
    down, across = (pixels // CELL - cells + 1 for pixels, cells in sides)
    blocks = descriptor.reshape(down, across, *settings.hog_cells_per_block, settings.hog_orientations)
    return np.ascontiguousarray(blocks[::-1, ::-1, ::-1, ::-1]).ravel()


def _same(part: str, found: Numbers, true: Numbers, allowed: float) -> Observation:
    if found.shape != true.shape:
        return Observation.of(part, False, LARGEST_MEASURE, f"{found.shape} numbers, not {true.shape}")
    away = float(np.abs(found - true).max())
    detail = f"differs by {away!r} at number {int(np.abs(found - true).argmax())}"
    return Observation.of(part, away <= allowed, away, detail)


def _partition(picture: Pixels, settings: FeatureConfiguration, blocks: tuple[Numbers, ...]) -> Observation:
    """Colour, shape, texture, each of its stated size and of unit length, or 0."""
    sizes, row = settings.modality_sizes, np.asarray(extraction.extract([picture], settings))[0]
    if list(sizes.items()) != list(zip(("color", "hog", "lbp"), (b.size for b in blocks), strict=True)):
        return Observation.of(
            "B5/partition", False, LARGEST_MEASURE, f"sizes {sizes} are not those of the blocks"
        )
    units = []
    for block in blocks:
        length = float(np.sqrt(np.square(block).sum()))
        units.append(block / length if length else block)
    return _same("B5/partition", row, np.concatenate(units), COUNTED)


CHECKS = (Check("features", PARTS, observe, families=("random",), share=20.0),)
