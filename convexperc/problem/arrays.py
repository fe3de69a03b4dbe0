"""Input validation: arrays are checked and copied once, to finite, read-only float64."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from jaxtyping import Float
from numpy.typing import NDArray

from convexperc.errors import InputError, PointError, ProblemError
from convexperc.problem.conversion import (
    MUST_BE_EXACT,
    ROUND,
    changed,
    is_negative,
    real_number,
    real_source,
)

Vector = Float[np.ndarray, " n"]
"""One number a view."""
FeatureVector = Float[np.ndarray, " d"]
"""One number a feature."""
Matrix = Float[np.ndarray, "n d"]

BLOCK = 2**19
"""Numbers that are worked on at a time, 4 MB: what a processor keeps near."""
NORMAL_EXPONENT = 1022
"""2^e is a normal float for |e| below this."""


def real_array(
    value: Any, name: str, ndim: int, *, error: type[InputError] = ProblemError, finite: bool = True
) -> NDArray[np.float64]:
    """Copy `value` to a read-only, C-contiguous float64 array of `ndim` dimensions.

    Parameters
    ----------
    value : array_like
        Real numbers that float64 holds: booleans, integers or floats.
    name : str
        How an error names the array.
    ndim : int
        Required number of dimensions.
    error : type of InputError
        Raised on a value that cannot be used.
    finite : bool
        Refuse NaN and infinity (the default).

    Returns
    -------
    ndarray of float64, read-only

    Raises
    ------
    InputError
        Complex numbers, strings, objects, masked entries, ragged nesting, wrong dimension, NaN or infinity,
        or a finite number that float64 does not hold exactly.
    """
    source = real_source(value, name, error)
    if source.ndim != ndim:
        raise error(
            name, value=source.shape, must=f"must have {ndim} dimension(s)", remedy="Check its shape."
        )
    if source.dtype == np.float64:
        array = np.array(source, order="C", copy=True)
    else:
        with np.errstate(over="ignore", invalid="ignore"):
            array = np.array(source, dtype=np.float64, order="C", copy=True)
    square = float(np.vdot(array, array))  # finite only if every entry is; an overflow is looked at below
    bad = np.False_ if math.isfinite(square) else ~np.isfinite(array)
    if bad.any() and (finite or np.isfinite(source[bad].astype(np.longdouble)).any()):
        index = tuple(int(i) for i in np.argwhere(bad)[0])
        raise error(
            f"{name}[{', '.join(map(str, index))}]",
            value=source[index],
            must="must be finite in float64",
            remedy=f"{int(bad.sum())} of {array.size} entries are NaN, infinite or too large; clean them.",
        )
    wrong = None if source.dtype == np.float64 else changed(array, source)
    if wrong is not None and wrong.any():
        index = tuple(int(i) for i in np.argwhere(wrong)[0])
        place = f"{name}[{', '.join(map(str, index))}]"
        raise error(place, value=source[index], must=MUST_BE_EXACT, remedy=ROUND)
    array.flags.writeable = False
    return array


def point_entries(value: Any, length: int, name: str, *, finite: bool) -> NDArray[np.float64]:
    """Copy one part of a point (w, u) or (a, b) to a float64 array of the `length` that fits the problem.

    Raises
    ------
    PointError
        As `real_array`, or a wrong length.
    """
    array = real_array(value, name, 1, error=PointError, finite=finite)
    if array.shape != (length,):
        raise PointError(name, value=array.shape, must=f"must have shape ({length},) to fit the problem")
    return array


def euclidean_length(x: NDArray[np.float64]) -> float:
    """||x||_2, safe against overflow and underflow."""
    largest = float(np.abs(x).max(initial=0.0))
    if largest == 0.0 or not np.isfinite(largest):
        return largest
    return float(np.linalg.norm(x / largest)) * largest


def lowest(values: NDArray[np.float64]) -> float:
    """The lowest entry, or NaN if there is one; on few entries four times as fast as the method `min`."""
    return float(values.reshape(-1)[values.argmin()])


def highest(values: NDArray[np.float64]) -> float:
    """The highest entry, or NaN if there is one; see `lowest`."""
    return float(values.reshape(-1)[values.argmax()])


def every(mask: NDArray[np.bool_]) -> bool:
    """Whether all entries are true; see `lowest`."""
    return int(np.count_nonzero(mask)) == mask.size


def row_blocks(rows: Matrix) -> Iterator[slice]:
    """Slices of at most about `BLOCK` numbers, so that what is computed from each needs little memory."""
    height = max(1, BLOCK // max(1, rows.shape[1]))
    return (slice(start, start + height) for start in range(0, rows.shape[0], height))


def binary_exponent(rows: Matrix) -> int:
    """Binary exponent e of the longest row: 2^-e times its length lies in [1/2, 1); 0 where all are 0."""
    largest = max(float(np.abs(rows[part]).max()) for part in row_blocks(rows))
    if largest == 0.0:
        return 0
    first = math.frexp(largest)[1]
    scaled = (times_power_of_two(rows[part], -first) for part in row_blocks(rows))
    return first + math.frexp(max(float(np.linalg.norm(block, axis=1).max()) for block in scaled))[1]


def times_power_of_two(values: NDArray[np.float64], exponent: int) -> NDArray[np.float64]:
    """Values * 2^exponent; one multiplication where the power is a normal float, as it rounds alike."""
    if abs(exponent) < NORMAL_EXPONENT:
        return values * math.ldexp(1.0, exponent)
    return np.asarray(np.ldexp(values, exponent))


def is_power_of_two_times(scaled: Matrix, rows: Matrix, exponent: int) -> bool:
    """Whether scaled = rows * 2^exponent exactly, which undoing shows: no entry underflowed."""
    undone = (
        np.array_equal(times_power_of_two(scaled[part], -exponent), rows[part]) for part in row_blocks(rows)
    )
    return all(undone)


def nonnegative_number(value: Any, name: str, *, error: type[InputError] = ProblemError) -> float:
    """Return `value` as a float that is finite and >= 0.

    Raises
    ------
    InputError
        Not a real number (strings, booleans and complex numbers are refused), masked, negative, NaN,
        infinite, or not exactly a float64.
    """
    if type(value) is float and 0.0 < value < math.inf:  # the usual case
        return value
    must = "must be a finite real number >= 0"
    number = real_number(value, name, error, must)
    if not np.isfinite(number) or is_negative(number):
        raise error(name, value=value, must=must)
    return abs(number)  # -0 is 0; a sum would flush a subnormal number where the thread does so
