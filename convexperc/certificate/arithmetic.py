"""Whether arithmetic is here and now what the bounds assume: round to nearest, with subnormal numbers.

Both are settings of a thread that any library can change: one that was built with ``-ffast-math`` may flush
subnormal numbers to zero in the thread that loads it. Each probe is an operation on two floats whose correct
result is known bit by bit; the bits are compared, since a comparison of floats may flush them as well.

docs/rounding.md says what is assumed, and what no probe can show.
"""

from functools import cache

import numpy as np
from numpy.typing import NDArray

ONE, SMALLEST, HALF_ULP, MINUS = 1023 << 52, 1 << 52, 970 << 52, 1 << 63
"""The bits of 1, of 2^-1022 (the smallest normal number) and of 2^-53; the sign bit."""
ROUNDED_SUMS = (
    (ONE, HALF_ULP, ONE),
    (ONE, HALF_ULP | 1, ONE | 1),
    (ONE | 1, HALF_ULP, ONE | 2),
    (MINUS | ONE, MINUS | HALF_ULP, MINUS | ONE),
    (MINUS | ONE, MINUS | HALF_ULP | 1, MINUS | ONE | 1),
)
"""x, y, fl(x + y): ties, which go to the even neighbour, and numbers just beyond one."""
SMALL_SUMS = ((SMALLEST, MINUS | SMALLEST | 1, MINUS | 1), (1, 1, 2))
"""The same where a result, or an operand, is subnormal."""
ROUNDED_PRODUCTS = (
    (ONE | 1, ONE | 1, ONE | 2),
    (ONE | 1, ONE - 2, ONE),
    (MINUS | ONE | 1, ONE | 1, MINUS | ONE | 2),
    (MINUS | ONE | 1, ONE - 2, MINUS | ONE),
)
"""x, y, fl(x y): (1 + 2^-52)^2 and (1 + 2^-52)(1 - 2^-52), of both signs."""
SMALL_PRODUCTS = (
    (SMALLEST, 1022 << 52, 1 << 51),
    (1, 2023 << 52, 949 << 52),
    (463 << 52, 523 << 52, 1 << 14),
)
"""The same where a result, or a factor, is subnormal."""
ROUNDING = "this thread does not round to the nearest float64"
FLUSHING = "this thread flushes subnormal numbers to zero"
THREADS = "products, or a thread of the BLAS, flush subnormal numbers to zero or do not round to nearest"
SCHEME = "the BLAS multiplies matrices by a Strassen-like scheme"
SHAPE = 512, 128
"""Of a matrix so large that libraries share its product with 128 columns among their threads; 5 ms."""
HALF_SIZE = 256
"""Of the product of matrices that shows a Strassen-like scheme; it takes 15 ms on one core."""
MANY = 512
"""Views from which on such a scheme might be used."""


def broken_assumption(size: int = 1) -> str:
    """What is seen to be otherwise than the bounds assume, as a sentence; empty where nothing is.

    Parameters
    ----------
    size : int
        The smallest dimension of the matrices that are multiplied; from `MANY` on, the scheme of the
        product is looked at as well, once in a process.

    Returns
    -------
    str
        Of this thread, at this moment; of the threads of the BLAS, when it was first asked.
    """
    found = _of_thread()
    if not found and not _products_are_sound():
        found = THREADS
    if not found and size >= MANY and not _blas_is_classical():
        found = SCHEME
    return f"nothing is proved: {found}" if found else ""


class _Operation:
    """One operation on pairs of floats, with the bits of its correct results."""

    def __init__(self, ufunc: np.ufunc, cases: tuple[tuple[int, int, int], ...]) -> None:
        # As many cases as fill the vector registers, several times.
        self.left, self.right, results = (_floats([case[k] for case in cases] * 4) for k in range(3))
        self.ufunc, self.results = ufunc, results.tobytes()

    def is_correct(self) -> bool:
        """Whether NumPy gives them; Python's floats and compiled code read the same control register."""
        found: bytes = self.ufunc(self.left, self.right).tobytes()
        return found == self.results


def _floats(bits: list[int]) -> NDArray[np.float64]:
    return np.array(bits, dtype=np.uint64).view(np.float64)


SUMS = _Operation(np.add, ROUNDED_SUMS + SMALL_SUMS)
PRODUCTS = _Operation(np.multiply, ROUNDED_PRODUCTS + SMALL_PRODUCTS)
ROUNDED = _Operation(np.add, ROUNDED_SUMS)


def _of_thread() -> str:
    """What is wrong with the arithmetic of this thread; correct results raise no flag that NumPy reports."""
    try:
        if SUMS.is_correct():
            return ""
    except FloatingPointError:  # NumPy was told to raise it
        pass
    with np.errstate(all="ignore"):
        return FLUSHING if ROUNDED.is_correct() else ROUNDING


@cache
def _products_are_sound() -> bool:
    """Whether products are correct, and every part of a product of matrices.

    The other numbers of a row are 0, so that the order of its sum does not matter.
    """
    cases = (ROUNDED_SUMS + SMALL_SUMS) * SHAPE[0]
    sums, halves = np.zeros(SHAPE), np.zeros(SHAPE)
    for i, (row, half) in enumerate(zip(sums, halves, strict=True)):
        place = 2 * i % SHAPE[1]
        row[place : place + 2] = _floats(list(cases[i][:2]))
        half[place : place + 1] = _floats([SMALLEST])
    results = _floats([case[2] for case in cases[: SHAPE[0]]]), _floats([SMALL_PRODUCTS[0][2]] * SHAPE[0])
    square = SHAPE[1], SHAPE[1]
    with np.errstate(all="ignore"):
        found = sums @ np.ones(square), halves @ np.full(square, 0.5)
        correct = PRODUCTS.is_correct()
    expected = (np.repeat(column, SHAPE[1]).tobytes() for column in results)
    return correct and all(got.tobytes() == want for got, want in zip(found, expected, strict=True))


@cache
def _blas_is_classical() -> bool:
    """Whether a block of small numbers keeps its product beside a block of large ones.

    A Strassen-like scheme adds blocks before it multiplies them, and loses the small ones. NumPy multiplies
    a matrix and its own transpose by another routine, which is looked at as well.
    """
    k = HALF_SIZE
    A = np.zeros((2 * k, 2 * k))
    A[:k, :k], A[k:, k:] = 1.0 / 3.0, 2.0**-60
    products = np.matmul(A, A.copy()), np.matmul(A, A.T)
    return all(bool((each[k:, k:] == k * 2.0**-120).all()) for each in products)
