"""Numbers and matrices in ball arithmetic, of any precision and without overflow or underflow.

Every number is an `arb` of python-flint: a midpoint with a radius that encloses the real number meant.
"""

import math
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import flint
import numpy as np

from convexperc.certificate.rationals import WORD_BITS

Number = Any
"""A flint.arb."""
Numbers = list[Any]
"""A list of flint.arb."""


MATRIX_COST, MATRIX_GROWTH = 6, 1.35
"""Each of the n^3 multiplications of an inverse costs 6 k^1.35 products of machine words for k words of
precision: within 40 % of what was measured for 200 to 1000 rows and 128 to 8192 bits."""
ENTRY_COST = 1000
"""The same for an entry of a matrix that is written one by one."""
_ALONE = threading.RLock()
"""Held by the thread that works in balls: FLINT has one precision for the whole process."""


@contextmanager
def precision(bits: int) -> Iterator[None]:
    """Work with `bits` bits inside the block, which other threads wait for; then as before."""
    with _ALONE:
        before = flint.ctx.prec
        try:
            flint.ctx.prec = bits
            yield
        finally:
            flint.ctx.prec = before


def matrix_cost(multiplications: float | int, bits: int | None = None) -> float:
    """Products of machine words that so many multiplications cost, without bits in the precision in force."""
    words = (flint.ctx.prec if bits is None else bits) / WORD_BITS
    return float(MATRIX_COST * multiplications * words**MATRIX_GROWTH)


def exact_matrix(values: np.ndarray) -> Any:
    """Floats of shape (r, k) as they are."""
    rows, columns = values.shape
    return flint.arb_mat(rows, columns, values.ravel().tolist())


def float_above(value: Number) -> float:
    """The smallest float that is not below the number."""
    near = float(value.upper())
    return near if flint.arb(near) >= value else math.nextafter(near, math.inf)


def float_below(value: Number) -> float:
    """The largest float that is not above the number."""
    near = float(value.lower())
    return near if flint.arb(near) <= value else math.nextafter(near, -math.inf)


def midpoint(values: Numbers) -> Numbers:
    """The midpoints, as exact numbers."""
    return [v.mid() for v in values]


def dot(x: Numbers, y: Numbers) -> Number:
    """The inner product."""
    total = flint.arb(0)
    for a, b in zip(x, y, strict=True):
        total += a * b
    return total


def times(A: Any, x: Numbers) -> Numbers:
    """A x."""
    return column(A * flint.arb_mat(len(x), 1, x))


def column(A: Any) -> Numbers:
    """The entries of a matrix with one column."""
    return list(A.entries())
