"""What a kernel is made of: the functions that it reaches, their constants, and the versions under it."""

import dis
import functools
import hashlib
import platform
import sys
import types
from collections.abc import Callable, Iterator
from importlib import metadata
from importlib.util import find_spec
from typing import Any

import numpy as np

from convexperc.kernels.routines import Routine

PACKAGES = ("llvmlite", "numba", "numpy", "scipy")


def called(function: Callable[..., Any]) -> Iterator[tuple[str, Any]]:
    """The plain functions and routines that a function calls, by the names it uses."""
    for name, value in _globals(function):
        if isinstance(value, (types.FunctionType, Routine)):
            yield name, value


def _globals(function: Callable[..., Any]) -> Iterator[tuple[str, Any]]:
    """The global names that a function uses, once each, and what they stand for; built-in ones left out."""
    loads = (each.argval for each in dis.get_instructions(function) if each.opname == "LOAD_GLOBAL")
    for name in dict.fromkeys(loads):
        if name in function.__globals__:
            yield name, function.__globals__[name]


def digest(function: Callable[..., Any]) -> str:
    """Hash of all code that a kernel reaches, of the constants it uses, of the packages and the processor."""
    found = hashlib.sha256()
    for part in (*_platform(), *_parts(function, set())):
        found.update(part.encode() + b"\0")
    return found.hexdigest()


@functools.cache
def _platform() -> tuple[str, ...]:
    """How kernels are compiled, by what, and for which processor."""
    from llvmlite import binding  # noqa: PLC0415 - slow and optional

    compiling = find_spec("convexperc.kernels.compiling")
    assert compiling is not None
    how = "".join(_code(compiling.loader.get_code(compiling.name)))  # type: ignore[union-attr]
    versions = tuple(f"{name} {metadata.version(name)}" for name in PACKAGES)
    features = binding.get_host_cpu_features().flatten()
    return how, *versions, sys.version, platform.platform(), binding.get_host_cpu_name(), features


def _parts(function: Callable[..., Any], seen: set[Callable[..., Any]]) -> Iterator[str]:
    """The function's code and constants, then those of what it calls."""
    seen.add(function)
    code = function.__code__
    yield f"{function.__module__}.{function.__qualname__}"
    yield from _code(code)
    for name, value in _globals(function):
        if isinstance(value, types.FunctionType):
            if value not in seen:
                yield from _parts(value, seen)
        elif isinstance(value, type):
            yield f"{name} {value.__module__}.{value.__qualname__} {getattr(value, '_fields', ())}"
        elif not isinstance(value, types.ModuleType):
            yield f"{name} {_constant(value)}"


def _code(code: types.CodeType) -> Iterator[str]:
    """What a piece of code does, wherever its source lies."""
    yield repr((code.co_code, code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars))
    for value in code.co_consts:
        if isinstance(value, types.CodeType):
            yield from _code(value)
        else:
            yield _constant(value)


def _constant(value: Any) -> str:
    """A value that tells it apart from every other one."""
    if isinstance(value, float):
        return value.hex()
    if isinstance(value, np.ndarray):
        return f"{value.dtype} {value.shape} {value.tobytes().hex()}"
    return repr(value)
