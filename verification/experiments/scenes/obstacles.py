"""Obstacles composed into photographs: a board or a box before the object, of plain or grained material."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from convexperc.errors import InputError
from verification.experiments.scenes.pictures import Mask, Picture, obstruction

PARTIAL = (0.3, 0.7)
"""Range of the share of the object that is left to be seen in a partly obstructed view."""
COLOURS = ((176, 138, 92), (120, 120, 124), (142, 62, 48), (66, 92, 70), (214, 206, 190), (58, 62, 78))
"""Cardboard, concrete, brick, a green board, a white one, a dark one."""
MARGIN = 0.04
"""By how much an obstacle may stand out beyond the object, as a share of the picture's longer side."""
RIM = 0.7
"""Brightness of an obstacle's edge, as a share of its face's."""


class Box(NamedTuple):
    """Rows top..bottom and columns left..right, the last of each left out."""

    top: int
    bottom: int
    left: int
    right: int


@dataclass(frozen=True, slots=True, eq=False)
class Covered:
    """A photograph with an obstacle.

    Attributes
    ----------
    picture : uint8 (h, w, 3)
    mask : bool (h, w)
        What is still seen of the object.
    visible_share : float
    """

    picture: Picture
    mask: Mask
    visible_share: float


def cover_fully(picture: Picture, mask: Mask, rng: np.random.Generator) -> Covered:
    """Put an obstacle before the whole object."""
    return _covered(picture, mask, _grown(_bounds(mask), mask.shape, rng), rng)


def cover_partly(picture: Picture, mask: Mask, rng: np.random.Generator) -> Covered:
    """Put an obstacle before a part of the object, from the left, from the right, or from below.

    Raises
    ------
    InputError
        No obstacle leaves part of the object: its mask is too small.
    """
    low, high = PARTIAL
    target = rng.uniform(low, high)
    for side in rng.permutation(3):
        box = _cut(mask, _grown(_bounds(mask), mask.shape, rng), int(side), target)
        found = _covered(picture, mask, box, rng)
        if obstruction(found.visible_share) == "partial":
            return found
    remedy = "Leave the picture out, or draw its mask again."
    raise InputError("mask", value=int(mask.sum()), must="must be large enough to be covered", remedy=remedy)


def _bounds(mask: Mask) -> Box:
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    return Box(int(rows[0]), int(rows[-1]) + 1, int(columns[0]), int(columns[-1]) + 1)


def _grown(box: Box, size: tuple[int, ...], rng: np.random.Generator) -> Box:
    """A box a little larger on every side, within the picture."""
    height, width = size
    more = rng.uniform(0.25, 1.0, 4) * MARGIN * max(size)
    up, down, left, right = (int(np.ceil(value)) for value in more)
    top, bottom = max(0, box.top - up), min(height, box.bottom + down)
    return Box(top, bottom, max(0, box.left - left), min(width, box.right + right))


def _cut(mask: Mask, box: Box, side: int, target: float) -> Box:
    """The part of a box, from one side on, that leaves about the target's share of the object."""
    counts = mask.sum(axis=1 if side == 2 else 0)
    hidden = np.cumsum(counts) / counts.sum()
    if side == 0:
        edge = int(np.argmin(np.abs(hidden - (1.0 - target)))) + 1
        return box._replace(right=max(edge, box.left + 1))
    edge = int(np.argmin(np.abs(hidden - target))) + 1
    if side == 1:
        return box._replace(left=min(edge, box.right - 1))
    return box._replace(top=min(edge, box.bottom - 1))


def _covered(picture: Picture, mask: Mask, box: Box, rng: np.random.Generator) -> Covered:
    top, bottom, left, right = box
    drawn, shown = picture.copy(), mask.copy()
    drawn[top:bottom, left:right] = _face(bottom - top, right - left, rng)
    shown[top:bottom, left:right] = False
    return Covered(drawn, shown, float(shown.sum() / mask.sum()))


def _face(height: int, width: int, rng: np.random.Generator) -> Picture:
    """An obstacle's face: a colour, brighter to one side, a material, and a darker rim."""
    colour = np.array(COLOURS[int(rng.integers(len(COLOURS)))], dtype=np.float64)
    dark, bright = (0.85, 1.1) if rng.random() < 0.5 else (1.1, 0.85)
    light = np.tile(np.linspace(dark, bright, width), (height, 1))
    material = MATERIALS[int(rng.integers(len(MATERIALS)))]
    face = colour * (light * material(height, width, rng))[..., None]
    edge = max(1, min(height, width) // 40)
    inner = np.zeros((height, width), dtype=np.bool_)
    inner[edge : height - edge, edge : width - edge] = True
    face[~inner] *= RIM
    face += rng.normal(0.0, 2.0, (height, width, 1))
    return np.asarray(np.clip(np.rint(face), 0, 255).astype(np.uint8))


def _plain(height: int, width: int, rng: np.random.Generator) -> NDArray[np.float64]:
    return np.ones((height, width))


def _grained(height: int, width: int, rng: np.random.Generator) -> NDArray[np.float64]:
    """Wood: waves along the height, bent a little across the width."""
    wave, bend, phase = rng.uniform(6.0, 14.0), rng.uniform(2.0, 6.0), rng.uniform(0.0, 2.0 * np.pi)
    rows, columns = np.mgrid[0:height, 0:width]
    swing = columns + bend * np.sin(2.0 * np.pi * rows / max(height, 2))
    return np.asarray(1.0 + 0.12 * np.sin(2.0 * np.pi * swing / wave + phase))


def _taped(height: int, width: int, rng: np.random.Generator) -> NDArray[np.float64]:
    """A carton: a strip of tape across, at some height."""
    shade = np.ones((height, width))
    start = int(rng.uniform(0.2, 0.7) * height)
    shade[start : start + max(1, height // 10)] = 1.25
    return shade


MATERIALS: tuple[Callable[[int, int, np.random.Generator], NDArray[np.float64]], ...] = (
    _plain,
    _grained,
    _taped,
)
