"""BLAS and LAPACK for the kernels: matrices and vectors are given by their addresses in memory.

Of a symmetric matrix the upper triangle of a C-ordered array is read, which is Fortran's lower triangle; a
factor L with A = LL' is stored as the rows of L'. `stride` is the length of a row in memory, of which a
leading part is used.
"""

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
"""Vectors up to this length are summed in order, which takes less time than the call of a routine."""


class Arguments(NamedTuple):
    """Memory for what the routines take by address: sizes, letters and factors.

    Attributes
    ----------
    integers : int32 (16,)
        Four sizes that change from call to call, the letters L, R, T, N and the step 1; then, as float64, the
        numbers 1, 0 and -1.
    at, numbers_at : int
        Addresses of the sizes and of the numbers.
    """

    integers: NDArray[np.int32]
    at: int
    numbers_at: int


ARGUMENTS = np.array([0, 0, 0, 0, *map(ord, "LRTN"), 1, *[0] * 7], dtype=np.int32)
ARGUMENTS[10:].view(np.float64)[:] = 1.0, 0.0, -1.0


def new_arguments() -> Arguments:
    """The constants in place."""
    integers = ARGUMENTS.copy()
    at = address(integers)
    return Arguments(integers, at, at + 40)


def address(array: NDArray[np.generic]) -> int:
    """Where the first entry of an array lies, for as long as the array exists."""
    return int(array.__array_interface__["data"][0])


@no_type_check
def cholesky(A, n, stride, arguments):
    """Factor the leading n x n block of A in place; returns LAPACK's info, 0 on success."""
    integers, at = arguments.integers, arguments.at
    integers[0], integers[1], integers[2] = n, stride, 0
    POTRF(at + LOWER, at, A, at + 4, at + 8)
    return integers[2]


@no_type_check
def cholesky_extend(A, start, n, stride, arguments):
    """Extend the factor of the leading `start` rows to the leading n; returns LAPACK's info, 0 on success."""
    integers, at, numbers = arguments.integers, arguments.at, arguments.numbers_at
    rest = A + NUMBER * (start * stride + start)
    if start > 0:
        beside = A + NUMBER * start
        integers[0], integers[1], integers[2] = n - start, start, stride
        TRSM(
            at + RIGHT, at + LOWER, at + TRANSPOSED, at + PLAIN, at, at + 4, numbers + ONE, A, at + 8,
            beside, at + 8,
        )  # fmt: skip
        SYRK(at + LOWER, at + PLAIN, at, at + 4, numbers + MINUS, beside, at + 8, numbers + ONE, rest, at + 8)
    return cholesky(rest, n - start, stride, arguments)


@no_type_check
def cholesky_solve(A, n, stride, x, arguments):
    """Overwrite x by the solution of LL'y = x."""
    integers, at = arguments.integers, arguments.at
    integers[0], integers[1] = n, stride
    TRSV(at + LOWER, at + PLAIN, at + PLAIN, at, A, at + 4, x, at + STEP)
    TRSV(at + LOWER, at + TRANSPOSED, at + PLAIN, at, A, at + 4, x, at + STEP)


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
def cholesky_inverse(A, n, stride, arguments):
    """Overwrite the factor in the leading n x n block of A by the upper triangle of (LL')^-1."""
    triangle_inverse(A, n, stride, arguments)
    integers, at = arguments.integers, arguments.at
    integers[0], integers[1], integers[2] = n, stride, 0
    LAUUM(at + LOWER, at, A, at + 4, at + 8)


@no_type_check
def symmetric_times(A, n, stride, x, y, arguments):
    """Set y = A x for the leading n x n block of A."""
    integers, at, numbers = arguments.integers, arguments.at, arguments.numbers_at
    integers[0], integers[1] = n, stride
    SYMV(at + LOWER, at, numbers + ONE, A, at + 4, x, at + STEP, numbers + ZERO, y, at + STEP)


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
