"""Machine code of a kernel and of all that it calls, by Numba; imported only where it is worth it.

The functions are plain Python, and stay so: copies of them are compiled, whose global names are the compiled
copies of what they call. Only the kernel itself can be called from Python; the others get no wrappers.
"""

import hashlib
import pickle
import types
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numba
from llvmlite import binding
from numba.core import types as numba_types
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler, CompileResult
from numba.core.serialize import dumps

from convexperc.errors import warn_once
from convexperc.kernels import machine_code
from convexperc.kernels.identity import called
from convexperc.kernels.routines import Routine

ADDRESS = numba_types.intp


class Part(JITCodeLibrary):
    """What a kernel calls: optimised and turned into machine code with the kernel that it is linked into.

    Numba does this for every function, each with all that it calls, which takes about as long again.
    """

    def _optimize_final_module(self) -> None:
        """Left to the kernel."""

    def _finalize_final_module(self) -> None:
        """The part of it that linking needs."""
        self._finalize_dynamic_globals()  # type: ignore[no-untyped-call]
        self._finalized = True


class PartCompiler(Compiler):
    """Compiles into a `Part`."""

    def compile_extra(self, func: Any) -> Any:
        """Make code for other kernels to call, and nothing that Python could."""
        state = self.state
        codegen, state.flags.no_compile = state.targetctx.codegen(), True
        state.library = Part(codegen, func.__qualname__)  # type: ignore[no-untyped-call]
        result = super().compile_extra(func)  # type: ignore[no-untyped-call]
        key = [func].copy  # only has to be a built-in function, and to differ from all others
        state.targetctx.insert_user_function(key, result.fndesc, [result.library])
        return result._replace(entry_point=key)


OUTER = {"error_model": "numpy", "nogil": True, "no_cfunc_wrapper": True, "_nrt": False}
INNER = {**OUTER, "no_cpython_wrapper": True, "pipeline_class": PartCompiler}
"""Options of a kernel, which is called from Python, and of what it calls. Kernels allocate nothing; without
Numba's counting of references to arrays they take less than half the time. They run without the interpreter's
lock: all that they touch is that of their caller."""


@dataclass(frozen=True)
class Cache:
    """Machine code of one kernel on disk, in place of Numba's own cache.

    Numba's index notices a change of the kernel's own file alone, and raises where it is damaged or where no
    folder can be written; see `convexperc.kernels.machine_code`.

    Attributes
    ----------
    name : str
        Names the kernel and all that it is made of.
    """

    name: str

    def load_overload(self, signature: Any, target: Any) -> Any:
        """The machine code for arguments of these types, or None."""
        content = machine_code.read(self.name, self._form(signature))
        if content is None:
            return None
        target.refresh()
        try:
            return CompileResult._rebuild(target, *pickle.loads(content))  # type: ignore[no-untyped-call]
        except Exception:  # whatever another version of Numba may have written
            return None

    def save_overload(self, signature: Any, result: Any) -> None:
        """Keep the machine code for other processes."""
        content = dumps(result._reduce())  # type: ignore[no-untyped-call]
        if machine_code.write(self.name, self._form(signature), content) is None:
            tried = ", ".join(map(str, machine_code.folders())) or "none is known"
            warn_once(
                f"each process compiles anew, because no folder for machine code can be written ({tried}); "
                f"set {machine_code.FOLDER_VARIABLE} to one that can"
            )

    def _form(self, signature: Any) -> str:
        return hashlib.sha256(str(signature).encode()).hexdigest()[:16]


_MADE: dict[Callable[..., Any], Any] = {}
"""The copies of what kernels call, which they share."""


def dispatcher(function: Callable[..., Any], name: str) -> Any:
    """The kernel, to be loaded or compiled at its first call."""
    found = _copied(function, OUTER)
    found._cache = Cache(name)
    return found


def _copied(function: Callable[..., Any], options: dict[str, Any]) -> Any:
    """A copy of the function that Numba compiles, and that calls such copies."""
    scope = dict(function.__globals__)
    copy = types.FunctionType(function.__code__, scope, function.__name__)
    copy.__module__ = function.__module__
    made: Any = numba.njit(**options)(copy)
    if options is INNER:
        _MADE[function] = made
    made.get_call_template = partial(_without_literals, made.get_call_template)
    for name, value in called(function):
        if isinstance(value, Routine):
            scope[name] = _external(value)
        else:
            scope[name] = _MADE[value] if value in _MADE else _copied(value, INNER)
    return made


def _without_literals(template: Callable[..., Any], types_given: Any, named: Any) -> Any:
    """Resolve a call by the types of its arguments; Numba makes another version for each constant integer."""
    return template(tuple(map(numba_types.unliteral, types_given)), named)


def _external(routine: Routine) -> Any:
    """A routine by the name under which machine code, also when it is loaded again, finds it."""
    symbol = f"convexperc_{routine.name}"
    binding.add_symbol(symbol, routine.address)
    result = numba_types.float64 if routine.returns_number else numba_types.void
    return numba_types.ExternalFunction(symbol, result(*([ADDRESS] * routine.arguments)))
