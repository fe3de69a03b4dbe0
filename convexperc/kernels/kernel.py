"""A kernel: interpreted at first, machine code where that pays.

The rule is that of renting or buying: a kernel is interpreted until this has taken, or the work at hand is
expected to take, as long as getting its machine code would. That costs at most twice what the better choice
would have cost, whatever comes. Both give the same bits, so that the choice shows in the time alone.
"""

import os
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from convexperc.caching import cached_property
from convexperc.errors import installed, require, warn_once
from convexperc.kernels import machine_code
from convexperc.kernels.identity import digest

CHOICE_VARIABLE = "CONVEXPERC_KERNELS"
"""Environment variable: ``interpreted`` or ``compiled`` for all work; anything else leaves the choice."""
LOAD_SECONDS = 1.0
"""What importing Numba and loading machine code takes, about."""
LOAD_MORE_SECONDS = 0.05
"""What loading machine code takes after that of another kernel, at most."""
COMPILING = "convexperc.kernels.compiling"
"""The module that imports Numba."""
WITHOUT_NUMBA = (
    "many or large problems or pictures take several times as long as with Numba, which compiles the work: "
    "pip install 'convexperc[fast]'"
)
_LOCK = threading.RLock()
"""Held while a kernel is made: kernels share the copies of what they call, which must be complete."""


@dataclass(eq=False)
class Kernel:
    """A function of numbers and arrays of one type each; calling it calls the function.

    Threads may call it at once. Machine code runs without the interpreter's lock, so that they run side by
    side; while one of them loads or compiles, others that want machine code wait.

    Attributes
    ----------
    function : callable
        Plain Python that Numba can compile, with all that it calls.
    seconds : callable
        What one call takes interpreted, about; its arguments are those of `function`.
    compile_seconds : float
        What compiling it takes, about.
    smallest : tuple
        Arguments of little work, with which the kernel is made if it `replaces` a library.
    """

    function: Callable[..., Any]
    seconds: Callable[..., float]
    compile_seconds: float
    smallest: tuple[Any, ...] = ()
    _machine_code: Callable[..., Any] | None = field(default=None, init=False, repr=False)
    _spent: float = field(default=0.0, init=False, repr=False)
    _demanded: bool = field(default=False, init=False, repr=False)

    def __call__(self, *given: Any) -> Any:
        """Call the function, in the form that pays."""
        if self._machine_code is not None:
            return self._machine_code(*given)
        if self._pays(self._spent + self.seconds(*given)):
            return self.compiled(*given)
        return self.interpreted(*given)

    def replaces(self, seconds: float) -> bool:
        """Whether to use machine code where a library does the same work in so many seconds.

        They stand for those that the function would take interpreted, and count as spent if the library is to
        be used. Otherwise the machine code is there when this returns, and `compiled` calls it; interpreted,
        the function would be far slower than the library.

        Raises
        ------
        MissingExtraError
            Machine code is asked for, and Numba is not installed.
        """
        if self._machine_code is None:
            if not self._pays(self._spent + seconds):
                self._spent += seconds
                return False
            self.compiled(*self.smallest)
        return self._machine_code != self.interpreted

    def interpreted(self, *given: Any) -> Any:
        """Call the function in the interpreter."""
        began = time.perf_counter()
        try:
            with np.errstate(all="ignore"):
                return self.function(*given)
        finally:
            self._spent += time.perf_counter() - began

    def compiled(self, *given: Any) -> Any:
        """Call the function as machine code, which is loaded, or compiled and kept, at the first call.

        Where Numba cannot compile it, the function stays interpreted, and a warning says so.

        Raises
        ------
        MissingExtraError
            Numba is not installed.
        """
        if self._machine_code is None:
            require("numba", "fast", "machine code")
            with _LOCK:
                if self._machine_code is None:
                    return self._first(given)
        return self._machine_code(*given)

    def _first(self, given: tuple[Any, ...]) -> Any:
        """The first call of the machine code; the lock is held."""
        try:
            from convexperc.kernels import compiling  # noqa: PLC0415 - imports Numba

            dispatcher = compiling.dispatcher(self.function, self.name)
            result = dispatcher(*given)
        except Exception as error:  # the function itself raises nothing
            self._machine_code = self.interpreted
            warn_once(f"{self.function.__name__} stays interpreted: Numba cannot compile it ({error!r})")
            return self.interpreted(*given)
        self._machine_code = dispatcher
        return result

    def demand(self) -> None:
        """Use machine code from the next call on."""
        self._demanded = True

    @cached_property
    def name(self) -> str:
        """The function's name, and what it is made of, as a file name."""
        return f"{self.function.__name__}.{sys.implementation.cache_tag}-{digest(self.function)[:32]}"

    def _pays(self, seconds: float) -> bool:
        """Whether machine code is worth having for so many seconds of interpreted work."""
        if self._demanded:
            return True
        choice = os.environ.get(CHOICE_VARIABLE)
        if choice in ("interpreted", "compiled"):
            return choice == "compiled"
        if seconds < (LOAD_MORE_SECONDS if COMPILING in sys.modules else LOAD_SECONDS):
            return False
        if not installed("numba"):
            if seconds > self.compile_seconds:
                warn_once(WITHOUT_NUMBA)
            return False
        return seconds > self.compile_seconds or bool(machine_code.places(self.name))
