"""A point at which an objective is smaller, sought in float64; F there is then computed exactly."""

from collections.abc import Iterator, Mapping
from fractions import Fraction
from typing import Any

import numpy as np
from flint import arb, fmpq
from numpy.typing import NDArray
from scipy.optimize import minimize

from verification.exact.balls import Numbers
from verification.reweighted.objectives.objective import Objective, rational_point

Floats = NDArray[np.float64]
DIGITS = (0, 1, 2, 6, 12)
"""To which a coordinate is rounded, relative to the largest, if that does not make F larger."""

CLEAR = 1e-3
"""Share of F by which a point has to be better for no other to be sought."""

SETTINGS = {"maxiter": 4000, "maxfev": 8000, "adaptive": True}
"""Of Nelder and Mead's method."""


def better_point(objective: Objective, point: Mapping[str, Numbers]) -> dict[str, Numbers]:
    """A rational point at which F is probably smaller than at the given one; no claim that it is a minimum.

    Parameters
    ----------
    objective : Objective
    point : mapping of str to Numbers

    Returns
    -------
    dict of str to Numbers
        A zero of one of the residuals if F is clearly smaller there, else where a search from the point ends.
    """
    names = list(point)
    cuts = np.cumsum([len(point[name]) for name in names])[:-1]

    def split(z: Floats) -> dict[str, Floats]:
        return dict(zip(names, np.split(z, cuts), strict=True))

    def value(z: Floats) -> float:
        found = objective.in_floats(split(z))
        return found if np.isfinite(found) else 1e300

    start = np.concatenate([_floats(point[name]) for name in names])
    best = min([start, *_zeros(objective, names)], key=value)
    if not value(best) < (1.0 - CLEAR) * value(start):
        best = _searched(value, best)
    rounded = next((z for z in _rounded(best) if value(z) <= value(best)), best)
    return rational_point({name: [_decimal(x) for x in part] for name, part in split(rounded).items()})


def _floats(values: Numbers) -> Floats:
    return np.array(
        [float(x.mid()) if isinstance(x, arb) else int(x.p) / int(x.q) for x in values], dtype=float
    )


def _decimal(x: float) -> Fraction:
    return Fraction(str(float(x)))


def _zeros(objective: Objective, names: list[str]) -> Iterator[Floats]:
    """Points of least norm at which one residual is 0, or as small as it can be."""
    for part in objective.parts:
        columns = [part.affine.parts.get(name) for name in names]
        blocks = [
            np.zeros((part.affine.size, objective.sizes[name])) if matrix is None else matrix.astype(float)
            for name, matrix in zip(names, columns, strict=True)
        ]
        yield np.linalg.lstsq(np.hstack(blocks), -part.affine.constant.astype(float), rcond=None)[0]


def _searched(value: Any, start: Floats) -> Floats:
    """Nelder and Mead's method from a point, three times from where it ended."""
    best, scale = start, float(np.abs(start).max()) or 1.0
    for _ in range(3):
        simplex = np.vstack([best, *(best + scale * row for row in np.eye(len(best)))])
        options = SETTINGS | {
            "initial_simplex": simplex,
            "xatol": 1e-12 * scale,
            "fatol": 1e-14 * value(best),
        }
        found = minimize(value, best, method="Nelder-Mead", options=options).x
        best = min((best, found), key=value)
    return best


def _rounded(point: Floats) -> Iterator[Floats]:
    largest = float(np.abs(point).max())
    power = 0 if largest == 0.0 else int(np.floor(np.log10(largest)))
    for digits in DIGITS:
        yield np.array([round(float(x), digits - power) for x in point])


def is_less(first: Any, second: Any, share: Fraction) -> bool:
    """Whether first (1 + share) < second, beyond doubt."""
    return bool(arb(first) * (1 + fmpq(share.numerator, share.denominator)) < arb(second))
