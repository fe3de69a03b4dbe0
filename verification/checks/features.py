"""B5 by cases: every block of the features against a direct computation on small pictures, and relations."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from convexperc.features import color, extraction
from convexperc.features import hog as shape
from convexperc.features import lbp as texture
from convexperc.features import pictures as images
from convexperc.features.configuration import BY_CHANNEL, JOINT, FeatureConfiguration
from convexperc.problem.problem import Problem
from verification.checks import pictures as direct
from verification.checks.interface import Check, Observation
from verification.checks.measures import LARGEST_MEASURE
from verification.checks.pictures import Numbers, Pixels
from verification.ledger.evidence import Outcome
from verification.problems.sources import Source

PARTS = ("B5/histogram", "B5/hog", "B5/lbp", "B5/partition")
COUNTED, DESCRIBED = 1e-14, 1e-14
"""Largest differences allowed of counts and entries of unit vectors, and of HOG values: all are at most 1 or
exact, and no more than some 50 roundings of 1.1e-16 are behind one."""
TURNED = 2e-6
"""Of the HOG of a turned or mirrored picture: the order of up to 64 sums in single precision changes."""
CELL = 8
"""Sides of pictures are multiples of it, so that cells fill them and a turned picture has the same cells."""
ODD = 9
"""Directions of which none begins at 90 degrees: a mirror image has the same ones in reverse order."""
DIM = 127
"""Gray values up to this can be doubled, or raised by as much as leaves them at most 255."""


def observe(problem: Problem, source: Source) -> Iterator[Observation]:
    """Draw a picture and a configuration; the problem gives nothing."""
    picture = _picture(source)
    settings = _configuration(source, picture.shape[0], picture.shape[1])
    gray, shift = _gray(picture), source.integer(1, 255 - DIM)
    counts, gradients = _histogram(picture, settings), direct.hog(gray, settings)
    found = np.asarray(color.color_histogram(picture, settings))
    yield _same("B5/histogram", found, counts, 0.0)
    yield _first_failure(_hogs(images.to_gray(picture), gray, gradients, settings, shift))
    yield _first_failure(_lbps(images.to_gray(picture), gray, settings, shift))
    patterns = _lbp(gray, settings)
    yield _partition(picture, settings, (counts, gradients, patterns))


def _first_failure(found: Iterator[Observation]) -> Observation:
    """The first that failed, or the first of all: what comes after a failure may rest on it."""
    first = next(found)
    return (
        first
        if first.outcome is Outcome.FAILED
        else next((each for each in found if each.outcome is Outcome.FAILED), first)
    )


def _hog(gray: Pixels, settings: FeatureConfiguration) -> Numbers:
    return np.asarray(shape.hog_descriptor(np.ascontiguousarray(gray), settings))


def _lbp(gray: Pixels, settings: FeatureConfiguration) -> Numbers:
    return np.asarray(texture.lbp_histogram(np.ascontiguousarray(gray), settings))


def _hogs(
    given: Pixels, gray: Pixels, true: Numbers, settings: FeatureConfiguration, shift: int
) -> Iterator[Observation]:
    """As computed directly; then turned by 180 degrees, mirrored, brightened by a constant, and constant."""
    part, upright = "B5/hog", _hog(gray, settings)
    yield _same(part, _hog(given, settings), true, DESCRIBED)
    yield _same(part, _blocks(_hog(gray[::-1, ::-1], settings), settings, 4), upright, TURNED)
    slope, odd = _slope(gray), replace(settings, hog_orientations=ODD)
    mirrored = _blocks(_hog(slope[:, ::-1], odd), odd, 2)
    yield _same(part, mirrored, _hog(slope, odd), TURNED)
    dim, plain = gray % (DIM + 1), replace(settings, hog_transform_sqrt=False)
    brighter = (dim + np.uint8(shift)).astype(np.uint8)
    yield _same(part, _hog(brighter, plain), _hog(dim, plain), 0.0)
    flat = np.full_like(gray, shift)
    yield _same(part, _hog(flat, settings), np.zeros_like(upright), 0.0)


def _blocks(descriptor: Numbers, settings: FeatureConfiguration, kind: int) -> Numbers:
    """The descriptor of the picture before it was turned (kind 4) or mirrored (kind 2)."""
    sides = zip(settings.working_size, settings.hog_cells_per_block, strict=True)
    down, across = (pixels // CELL - cells + 1 for pixels, cells in sides)
    blocks = descriptor.reshape(down, across, *settings.hog_cells_per_block, settings.hog_orientations)
    turned = blocks[::-1, ::-1, ::-1, ::-1] if kind == 4 else blocks[:, ::-1, :, ::-1, ::-1]
    return np.ascontiguousarray(turned).ravel()


def _slope(gray: Pixels) -> Pixels:
    """A picture without a horizontal gradient direction, which its mirror image would leave in the first bin.

    Each row is brighter than the one before by more than its texture; the first and the last row are flat.
    """
    steps = 6 * np.arange(gray.shape[0])[:, None] + gray % 5
    steps[0], steps[-1] = 0, 255
    return np.asarray(steps, dtype=np.uint8)


def _lbps(given: Pixels, gray: Pixels, settings: FeatureConfiguration, shift: int) -> Iterator[Observation]:
    """As computed directly; turned by 90 degrees, which moves every bit on by P/4; brightened; constant."""
    part = "B5/lbp"
    least, most = direct.lbp(gray, settings)
    yield _between(part, _lbp(given, settings), least, most)
    if settings.lbp_method == "default":
        least, most = (_quarter_turned(counts, settings.lbp_points) for counts in (least, most))
    size = settings.working_size[::-1]
    yield _between(part, _lbp(np.rot90(gray), replace(settings, working_size=size)), least, most)
    dim = gray % (DIM + 1)
    yield _same(part, _lbp(2 * dim, settings), _lbp(dim, settings), 0.0)
    least, most = direct.lbp(dim, settings)
    yield _between(part, _lbp((dim + np.uint8(shift)).astype(np.uint8), settings), least, most)
    flat = np.zeros(settings.lbp_bins)
    flat[settings.lbp_points if settings.lbp_method == "uniform" else -1] = most.sum()
    flat[flat > 0.0] = _lbp(gray, settings).sum()
    yield _same(part, _lbp(np.full_like(gray, shift), settings), flat, 0.0)


def _quarter_turned(counts: Numbers, points: int) -> Numbers:
    """Counts of all patterns, each with its bits moved on by a quarter."""
    turned, quarter, full = np.zeros_like(counts), points // 4, 2**points - 1
    for pattern, count in enumerate(counts):
        turned[(pattern << quarter | pattern >> points - quarter) & full] += count
    return turned


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
    points, method = source.choice((8, 4, 12)), source.choice(("uniform", "default"))
    histogram = source.choice((BY_CHANNEL, JOINT))
    return FeatureConfiguration(
        working_size=(height, width),
        color_histogram=histogram,
        color_bins=source.choice((8, 2, 32, 256) if histogram == BY_CHANNEL else (8, 2, 4, 16)),
        hog_orientations=source.choice((9, 6, 12)),
        hog_pixels_per_cell=(CELL, CELL),
        hog_cells_per_block=source.choice(((2, 2), (1, 1), (1, 2))),
        hog_block_norm=source.choice(("L2-Hys", "L2", "L1", "L1-sqrt")),
        hog_transform_sqrt=source.integer(0, 3) == 3,
        lbp_points=points,
        lbp_radius=source.choice((1.0, 2.0, 1.5)),
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


def _same(part: str, found: Numbers, true: Numbers, allowed: float) -> Observation:
    if found.shape != true.shape:
        return Observation.of(part, False, LARGEST_MEASURE, f"{found.shape} numbers, not {true.shape}")
    away = float(np.abs(found - true).max())
    detail = f"differs by {away!r} at number {int(np.abs(found - true).argmax())}"
    return Observation.of(part, away <= allowed, away, detail)


def _between(part: str, found: Numbers, least: Numbers, most: Numbers) -> Observation:
    """Counts within their bounds; the measure is what is outside."""
    if found.shape != least.shape:
        return Observation.of(part, False, LARGEST_MEASURE, f"{found.shape} numbers, not {least.shape}")
    outside = np.maximum(np.maximum(least - found, found - most), 0.0)
    detail = (
        f"{found[outside.argmax()]:g} of code {int(outside.argmax())}, not {least[outside.argmax()]:g} to "
    )
    return Observation.of(
        part, not outside.any(), float(outside.max()), detail + f"{most[outside.argmax()]:g}"
    )


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
