"""BLAS and LAPACK routines of SciPy, called by the addresses of their arguments.

Interpreted and compiled code call the same function in memory, so that both give the same bits.
"""

import ctypes
import importlib
from dataclasses import dataclass
from typing import Any

from convexperc.caching import cached_property


@dataclass(frozen=True)
class Routine:
    """One of SciPy's routines; calling it takes one address for each argument.

    Attributes
    ----------
    library : str
        The module of ``scipy.linalg`` that exports it: ``cython_blas`` or ``cython_lapack``.
    name : str
        Its BLAS or LAPACK name.
    arguments : int
    returns_number : bool
        Whether it returns a float64; otherwise it returns nothing.
    """

    library: str
    name: str
    arguments: int
    returns_number: bool = False

    def __call__(self, *addresses: Any) -> Any:
        """Call it from the interpreter."""
        return self._callable(*map(int, addresses))

    @cached_property
    def address(self) -> int:
        """Where it lies in this process."""
        exported = importlib.import_module(f"scipy.linalg.{self.library}").__pyx_capi__[self.name]
        name_of, pointer_of = ctypes.pythonapi.PyCapsule_GetName, ctypes.pythonapi.PyCapsule_GetPointer
        name_of.restype, name_of.argtypes = ctypes.c_char_p, [ctypes.py_object]
        pointer_of.restype, pointer_of.argtypes = ctypes.c_void_p, [ctypes.py_object, ctypes.c_char_p]
        return int(pointer_of(exported, name_of(exported)))

    @cached_property
    def _callable(self) -> Any:
        result = ctypes.c_double if self.returns_number else None
        return ctypes.PYFUNCTYPE(result, *([ctypes.c_void_p] * self.arguments))(self.address)
