"""The two cars: a saloon and an estate, lofted from their side profiles."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from jaxtyping import Float

from convexperc.simulation.parts import Part, Point, blob, both_sides, box, disc
from convexperc.simulation.skins import hull, loft

Profile = tuple[tuple[float, float], ...]
"""Points (y, z) in metres; the nose points to +y."""

WHEEL_RADIUS = 0.34
"""Outer radius of a tyre, in metres."""
ARCH_RADIUS = 0.41
"""Radius of a wheel arch, in metres."""
FLOOR_HEIGHT = 0.22
"""Height of the lower edge of the body, in metres."""
BELT_HEIGHT = 0.93
"""Height of the belt line, above which the cabin narrows, in metres."""
HALF_WIDTH = 0.89
"""Half the width of the body, in metres."""


@dataclass(frozen=True, slots=True)
class CarStyle:
    """The side view of a car.

    Attributes
    ----------
    deck : Profile
        Upper edge of the body from tail to nose: boot, belt line, bonnet.
    roof : Profile
        Upper edge of the cabin, from the foot of the rear window to the foot of the windscreen; the rear
        window spans its first three points, the windscreen its last three.
    axles : tuple of float
        y of the rear and of the front axle, in metres.
    windows : tuple of Profile
        Outlines of the side windows, convex.
    gaps : tuple of float
        y of the vertical gaps around the doors, in metres.
    """

    deck: Profile
    roof: Profile
    axles: tuple[float, float]
    windows: tuple[Profile, ...]
    gaps: tuple[float, ...]

    def cabin_half_width(self, z: float) -> float:
        """Return half the width of the cabin at height `z`, both in metres: the sides lean inwards."""
        height = max(top for _, top in self.roof)
        return 0.82 - 0.2 * (z - BELT_HEIGHT) / (height - BELT_HEIGHT)


SALOON = CarStyle(
    deck=(
        (-2.28, 0.62), (-2.24, 0.86), (-2.12, 0.97), (-1.6, 1.0), (-0.4, 0.96), (0.9, 0.95),
        (1.3, 0.91), (1.8, 0.83), (2.08, 0.73), (2.22, 0.62), (2.28, 0.5),
    ),
    roof=(
        (-1.75, 0.99), (-1.4, 1.16), (-1.02, 1.34), (-0.6, 1.42), (-0.1, 1.44), (0.22, 1.40), (0.55, 1.24),
        (1.08, 0.95),
    ),
    axles=(-1.36, 1.4),
    windows=(
        ((0.86, 0.99), (0.52, 1.19), (0.2, 1.345), (-0.22, 1.38), (-0.25, 0.99)),
        ((-0.33, 0.99), (-0.31, 1.38), (-0.6, 1.36), (-1.0, 1.28), (-1.38, 1.1), (-1.46, 1.01)),
    ),
    gaps=(-1.02, -0.26, 0.88),
)  # fmt: skip
"""A saloon 4.6 m long."""

ESTATE = CarStyle(
    deck=(
        (-2.2, 0.62), (-2.18, 0.9), (-2.12, 1.02), (-1.6, 1.03), (-0.4, 1.01), (0.9, 1.0),
        (1.3, 0.98), (1.75, 0.93), (2.02, 0.84), (2.14, 0.7), (2.18, 0.55),
    ),
    roof=(
        (-2.14, 1.0), (-2.02, 1.34), (-1.86, 1.58), (-1.5, 1.63), (-0.4, 1.66), (0.1, 1.62), (0.42, 1.47),
        (1.02, 1.0),
    ),
    axles=(-1.32, 1.34),
    windows=(
        ((0.82, 1.06), (0.4, 1.4), (0.12, 1.53), (-0.2, 1.57), (-0.22, 1.06)),
        ((-0.31, 1.06), (-0.3, 1.57), (-1.12, 1.55), (-1.14, 1.06)),
        ((-1.23, 1.07), (-1.22, 1.54), (-1.72, 1.48), (-1.92, 1.1)),
    ),
    gaps=(-1.0, -0.23, 0.88),
)  # fmt: skip
"""An estate 4.4 m long."""


def car(style: CarStyle, paint: str) -> Iterator[Part]:
    """Yield the parts of a car that stands on z = 0 with its nose to +y and its right side to +x.

    Parameters
    ----------
    style : CarStyle
        `SALOON`, `ESTATE` or another one.
    paint : str
        Material of the body.
    """
    yield _body(style, paint)
    yield _cabin(style, paint)
    yield box("rubber", (1.5, 3.9, 0.5), (0.0, 0.0, 0.47))
    yield from both_sides(list(_side(style, paint)))
    yield from _pane(style, style.roof[:3])
    yield from _pane(style, style.roof[:-4:-1])
    yield from _ends(style)
    for y in style.axles:
        yield from both_sides(list(_wheel(y)))


def _body(style: CarStyle, paint: str) -> Part:
    """Skin of the body below the cabin: one ring of twelve corners a station."""
    y = _stations(style)
    deck = np.array(style.deck)
    top = np.interp(y, deck[:, 0], deck[:, 1])
    bottom = np.minimum(_sill(style, y), top - 0.06)
    tail, nose = deck[0, 0], deck[-1, 0]
    width = HALF_WIDTH * (1 - 0.2 * np.abs((2 * y - tail - nose) / (nose - tail)) ** 5)
    waist = np.maximum(0.5, bottom + 0.01)
    shoulder = 0.4 * (waist + 0.01) + 0.6 * (top - 0.06)
    levels = [bottom, waist, shoulder, top - 0.02, top, top + 0.015]
    shares = [0.95, 1.0, 0.985, 0.955, 0.90, 0.5]
    right = [
        np.stack([share * width, y, np.minimum(z, levels[-1])], -1)
        for share, z in zip(shares, levels, strict=True)
    ]
    left = [corner * np.array([-1.0, 1.0, 1.0]) for corner in reversed(right)]
    return loft(paint, np.stack(right + left, axis=1))


def _stations(style: CarStyle) -> Float[np.ndarray, " stations"]:
    """Choose where to cut the body: at the deck's knots, and closely along the wheel arches."""
    knots = np.array([y for y, _ in style.deck])
    arcs = [axle - ARCH_RADIUS * np.cos(np.linspace(0, np.pi, 19)) for axle in style.axles]
    lips = [axle + side * (ARCH_RADIUS + 1e-3) for axle in style.axles for side in (-1, 1)]
    return np.unique(np.concatenate([knots, *arcs, lips, np.linspace(-2.0, 2.0, 9)]))


def _sill(style: CarStyle, y: Float[np.ndarray, " stations"]) -> Float[np.ndarray, " stations"]:
    """Lower edge of the body, interrupted by the wheel arches."""
    lowest: Float[np.ndarray, " stations"] = FLOOR_HEIGHT + 0.1 * np.clip((np.abs(y) - 1.9) / 0.35, 0.0, 1.0)
    for axle in style.axles:
        inside = ARCH_RADIUS**2 - (y - axle) ** 2
        arch = WHEEL_RADIUS + np.sqrt(np.maximum(inside, 0.0))
        lowest = np.where(inside >= -1e-12, np.maximum(lowest, arch), lowest)
    return lowest


def _cabin(style: CarStyle, paint: str) -> Part:
    rings = []
    for y, z in style.roof:
        eave = max(z - 0.05, 0.9)
        side = [(style.cabin_half_width(level), y, level) for level in (0.88, eave)]
        side += [(style.cabin_half_width(z) - 0.07, y, z), (0.3, y, z + 0.02)]
        rings.append(side + [(-a, b, c) for a, b, c in reversed(side)])
    return loft(paint, np.array(rings))


def _side(style: CarStyle, paint: str) -> Iterator[Part]:
    """Yield what the right side has and, mirrored, the left: windows, doors, sill trim, mirror."""
    for outline in style.windows:
        edge = [(style.cabin_half_width(z), y, z) for y, z in outline]
        yield hull("glass", [(x + depth, y, z) for x, y, z in edge for depth in (-0.03, 0.008)])
    for y in style.gaps:
        yield box("seam", (0.02, 0.012, 0.5), (0.878, y, 0.62))
    for y in style.gaps[:2]:
        yield box("chrome", (0.03, 0.16, 0.03), (0.885, y + 0.14, 0.82))
    yield box("rubber", (0.06, 1.9, 0.09), (0.845, 0.02, 0.255))
    yield blob(paint, (0.2, 0.12, 0.15), (0.93, 0.72, 1.02))


def _pane(style: CarStyle, line: Profile) -> Iterator[Part]:
    """Yield the windscreen or the rear window: one slab a segment of `line`, from foot to head."""
    points = np.array(line)
    points[0] += 0.1 * (points[1] - points[0])
    points[-1] -= 0.15 * (points[-1] - points[-2])
    for low, high in pairwise(points):
        normal = np.array([low[1] - high[1], high[0] - low[0]]) / np.hypot(*(high - low))
        normal = normal if normal[1] > 0 else -normal
        corners: list[Point] = []
        for end in (low, high):
            half = style.cabin_half_width(float(end[1])) - 0.09
            for y, z in (end + 0.03 * normal, end - 0.03 * normal):
                corners += [(side * half, float(y), float(z)) for side in (-1, 1)]
        yield hull("glass", corners)


def _ends(style: CarStyle) -> Iterator[Part]:
    """Yield lamps, grille, bumper trim and number plates."""
    tail, nose = style.deck[0][0], style.deck[-1][0]
    lamps = [
        blob("lamp", (0.38, 0.3, 0.12), (0.6, nose - 0.14, 0.66)),
        box("lamp", (0.14, 0.04, 0.06), (0.62, nose - 0.04, 0.4)),
        box("tail-lamp", (0.28, 0.1, 0.16), (0.62, tail + 0.05, 0.78), (0.0, 0.0, -12.0)),
    ]
    yield from both_sides(lamps)
    yield box("seam", (0.62, 0.08, 0.08), (0.0, nose - 0.045, 0.6), (24.0, 0.0, 0.0))
    yield box("rubber", (0.8, 0.06, 0.16), (0.0, nose - 0.01, 0.45))
    yield box("plate", (0.46, 0.02, 0.1), (0.0, nose + 0.025, 0.44))
    yield box("rubber", (1.3, 0.06, 0.12), (0.0, tail + 0.01, 0.42))
    yield box("plate", (0.46, 0.02, 0.1), (0.0, tail - 0.015, 0.6))


def _wheel(y: float) -> Iterator[Part]:
    """Yield one wheel on the right side: tyre, rim, five spokes, hub."""
    x, z = 0.76, WHEEL_RADIUS
    yield disc("rubber", WHEEL_RADIUS, 0.22, (x, y, z))
    yield disc("rim", 0.235, 0.22, (x + 0.004, y, z))
    yield disc("seam", 0.2, 0.22, (x + 0.008, y, z))
    for angle in (90.0, 162.0, 234.0, 306.0, 378.0):
        radial = np.radians(angle)
        centre = (x + 0.105, y + 0.11 * float(np.cos(radial)), z + 0.11 * float(np.sin(radial)))
        yield box("rim", (0.04, 0.2, 0.055), centre, (angle, 0.0, 0.0))
    yield disc("rim", 0.06, 0.26, (x, y, z))
