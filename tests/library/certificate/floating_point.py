"""The floating-point environment of this thread, set as another library may set it."""

import ctypes
import platform
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

MXCSR, FLUSH_RESULTS, FLUSH_OPERANDS = 28, 0x8000, 0x0040
"""Where glibc's fenv_t of x86-64 keeps the control register of SSE, and its bits FTZ and DAZ."""
DOWN, UP, TO_ZERO = 0x400, 0x800, 0xC00
"""glibc's rounding directions on x86-64."""
SETTINGS = {
    "results flushed": (FLUSH_RESULTS, 0),
    "operands flushed": (FLUSH_OPERANDS, 0),
    "both, as -ffast-math does": (FLUSH_RESULTS | FLUSH_OPERANDS, 0),
    "downwards": (0, DOWN),
    "upwards": (0, UP),
    "to zero": (0, TO_ZERO),
}


def library() -> ctypes.CDLL:
    """The C library's fegetenv, fesetenv and fesetround; the test is skipped where they are others."""
    if (platform.system(), platform.machine(), platform.libc_ver()[0]) != ("Linux", "x86_64", "glibc"):
        pytest.skip("the environment is set as glibc lays it out on x86-64")
    return ctypes.CDLL("libm.so.6")


@contextmanager
def environment(name: str) -> Iterator[None]:
    """One of `SETTINGS` for a while."""
    libm, before = library(), (ctypes.c_ubyte * 64)()
    assert libm.fegetenv(before) == 0
    changed = (ctypes.c_ubyte * 64)(*before)
    register = ctypes.c_uint32.from_buffer(changed, MXCSR)
    bits, direction = SETTINGS[name]
    register.value |= bits
    try:
        assert libm.fesetenv(changed) == 0
        if direction:
            assert libm.fesetround(direction) == 0
        yield
    finally:
        libm.fesetenv(before)
