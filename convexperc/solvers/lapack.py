"""BLAS and LAPACK, callable inside compiled loops without a trip through Python.

SciPy's routines are entered into the just-in-time compiler's table of symbols by name, so that compiled code
can be kept on disk: it refers to the name, not to an address of this process.
"""

from typing import no_type_check

from llvmlite import binding
from numba import njit, types
from numba.extending import get_cython_function_address


def _routine(library: str, name: str, arguments: int) -> types.ExternalFunction:
    """A routine of SciPy's; every argument is an address."""
    symbol = f"convexperc_{name}"
    binding.add_symbol(symbol, get_cython_function_address(f"scipy.linalg.{library}", name))
    return types.ExternalFunction(symbol, types.void(*([types.voidptr] * arguments)))


_POTRF = _routine("cython_lapack", "dpotrf", 5)
_POTRS = _routine("cython_lapack", "dpotrs", 8)
_POTRI = _routine("cython_lapack", "dpotri", 5)
_SYMV = _routine("cython_blas", "dsymv", 10)
LOWER = 76
"""The letter L, as LAPACK reads it: of Fortran's lower half, which is the upper one of a C-ordered array."""


@no_type_check
@njit(cache=True)
def cholesky(A, n, stride, work):
    """Factor the leading n x n block of the symmetric C-ordered A in place; 0 where it succeeded.

    `work` is an int32 array of at least 8 entries.
    """
    work[0], work[1], work[2], work[3] = n, stride, 0, LOWER
    _POTRF(work[3:].ctypes, work.ctypes, A.ctypes, work[1:].ctypes, work[2:].ctypes)
    return work[2]


@no_type_check
@njit(cache=True)
def cholesky_solve(A, n, stride, B, count, width, work):
    """Overwrite the first `count` rows of B, of `width` entries each, by the solutions of A x = row."""
    work[0], work[1], work[2], work[3], work[4], work[5] = n, stride, 0, LOWER, count, width
    _POTRS(
        work[3:].ctypes, work.ctypes, work[4:].ctypes, A.ctypes, work[1:].ctypes, B.ctypes, work[5:].ctypes,
        work[2:].ctypes,
    )  # fmt: skip


@no_type_check
@njit(cache=True)
def cholesky_inverse(A, n, work):
    """Overwrite the n x n Cholesky factor A by the whole inverse of the matrix that it is the factor of."""
    work[0], work[2], work[3] = n, 0, LOWER
    _POTRI(work[3:].ctypes, work.ctypes, A.ctypes, work.ctypes, work[2:].ctypes)
    for a in range(n):
        for b in range(a):
            A[a, b] = A[b, a]


@no_type_check
@njit(cache=True)
def symmetric_times(A, n, x, y, work, scalars):
    """Set y = A x for a symmetric A; `scalars` is a float64 array that holds 1 and 0."""
    work[0], work[1], work[2], work[3] = n, n, 1, LOWER
    _SYMV(
        work[3:].ctypes, work.ctypes, scalars.ctypes, A.ctypes, work[1:].ctypes, x.ctypes, work[2:].ctypes,
        scalars[1:].ctypes, y.ctypes, work[2:].ctypes,
    )  # fmt: skip


@no_type_check
@njit(cache=True)
def copy(source, target):
    """Copy one vector, in a loop that compiles quickly."""
    for k in range(source.size):
        target[k] = source[k]


@no_type_check
@njit(cache=True)
def inner(x, y):
    """The inner product of two short vectors."""
    total = 0.0
    for k in range(x.size):
        total += x[k] * y[k]
    return total
