"""BLAS and LAPACK, callable from compiled loops without going through Python.

SciPy's routines are registered by name in the just-in-time compiler's symbol table, so that compiled code can
be cached on disk: it refers to the name, not to an address in this process.

Of a symmetric matrix the upper triangle of a C-ordered array is read, which is Fortran's lower triangle; a
factor L with A = LL' is stored as the rows of L'. `stride` is the length of a row in memory, of which a
leading part is used; `work` is an int32 array of at least 8 entries.
"""

from typing import no_type_check

import numpy as np
from llvmlite import binding
from numba import njit, types
from numba.extending import get_cython_function_address


def _routine(library: str, name: str, arguments: int) -> types.ExternalFunction:
    """Declare one of SciPy's routines, whose arguments are all pointers."""
    symbol = f"convexperc_{name}"
    binding.add_symbol(symbol, get_cython_function_address(f"scipy.linalg.{library}", name))
    return types.ExternalFunction(symbol, types.void(*([types.voidptr] * arguments)))


# Each routine by its LAPACK or BLAS name, with the number of its arguments.
_POTRF = _routine("cython_lapack", "dpotrf", 5)  # A = LL'
_TRTRI = _routine("cython_lapack", "dtrtri", 6)  # L^-1
_LAUUM = _routine("cython_lapack", "dlauum", 5)  # L'L
_SYMV = _routine("cython_blas", "dsymv", 10)  # A x, A symmetric
_SYRK = _routine("cython_blas", "dsyrk", 10)  # C + a A A'
_TRMM = _routine("cython_blas", "dtrmm", 11)  # L B or B L
_TRSM = _routine("cython_blas", "dtrsm", 11)  # L^-1 B or B L^-1
_TRSV = _routine("cython_blas", "dtrsv", 8)  # L^-1 x
# Arguments of those routines are arrays of one entry, because they are passed by address.
_LOWER, _LEFT, _RIGHT, _TRANSPOSED, _PLAIN = (np.array([ord(letter)], np.int32) for letter in "LLRTN")
_UNIT_STEP = np.array([1], np.int32)  # the distance between entries of a vector in memory
_ONE, _ZERO, _MINUS = np.array([1.0]), np.array([0.0]), np.array([-1.0])  # factors
UNBLOCKED_SIZE = 16
"""Largest triangle that is handed to dtrtri, which is slow; larger ones are halved."""


@no_type_check
@njit(cache=True)
def cholesky(A, n, stride, work):
    """Factor the leading n x n block of A in place; returns LAPACK's info, 0 on success."""
    work[0], work[1], work[2] = n, stride, 0
    _POTRF(_LOWER.ctypes, work.ctypes, A.ctypes, work[1:].ctypes, work[2:].ctypes)
    return work[2]


@no_type_check
@njit(cache=True)
def cholesky_extend(A, start, n, stride, work):
    """Extend the factor of the leading `start` rows to the leading n; returns LAPACK's info, 0 on success."""
    rest = A[start * stride + start :]
    if start > 0:
        beside = A[start:]
        work[0], work[1], work[2] = n - start, start, stride
        _TRSM(
            _RIGHT.ctypes, _LOWER.ctypes, _TRANSPOSED.ctypes, _PLAIN.ctypes, work.ctypes, work[1:].ctypes,
            _ONE.ctypes, A.ctypes, work[2:].ctypes, beside.ctypes, work[2:].ctypes,
        )  # fmt: skip
        _SYRK(
            _LOWER.ctypes, _PLAIN.ctypes, work.ctypes, work[1:].ctypes, _MINUS.ctypes, beside.ctypes,
            work[2:].ctypes, _ONE.ctypes, rest.ctypes, work[2:].ctypes,
        )  # fmt: skip
    return cholesky(rest, n - start, stride, work)


@no_type_check
@njit(cache=True)
def cholesky_solve(A, n, stride, x, work):
    """Overwrite x by the solution of LL'y = x."""
    work[0], work[1] = n, stride
    for direction in (_PLAIN, _TRANSPOSED):
        _TRSV(
            _LOWER.ctypes, direction.ctypes, _PLAIN.ctypes, work.ctypes, A.ctypes, work[1:].ctypes, x.ctypes,
            _UNIT_STEP.ctypes,
        )  # fmt: skip


@no_type_check
@njit(cache=True)
def triangle_inverse(A, n, stride, work):
    """Overwrite the triangle L in the leading n x n block of A by L^-1, by recursive halving.

    The inverse of [[P, 0], [B, R]] is [[P^-1, 0], [-R^-1 B P^-1, R^-1]].
    """
    if n <= UNBLOCKED_SIZE:
        work[0], work[1], work[2] = n, stride, 0
        _TRTRI(_LOWER.ctypes, _PLAIN.ctypes, work.ctypes, A.ctypes, work[1:].ctypes, work[2:].ctypes)
        return
    half = n // 2
    beside, rest = A[half:], A[half * stride + half :]
    triangle_inverse(A, half, stride, work)
    triangle_inverse(rest, n - half, stride, work)
    work[0], work[1], work[2] = n - half, half, stride
    _TRMM(
        _RIGHT.ctypes, _LOWER.ctypes, _PLAIN.ctypes, _PLAIN.ctypes, work.ctypes, work[1:].ctypes,
        _MINUS.ctypes, A.ctypes, work[2:].ctypes, beside.ctypes, work[2:].ctypes,
    )  # fmt: skip
    _TRMM(
        _LEFT.ctypes, _LOWER.ctypes, _PLAIN.ctypes, _PLAIN.ctypes, work.ctypes, work[1:].ctypes,
        _ONE.ctypes, rest.ctypes, work[2:].ctypes, beside.ctypes, work[2:].ctypes,
    )  # fmt: skip


@no_type_check
@njit(cache=True)
def cholesky_inverse(A, n, stride, work):
    """Overwrite the factor in the leading n x n block of A by the upper triangle of (LL')^-1."""
    triangle_inverse(A, n, stride, work)
    work[0], work[1], work[2] = n, stride, 0
    _LAUUM(_LOWER.ctypes, work.ctypes, A.ctypes, work[1:].ctypes, work[2:].ctypes)


@no_type_check
@njit(cache=True)
def symmetric_times(A, n, stride, x, y, work):
    """Set y = A x for the leading n x n block of A."""
    work[0], work[1] = n, stride
    _SYMV(
        _LOWER.ctypes, work.ctypes, _ONE.ctypes, A.ctypes, work[1:].ctypes, x.ctypes, _UNIT_STEP.ctypes,
        _ZERO.ctypes, y.ctypes, _UNIT_STEP.ctypes,
    )  # fmt: skip


@no_type_check
@njit(cache=True)
def copy(source, target):
    """Copy one vector, in a loop that compiles quickly."""
    for k in range(source.size):
        target[k] = source[k]


@no_type_check
@njit(cache=True, fastmath={"reassoc", "contract"})
def inner(x, y):
    """The inner product of two short vectors; the compiler chooses the order of summation."""
    total = 0.0
    for k in range(x.size):
        total += x[k] * y[k]
    return total
