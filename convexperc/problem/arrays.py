"""Input validation: arrays are checked and copied once, to finite, read-only float64."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from jaxtyping import Float
from numpy.typing import NDArray

from convexperc.errors import InputError, PointError, ProblemError

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
        Real numbers: booleans, integers that float64 holds without overflow, or floats.
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
        Complex numbers, strings, objects, ragged nesting, wrong dimension, NaN or infinity,
        or a finite number that overflows float64.
    """
    source = _as_array(value, name, error)
    if source.ndim != ndim:
        raise error(
            name, value=source.shape, must=f"must have {ndim} dimension(s)", remedy="Check its shape."
        )
    with np.errstate(over="ignore", invalid="ignore"):
        array = np.array(source, dtype=np.float64, order="C", copy=True)
        flat = array.reshape(-1)
        square = float(flat @ flat)  # finite only if every entry is; an overflow is looked at below
    bad = np.False_ if math.isfinite(square) else ~np.isfinite(array)
    if bad.any() and (finite or np.isfinite(source[bad].astype(np.longdouble)).any()):
        index = tuple(int(i) for i in np.argwhere(bad)[0])
        raise error(
            f"{name}[{', '.join(map(str, index))}]",
            value=source[index],
            must="must be finite in float64",
            remedy=f"{int(bad.sum())} of {array.size} entries are NaN, infinite or too large; clean them.",
        )
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


def _as_array(value: Any, name: str, error: type[InputError]) -> NDArray[Any]:
    """Turn `value` into an array of a real kind (bool, integer, float) without changing its numbers."""
    if isinstance(value, np.ma.MaskedArray) and np.ma.is_masked(value):
        hidden = int(np.ma.getmaskarray(value).sum())
        must, remedy = "must not be masked", "Fill or drop the masked entries first."
        raise error(name, value=f"a mask that hides {hidden} entries", must=must, remedy=remedy)
    try:
        source = np.asarray(value)
    except (ValueError, TypeError, OverflowError) as problem:
        must = "must be a rectangular array of real numbers"
        raise error(name, value=value, must=must, remedy=f"NumPy says: {problem}.") from None
    if source.dtype.kind == "O":
        source = _from_objects(source, name, error)
    if source.dtype.kind not in "buif":
        raise error(
            name,
            value=source.dtype.name,
            must="must hold real numbers",
            remedy="Convert it to float64 first.",
        )
    return source


def _from_objects(source: NDArray[Any], name: str, error: type[InputError]) -> NDArray[Any]:
    """Accept Python integers that are too long for int64 as long as float64 can hold them."""
    for entry in source.flat:
        if isinstance(entry, (bool, np.bool_)) or not isinstance(
            entry, (int, float, np.integer, np.floating)
        ):
            raise error(
                name, value=entry, must="must hold real numbers", remedy="Convert it to float64 first."
            )
    try:
        return np.array([float(entry) for entry in source.flat]).reshape(source.shape)
    except OverflowError:
        longest = max((entry for entry in source.flat if isinstance(entry, int)), key=abs)
        raise error(
            name,
            value=longest,
            must="must fit into float64",
            remedy="The integer is too large; rescale the data.",
        ) from None


def nonnegative_number(value: Any, name: str, *, error: type[InputError] = ProblemError) -> float:
    """Return `value` as a float that is finite and >= 0.

    Raises
    ------
    InputError
        Not a real number (strings, booleans and complex numbers are refused), negative, NaN or infinite.
    """
    must = "must be a finite real number >= 0"
    scalar = value.item() if isinstance(value, np.ndarray) and value.ndim == 0 else value
    if isinstance(scalar, (bool, np.bool_)) or not isinstance(scalar, (int, float, np.integer, np.floating)):
        raise error(name, value=value, must=must, remedy="Pass an int or a float.")
    try:
        number = float(scalar)
    except OverflowError:
        raise error(name, value=value, must=must, remedy="The integer overflows float64.") from None
    if not (np.isfinite(number) and number >= 0):
        raise error(name, value=value, must=must)
    return number + 0.0
