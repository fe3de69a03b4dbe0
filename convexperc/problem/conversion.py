"""Numbers as the caller gives them: turned into float64 without hiding or changing one, or refused."""

import math
import struct
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from convexperc.errors import InputError

DEEPEST = 64
"""NumPy's largest number of dimensions: nested lists are not looked at beyond it."""
MUST_BE_REAL = "must hold real numbers"
CONVERT = "Convert it to float64 first."
MUST_BE_EXACT = "must be a number that float64 holds exactly"
ROUND = "Round it yourself if that is meant."


def real_source(value: Any, name: str, error: type[InputError]) -> NDArray[Any]:
    """`value` as an array of booleans, integers or floats, its numbers unchanged.

    Raises
    ------
    InputError
        Of the class given: masked entries, anything but real numbers, ragged nesting, or an integer that
        NumPy rounded because floats stand beside it.
    """
    if type(value) is np.ndarray and value.dtype == np.float64:  # the usual case
        return value
    if isinstance(value, np.ma.MaskedArray):
        refuse_mask(value, name, error)
    try:
        source = np.asarray(value)
    except (ValueError, TypeError, OverflowError, UserWarning) as problem:
        must = "must be a rectangular array of real numbers"
        raise error(name, value=value, must=must, remedy=f"NumPy says: {str(problem).rstrip('.')}.") from None
    for part in _parts(value):
        if isinstance(part, np.ma.MaskedArray):
            refuse_mask(part, name, error)
        elif source.dtype.kind == "f" and isinstance(part, (int, np.integer, np.ndarray)):
            _check_integers(part, name, error)
    if source.dtype.kind == "O":
        source = _from_objects(source, name, error)
    if source.dtype.kind not in "buif":
        raise error(name, value=source.dtype.name, must=MUST_BE_REAL, remedy=CONVERT)
    return source


def refuse_mask(value: Any, name: str, error: type[InputError]) -> None:
    """Raise where a masked array hides an entry."""
    hidden = int(np.ma.getmaskarray(value).sum())
    if hidden:
        remedy = "Fill or drop the masked entries first."
        raise error(
            name, value=f"a mask that hides {hidden} entries", must="must not be masked", remedy=remedy
        )


def held_exactly(kind: np.dtype[Any]) -> bool:
    """Whether float64 holds every number of a type: booleans, integers and floats that are short enough."""
    return (
        kind.kind == "b"
        or (kind.kind in "iu" and kind.itemsize < 8)
        or (kind.kind == "f" and kind.itemsize <= 8)
    )


def changed(array: NDArray[np.float64], source: NDArray[Any]) -> NDArray[np.bool_]:
    """Where float64 numbers are not those of the array that they were converted from; false for NaN.

    Floats shorter than float64 are compared by their bits: a thread that flushes subnormal numbers reads them
    as 0, in comparisons as well.
    """
    kind = source.dtype
    if kind == np.float64 or (kind.kind != "f" and held_exactly(kind)):
        return np.zeros(source.shape, dtype=bool)
    with np.errstate(all="ignore"):
        if kind.kind in "iu":
            size = np.where(source < 0, -source, source).astype(np.uint64)  # -2^63 stays, and is 2^63 here
            lowest = np.maximum(size & (~size + np.uint64(1)), np.uint64(1))
            return np.asarray(size // lowest >= np.uint64(2**53))
        back = array.astype(kind)
        if kind.itemsize < 8:
            unsigned = f"u{kind.itemsize}"
            return np.asarray((back.view(unsigned) != source.view(unsigned)) & np.isfinite(source))
        return np.asarray((back != source) & np.isfinite(source))


def real_number(value: Any, name: str, error: type[InputError], must: str = "must be a real number") -> float:
    """A real scalar as a float, its number unchanged: of Python, of NumPy, or an array without axes.

    Raises
    ------
    InputError
        Of the class given: anything else (strings, booleans and complex numbers, too), a masked entry, or a
        number that float64 does not hold exactly.
    """
    if isinstance(value, np.ma.MaskedArray):
        refuse_mask(value, name, error)
    scalar = value[()] if isinstance(value, np.ndarray) and value.ndim == 0 else value
    if isinstance(scalar, (bool, np.bool_)) or not isinstance(scalar, (int, float, np.integer, np.floating)):
        raise error(name, value=value, must=must, remedy="Pass an int or a float.")
    try:
        number = exact_float(scalar)
    except OverflowError:
        raise error(name, value=value, must=must, remedy="The integer overflows float64.") from None
    if number is None:
        raise error(name, value=value, must=MUST_BE_EXACT, remedy=ROUND)
    return number


def exact_float(value: Any) -> float | None:
    """A real scalar as a float; None where float64 does not hold it exactly.

    Raises
    ------
    OverflowError
        An integer beyond float64.
    """
    number = float(value)
    if isinstance(value, float):
        return number
    if isinstance(value, (int, np.integer)):
        return number if int(value) == number else None
    if isinstance(value, np.floating):
        return None if changed(np.array([number]), np.array([value])).any() else number
    return number


def exact_hex(text: str) -> float | None:
    """A C99 hex float; None where float64 does not hold it exactly.

    Raises
    ------
    OverflowError
        The number is beyond float64.
    """
    number = float.fromhex(text)
    digits, _, power = text.lower().lstrip("+-").removeprefix("0x").partition("p")
    whole, _, places = digits.partition(".")
    mantissa, exponent = int(whole + places, 16), int(power or 0) - 4 * len(places)
    if mantissa:
        exponent += (mantissa & -mantissa).bit_length() - 1
        mantissa //= mantissa & -mantissa
    exact = mantissa.bit_length() <= 53 and exponent >= -1074
    flushed = mantissa != 0 and number == 0.0  # by a thread that does so
    return number if not mantissa or (exact and not flushed) else None


def is_negative(number: float) -> bool:
    """Whether the number is below 0, by its bits: a comparison may flush a subnormal number."""
    size = int.from_bytes(struct.pack(">d", number), "big") & (2**63 - 1)
    return math.copysign(1.0, number) < 0.0 and size > 0


def _parts(value: Any, depth: int = 0) -> Iterator[Any]:
    """What nested lists and tuples hold, other than floats."""
    if not isinstance(value, (list, tuple)):
        yield value
    elif depth < DEEPEST and not set(map(type, value)) <= {float}:
        for part in value:
            yield from _parts(part, depth + 1)


def _check_integers(part: Any, name: str, error: type[InputError]) -> None:
    """Refuse an integer, or an array, of which NumPy has made other floats."""
    source = np.asarray(part)
    if source.dtype.kind not in "iu":
        return
    wrong = changed(np.empty(source.shape), source)
    if wrong.any():
        raise error(name, value=int(source[wrong][0]), must=MUST_BE_EXACT, remedy=ROUND)


def _from_objects(source: NDArray[Any], name: str, error: type[InputError]) -> NDArray[np.float64]:
    """Accept Python integers that are too long for int64 as long as float64 can hold them."""
    numbers = []
    for entry in source.flat:
        if isinstance(entry, (bool, np.bool_)) or not isinstance(
            entry, (int, float, np.integer, np.floating)
        ):
            raise error(name, value=entry, must=MUST_BE_REAL, remedy=CONVERT)
        try:
            number = exact_float(entry)
        except OverflowError:
            remedy = "The integer is too large; rescale the data."
            raise error(name, value=entry, must="must fit into float64", remedy=remedy) from None
        if number is None:
            raise error(name, value=entry, must=MUST_BE_EXACT, remedy=ROUND)
        numbers.append(number)
    return np.array(numbers, dtype=np.float64).reshape(source.shape)
