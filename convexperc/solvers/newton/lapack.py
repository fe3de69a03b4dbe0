"""BLAS and LAPACK for the kernels, and loops in their place where matrices are small.

A matrix is given as an array, of which a leading block is used, and its address in memory; a vector as well.
Of a symmetric matrix the upper triangle of the C-ordered array is read, which is Fortran's lower triangle; a
factor L with A = LL' is stored as the rows of L'.
"""

from ctypes import addressof, c_char
from typing import NamedTuple, no_type_check

import numpy as np
from numpy.typing import NDArray

from convexperc.kernels.routines import Routine

POTRF = Routine("cython_lapack", "dpotrf", 5)  # A = LL'
TRTRI = Routine("cython_lapack", "dtrtri", 6)  # L^-1
LAUUM = Routine("cython_lapack", "dlauum", 5)  # L'L
SYMV = Routine("cython_blas", "dsymv", 10)  # A x, A symmetric
SYRK = Routine("cython_blas", "dsyrk", 10)  # C + a A A'
TRMM = Routine("cython_blas", "dtrmm", 11)  # L B or B L
TRSM = Routine("cython_blas", "dtrsm", 11)  # L^-1 B or B L^-1
TRSV = Routine("cython_blas", "dtrsv", 8)  # L^-1 x
DOT = Routine("cython_blas", "ddot", 5, returns_number=True)
NUMBER = 8
"""Bytes of a float64."""
# Offsets in bytes of the constants in `Arguments.integers` and in `Arguments.numbers`.
LOWER = LEFT = 16
RIGHT, TRANSPOSED, PLAIN, STEP = 20, 24, 28, 32
ONE, ZERO, MINUS = 0, 8, 16
UNBLOCKED_SIZE = 16
"""Largest triangle that is handed to dtrtri, which is slow; larger ones are halved."""
SHORT = 16
"""Up to this size loops take less time than the call of a routine."""


class Arguments(NamedTuple):
    """Memory for what the routines take by address: sizes, letters and factors.

    Attributes
    ----------
    integers : int32 (10,)
        Four sizes that change from call to call, the letters L, R, T, N and the step 1. The numbers 1, 0 and
        -1 follow, as float64.
    at, numbers_at : int
        Addresses of the sizes and of the numbers.
    """

    integers: NDArray[np.int32]
    at: int
    numbers_at: int


ARGUMENTS = 8
"""Numbers of 8 bytes that it takes."""
LETTERS = tuple(map(ord, "LRTN"))


@no_type_check
def arguments_in(memory, at):
    """The constants, put in place at the beginning of a float64 array that lies at an address."""
    integers, numbers = memory[:5].view(np.int32), memory[5:ARGUMENTS]
    for k in range(4):
        integers[k], integers[4 + k] = 0, LETTERS[k]
    integers[8], integers[9] = 1, 0
    numbers[0], numbers[1], numbers[2] = 1.0, 0.0, -1.0
    return Arguments(integers, at, at + 40)


def address(array: NDArray[np.generic]) -> int:
    """Where the first entry of an array lies, for as long as the array exists."""
    try:
        return addressof(c_char.from_buffer(array.data))  # a quarter of the time
    except (TypeError, ValueError):  # a read-only array, or one without entries
        return int(array.__array_interface__["data"][0])


@no_type_check
def cholesky(A, at, n, arguments):
    """Factor the leading n x n block of A in place; returns 0 on success."""
    return cholesky_extend(A, at, 0, n, arguments)


@no_type_check
def cholesky_extend(A, at, start, n, arguments):
    """Extend the factor of the leading `start` rows to the leading n; returns 0 on success."""
    if n <= SHORT:
        return short_cholesky(A, start, n)
    stride = A.shape[1]
    integers, here, numbers = arguments.integers, arguments.at, arguments.numbers_at
    rest = at + NUMBER * (start * stride + start)
    integers[0], integers[1], integers[2], integers[3] = n - start, start, stride, 0
    if start > 0:
        beside = at + NUMBER * start
        TRSM(
            here + RIGHT, here + LOWER, here + TRANSPOSED, here + PLAIN, here, here + 4, numbers + ONE, at,
            here + 8, beside, here + 8,
        )  # fmt: skip
        SYRK(
            here + LOWER, here + PLAIN, here, here + 4, numbers + MINUS, beside, here + 8, numbers + ONE,
            rest, here + 8,
        )  # fmt: skip
    POTRF(here + LOWER, here, rest, here + 8, here + 12)
    return integers[3]


@no_type_check
def short_cholesky(A, start, n):
    """`cholesky_extend` without a routine."""
    for c in range(start, n):
        for r in range(c + 1):
            total = A[r, c]
            for k in range(r):
                total -= A[k, r] * A[k, c]
            if r < c:
                A[r, c] = total / A[r, r]
            elif total > 0.0:
                A[c, c] = np.sqrt(total)
            else:
                return c + 1
    return 0


@no_type_check
def cholesky_solve(A, at, n, x, x_at, arguments):
    """Overwrite x by the solution of LL'y = x."""
    if n <= SHORT:
        for r in range(n):
            total = x[r]
            for k in range(r):
                total -= A[k, r] * x[k]
            x[r] = total / A[r, r]
        for r in range(n - 1, -1, -1):
            total = x[r]
            for k in range(r + 1, n):
                total -= A[r, k] * x[k]
            x[r] = total / A[r, r]
        return
    integers, here = arguments.integers, arguments.at
    integers[0], integers[1] = n, A.shape[1]
    TRSV(here + LOWER, here + PLAIN, here + PLAIN, here, at, here + 4, x_at, here + STEP)
    TRSV(here + LOWER, here + TRANSPOSED, here + PLAIN, here, at, here + 4, x_at, here + STEP)


@no_type_check
def triangle_inverse(A, n, stride, arguments):
    """Overwrite the triangle L in the leading n x n block of A by L^-1, by recursive halving.

    The inverse of [[P, 0], [B, R]] is [[P^-1, 0], [-R^-1 B P^-1, R^-1]].
    """
    integers, at, numbers = arguments.integers, arguments.at, arguments.numbers_at
    if n <= UNBLOCKED_SIZE:
        integers[0], integers[1], integers[2] = n, stride, 0
        TRTRI(at + LOWER, at + PLAIN, at, A, at + 4, at + 8)
        return
    half = n // 2
    beside, rest = A + NUMBER * half, A + NUMBER * (half * stride + half)
    triangle_inverse(A, half, stride, arguments)
    triangle_inverse(rest, n - half, stride, arguments)
    integers[0], integers[1], integers[2] = n - half, half, stride
    TRMM(
        at + RIGHT, at + LOWER, at + PLAIN, at + PLAIN, at, at + 4, numbers + MINUS, A, at + 8, beside, at + 8
    )
    TRMM(
        at + LEFT, at + LOWER, at + PLAIN, at + PLAIN, at, at + 4, numbers + ONE, rest, at + 8, beside, at + 8
    )


@no_type_check
def cholesky_inverse(A, at, n, arguments):
    """Overwrite the factor in the leading n x n block of A by the upper triangle of (LL')^-1."""
    if n <= SHORT:
        short_inverse(A, n)
        return
    triangle_inverse(at, n, A.shape[1], arguments)
    integers, here = arguments.integers, arguments.at
    integers[0], integers[1], integers[2] = n, A.shape[1], 0
    LAUUM(here + LOWER, here, at, here + 4, here + 8)


@no_type_check
def short_inverse(A, n):
    """`cholesky_inverse` without a routine: R = L', then R^-1, then R^-1 R^-1'."""
    for c in range(n):
        A[c, c] = 1.0 / A[c, c]
        for r in range(c):
            total = 0.0
            for k in range(r, c):
                total += A[r, k] * A[k, c]
            A[r, c] = -total * A[c, c]
    for r in range(n):
        for c in range(r, n):
            total = 0.0
            for k in range(c, n):
                total += A[r, k] * A[c, k]
            A[r, c] = total


@no_type_check
def symmetric_times(A, at, n, x, x_at, y, y_at, arguments):
    """Set y = A x for the leading n x n block of A."""
    if n <= SHORT:
        for r in range(n):
            y[r] = 0.0
        for r in range(n):
            total = A[r, r] * x[r]
            for c in range(r + 1, n):
                total += A[r, c] * x[c]
                y[c] += A[r, c] * x[r]
            y[r] += total
        return
    integers, here, numbers = arguments.integers, arguments.at, arguments.numbers_at
    integers[0], integers[1] = n, A.shape[1]
    SYMV(
        here + LOWER, here, numbers + ONE, at, here + 4, x_at, here + STEP, numbers + ZERO, y_at, here + STEP
    )


@no_type_check
def inner(x, y, x_at, y_at, n, arguments):
    """The inner product of the first n entries of two vectors, each given as an array and its address."""
    if n > SHORT:
        arguments.integers[0] = n
        return DOT(arguments.at, x_at, arguments.at + STEP, y_at, arguments.at + STEP)
    total = 0.0
    for k in range(n):
        total += x[k] * y[k]
    return total


@no_type_check
def copy(source, target, n):
    """Copy the first n entries of a vector."""
    for k in range(n):
        target[k] = source[k]
