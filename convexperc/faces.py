"""The public names of a package, as the stub beside its ``__init__.py`` lists them, loaded on first use."""

import ast
import sys
from collections.abc import Callable
from typing import Any

import lazy_loader

Face = tuple[Callable[[str], Any], Callable[[], list[str]], list[str]]
"""``__getattr__``, ``__dir__`` and ``__all__`` of a module."""


def attach(package: str) -> Face:
    """Return what loads the names of a package, to be called in its ``__init__.py`` with ``__name__``.

    The stub, ``__init__.pyi``, is read by what has loaded the package, so that it may lie in an archive, in
    which `lazy_loader.attach_stub` finds no file.
    """
    spec = sys.modules[package].__spec__
    stub: bytes = spec.loader.get_data(f"{spec.origin}i")  # type: ignore[union-attr]
    modules, names = set[str](), dict[str, list[str]]()
    for node in ast.parse(stub).body:
        if isinstance(node, ast.ImportFrom):
            found = [alias.name for alias in node.names]
            if node.module:
                names.setdefault(node.module, []).extend(found)
            else:
                modules.update(found)
    face: Face = lazy_loader.attach(package, modules, names)
    return face
