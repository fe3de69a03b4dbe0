"""Features of small gray pictures computed directly, from the definitions of the papers.

HOG: Dalal and Triggs, CVPR 2005; as in scikit-image, directions are unsigned, each pixel counts in one bin,
and sums are taken in single precision. LBP: Ojala, Pietikainen and Maenpaa, PAMI 2002. Nothing here calls an
image library.
"""

import math

import numpy as np
from numpy.typing import NDArray

from convexperc.features.configuration import FeatureConfiguration

EPSILON = 1e-5
"""Added to the sum of a block (L1), or in its square to the sum of squares (L2), against division by 0."""
CLIPPED = 0.2
"""L2-Hys cuts the entries of a block of length 1 at this value, and divides by the length again."""
UNIT = 10**5
"""Positions on the circle are rounded to five decimals, as scikit-image has them: integers in this unit."""

Pixels = NDArray[np.uint8]
Numbers = NDArray[np.float64]


def hog(gray: Pixels, settings: FeatureConfiguration) -> Numbers:
    """Histograms of gradients in cells, normalised in overlapping blocks; shape (blocks cells bins,)."""
    values = gray.astype(np.float64)
    cells = cell_histograms(np.sqrt(values) if settings.hog_transform_sqrt else values, settings)
    down, across = settings.hog_cells_per_block
    blocks = [
        normalised(cells[i : i + down, j : j + across], settings.hog_block_norm).ravel()
        for i in range(cells.shape[0] - down + 1)
        for j in range(cells.shape[1] - across + 1)
    ]
    return np.concatenate(blocks)


def cell_histograms(values: Numbers, settings: FeatureConfiguration) -> Numbers:
    """The mean magnitude by direction, shape (cells down, cells across, bins).

    The gradient is (f(y+1) - f(y-1), f(x+1) - f(x-1)), 0 at the border, and its direction is unsigned.
    """
    (height, width), bins = settings.hog_pixels_per_cell, settings.hog_orientations
    sums = np.zeros((values.shape[0] // height, values.shape[1] // width, bins), dtype=np.float32)
    for y in range(sums.shape[0] * height):
        for x in range(sums.shape[1] * width):
            rise = values[y + 1, x] - values[y - 1, x] if 0 < y < values.shape[0] - 1 else 0.0
            run = values[y, x + 1] - values[y, x - 1] if 0 < x < values.shape[1] - 1 else 0.0
            angle = math.degrees(math.atan2(rise, run)) % 180.0
            at = y // height, x // width, math.floor(angle * bins / 180.0)
            sums[at] = np.float32(float(sums[at]) + math.hypot(rise, run))
    return sums.astype(np.float64) / (height * width)


def normalised(block: Numbers, norm: str) -> Numbers:
    """Divide a block by its norm."""
    if norm in ("L1", "L1-sqrt"):
        found = block / (math.fsum(block.ravel()) + EPSILON)
        return np.sqrt(found) if norm == "L1-sqrt" else found
    found = block / math.sqrt(math.fsum((block**2).ravel()) + EPSILON**2)
    if norm == "L2":
        return found
    cut = np.minimum(found, CLIPPED)
    return np.asarray(cut / math.sqrt(math.fsum((cut**2).ravel()) + EPSILON**2))


def lbp(gray: Pixels, settings: FeatureConfiguration) -> tuple[Numbers, Numbers]:
    """Bounds of the number of pixels of each code: equal but for pixels with a bit that rounding decides."""
    rim, circle = math.ceil(settings.lbp_radius), neighbours(settings.lbp_points, settings.lbp_radius)
    least, most = np.zeros(settings.lbp_bins), np.zeros(settings.lbp_bins)
    values = gray.tolist()
    for y in range(rim, gray.shape[0] - rim):
        for x in range(rim, gray.shape[1] - rim):
            patterns: list[tuple[bool, ...]] = [()]
            for corners in circle:
                bits = _bits(values, y, x, corners)
                patterns = [(*known, bit) for known in patterns for bit in bits]
            codes = {code(bits, settings.lbp_method) for bits in patterns}
            for each in codes:
                most[each] += 1.0
                least[each] += len(codes) == 1
    return least, most


def code(bits: tuple[bool, ...], method: str) -> int:
    """The code of a pattern: all bits; or how many are set, P + 1 where they change more than twice."""
    if method == "default":
        return sum(bit << p for p, bit in enumerate(bits))
    changes = sum(bits[p] != bits[p - 1] for p in range(len(bits)))
    return sum(bits) if changes <= 2 else len(bits) + 1


Corners = list[tuple[int, int, int]]
"""Rows down and columns right of the centre, and the share in bilinear interpolation, in units of UNIT^-2."""


def neighbours(points: int, radius: float) -> list[Corners]:
    """The places (-R sin 2 pi p/P, R cos 2 pi p/P) by the pixels around them, those of share 0 left out."""
    angles = [2.0 * math.pi * p / points for p in range(points)]
    places = [(_around(-radius * math.sin(angle)), _around(radius * math.cos(angle))) for angle in angles]
    return [
        [(r, c, share * part) for r, share in rows for c, part in columns if share * part]
        for rows, columns in places
    ]


def _around(place: float) -> list[tuple[int, int]]:
    low, above = divmod(round(place * UNIT), UNIT)
    return [(low, UNIT - above), (low + 1, above)]


def _bits(values: list[list[int]], y: int, x: int, corners: Corners) -> tuple[bool, ...]:
    """Whether a neighbour is at least as bright as the centre; both where an uneven mean equals it."""
    away = [values[y + r][x + c] - values[y][x] for r, c, _ in corners]
    total = sum(share * difference for (_, _, share), difference in zip(corners, away, strict=True))
    return (True, False) if total == 0 and any(away) else (total >= 0,)
