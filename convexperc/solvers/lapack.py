"""Cholesky factors from LAPACK, callable inside compiled loops without a trip through Python.

SciPy's routines are entered into the just-in-time compiler's table of symbols by name, so that compiled code
can be kept on disk: it refers to the name, not to an address of this process.
"""

from typing import no_type_check

from llvmlite import binding
from numba import njit, types
from numba.extending import get_cython_function_address


def _routine(name: str, arguments: int) -> types.ExternalFunction:
    """A LAPACK routine of SciPy's; every argument is an address."""
    symbol = f"convexperc_{name}"
    binding.add_symbol(symbol, get_cython_function_address("scipy.linalg.cython_lapack", name))
    return types.ExternalFunction(symbol, types.void(*([types.voidptr] * arguments)))


_POTRF = _routine("dpotrf", 5)
_POTRS = _routine("dpotrs", 8)
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
