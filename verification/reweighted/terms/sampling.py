"""Functions of which no formula is known: sampled in short windows at many scales, with their rounding.

Rounding is not assumed but estimated: fourth differences at points 2**-12 apart vanish for a smooth
function up to about 1e-13 of it, so that what they leave is noise (Moré and Wild 2011). Where a function is
a difference of larger numbers, such as 1 - exp(-r**2) at small r, it is constant between its steps and
shows no noise: what most of an octave shows, or two successive windows, is taken for its neighbours as well,
and `COARSE`.
"""

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from convexperc.errors import InputError

OCTAVES = range(-40, 40)
"""Sizes of residuals: 2**-40 to 2**40, about 1e-12 to 1e12."""

WINDOWS = 8
"""Of one octave."""

POINTS = 7
"""Of one window."""

STEP = 2.0**-12
"""Between the points of a window, as a part of the first."""

MARGIN = 32.0
"""By how much the estimated noise is multiplied before anything is said against a function."""

RESOLVED = 1e9
"""A function is resolved in an octave if its change (a loss) or its values (a weight) are so many times its
noise; else its neighbours get the noise too. A part of a sum whose steps hide in the windows of an octave is
then at most 5e-6 of the whole: it changes by 1500 steps in an octave where the windows show them."""

REACH = 3 * WINDOWS
"""How many windows away noise is taken for there that shows in two successive windows, but not in most of an
octave: three octaves, as far as weights are compared with one another."""

SEEN = 1e-3
"""A fourth difference that is a greater part of change or values is no rounding, and is not handed on."""

ROUNDING = 8.0
"""Of each value at least, in units of the rounding of its type."""

COARSE = 1e-6
"""Of each value of a loss, relative, where two neighbours are equal: larger numbers may have cancelled."""

TRIED = (0.3, 1.7, 23.0)
"""Residuals at which calls with an array and with single numbers are compared."""

Function = Callable[[Any], Any]
"""Of a residual, as a float or an array of floats."""


def grid() -> np.ndarray:
    """The points, shape (octaves, windows, points), positive and increasing; none is a power of 2."""
    octaves = np.exp2(np.array(OCTAVES, dtype=float))[:, None, None]
    starts = np.exp2((np.arange(WINDOWS) + 0.3819660112501051) / WINDOWS)[None, :, None]
    return np.asarray(octaves * starts * (1.0 + STEP * np.arange(POINTS))[None, None, :])


GRID = grid()


@dataclass(frozen=True)
class Samples:
    """A function on `GRID`, on one side of 0.

    Attributes
    ----------
    values : array, shape of GRID
        NaN where it is not finite or raised an exception.
    noise : array of shape (octaves, windows)
        Bound on the rounding of a value that is taken in each window, see the module.
    """

    values: np.ndarray
    noise: np.ndarray


def callable_on_arrays(function: Function, sign: float = 1.0) -> Function:
    """The function as one of an array, value by value where it takes no arrays.

    Raises
    ------
    InputError
        Of one number it does not return one real number, at any of the points tried.
    """
    tried = sign * np.array(TRIED)
    single = [_one(function, each) for each in tried]
    if all(value is None for value in single):
        raise InputError(
            getattr(function, "__name__", "function"),
            value=f"no number at {', '.join(map(str, tried))}",
            must="must return one real number for one residual",
        )
    try:
        with quiet():
            found = np.asarray(function(tried.copy()), dtype=float)
    except Exception:  # a foreign function may raise anything for an array
        found = np.empty(0)
    wanted = np.array([np.nan if value is None else value for value in single])
    if found.shape == tried.shape and np.allclose(found, wanted, rtol=1e-12, atol=0.0, equal_nan=True):
        return lambda points: _array(function, points)
    return lambda points: _one_by_one(function, points)


def value_at(function: Function, residual: float) -> float | str:
    """The value at one residual, or what was raised."""
    try:
        with quiet():
            return _number(function, residual)
    except Exception as error:  # a foreign function may raise anything
        return type(error).__name__


def sampled(function: Function, sign: float, resolution: str) -> Samples:
    """Sample a function on one side of 0.

    Parameters
    ----------
    function : callable
        Of arrays; see `callable_on_arrays`.
    sign : float
        1 or -1.
    resolution : {"change", "value"}
        What is compared with the noise, for a loss or a weight.
    """
    returned = function(sign * GRID.ravel())
    kind = np.finfo(returned.dtype if returned.dtype.kind == "f" else float)
    values = np.asarray(returned, dtype=float).reshape(GRID.shape)
    values = np.where(np.isfinite(values), values, np.nan)
    return Samples(values, _noise(values, resolution, float(kind.eps), float(kind.smallest_subnormal)))


def _noise(values: np.ndarray, resolution: str, epsilon: float, smallest: float) -> np.ndarray:
    """For each window a bound on the rounding of its values, of a type with these smallest numbers."""
    flat = values.reshape(len(OCTAVES), -1)
    with np.errstate(all="ignore"):
        left = np.abs(np.diff(values, n=4, axis=2)) / np.sqrt(70.0)
        own = np.nan_to_num(left.max(axis=2))
        left = left.reshape(len(OCTAVES), -1)
        padded = np.vstack([left[:1], left, left[-1:]])
        near = np.sort(np.hstack([padded[:-2], padded[1:-1], padded[2:]]), axis=1)  # NaN last
        quartile = 3 * np.isfinite(near).sum(axis=1, keepdims=True) // 4
        seen = np.nan_to_num(np.take_along_axis(near, quartile, axis=1)[:, 0])
        largest = np.nan_to_num(np.fmax.reduce(np.abs(flat), axis=1))
        change = np.nan_to_num(np.fmax.reduce(flat, axis=1) - np.fmin.reduce(flat, axis=1))
        tied = (values[..., 1:] == values[..., :-1]).any(axis=2) & (resolution == "change")
    size = change if resolution == "change" else largest
    sizes, relative = size[:, None], (epsilon * largest)[:, None]
    lasting = _lasting(own.ravel()).reshape(own.shape)
    lasting = np.where((lasting <= SEEN * sizes) & (lasting > relative), lasting, 0.0)
    near = np.lib.stride_tricks.sliding_window_view(np.pad(lasting.ravel(), REACH), 2 * REACH + 1).max(axis=1)
    near = np.maximum(near.reshape(own.shape), _step(values, relative) if resolution == "change" else 0.0)
    near = np.where(sizes >= RESOLVED * near, 0.0, near)
    pooled = np.maximum(_spread(seen, size, epsilon * largest)[:, None], near)
    least = np.where(tied, max(COARSE, ROUNDING * epsilon), ROUNDING * epsilon)
    return np.asarray(MARGIN * np.maximum(own, pooled) + least * largest[:, None] + ROUNDING * smallest)


def _lasting(noise: np.ndarray) -> np.ndarray:
    """Of two successive windows the smaller noise: a kink of the function is in one of them alone."""
    lasting = np.minimum(noise[1:], noise[:-1])
    return np.asarray(np.maximum(np.append(lasting, 0.0), np.append(0.0, lasting)))


def _step(values: np.ndarray, relative: np.ndarray) -> float:
    """The least change between two successive windows of one value each, beyond rounding; 0 if there is none.

    A function that is rounded to some decimals is so where it is nearly flat.
    """
    flat = (values == values[..., :1]).all(axis=2).ravel()
    changes = np.abs(np.diff(values[..., 0].ravel()))
    seen = changes[flat[1:] & flat[:-1] & (changes > np.repeat(relative, WINDOWS)[1:])]
    return float(seen.min()) if seen.size else 0.0


def _spread(noise: np.ndarray, size: np.ndarray, relative: np.ndarray) -> np.ndarray:
    """Noise of each octave, or that of a neighbour that is not resolved, from octave to octave.

    What is not more than `relative`, the rounding of the values of each octave themselves, is not handed on.
    """
    last = len(noise) - 1
    found, sizes = noise.tolist(), size.tolist()
    own = np.where((noise <= SEEN * size) & (noise > relative), noise, 0.0).tolist()
    for step, order in ((1, range(last)), (-1, range(last, 0, -1))):
        handed = 0.0
        for octave in order:
            handed = max(handed, own[octave])
            if sizes[octave] >= RESOLVED * handed:
                handed = 0.0
            found[octave + step] = max(found[octave + step], handed)
    return np.array(found)


def _array(function: Function, points: np.ndarray) -> np.ndarray:
    with quiet():
        return np.asarray(function(np.array(points)))


def _one_by_one(function: Function, points: np.ndarray) -> np.ndarray:
    found = []
    with quiet():
        for each in np.ravel(points):
            try:
                found.append(_number(function, each))
            except Exception:  # a foreign function may raise anything
                found.append(np.nan)
    return np.array(found).reshape(np.shape(points))


def _one(function: Function, residual: float) -> float | None:
    found = value_at(function, float(residual))
    return None if isinstance(found, str) else found


def _number(function: Function, residual: float) -> float:
    """One number for one residual; some functions take arrays only."""
    try:
        found = np.asarray(function(float(residual)))
    except ArithmeticError:
        raise
    except Exception:  # a foreign function may raise anything for a number
        found = np.asarray(function(np.array([float(residual)])))
    if found.size != 1 or found.dtype.kind not in "biuf":
        raise TypeError("not one real number")
    return float(found.reshape(()))


class quiet(warnings.catch_warnings):  # noqa: N801 - a context manager
    """No warnings of foreign functions: what is not finite is seen in the values."""

    def __enter__(self) -> Any:
        self._floats = np.errstate(all="ignore")
        self._floats.__enter__()
        found = super().__enter__()
        warnings.simplefilter("ignore")
        return found

    def __exit__(self, *about: Any) -> None:
        super().__exit__(*about)
        self._floats.__exit__(*about)
