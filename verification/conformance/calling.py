"""One call of a Python solver: a request's data in, an answer's data out."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from convexperc.errors import escaped
from verification.conformance.request import LAMBDAS

OPTIONAL = ("objective", "trace")
VECTORS = ("w", "u")
RESERVED = ("id", "changes", "unusable")
"""Keys of the kit's own, which an answer cannot set."""


def call(solve: Callable[..., Any], data: Mapping[str, Any]) -> dict[str, Any]:
    """Call ``solve(X, o, modalities, lambda1, lambda2, lambda3)`` and put what it returns into an answer.

    X is a float64 array (n, d), o (d,), modalities a list of sizes. It returns ``(w, u)``,
    ``(w, u, objective)``, a mapping, or an object with the attributes ``w`` and ``u`` and perhaps
    ``objective`` and ``trace``. `NotImplementedError` says that a request is not for this solver; every other
    exception is the answer "error". The key ``changes`` has the names of arguments that the function changed.
    """
    try:
        given, kept = _arguments(data)
        found = solve(*given.values(), **{name: data[name] for name in LAMBDAS})
        answer = {"id": data["id"]} | {name: _plain(value) for name, value in _fields(found).items()}
        changed = [name for name, value in kept.items() if not _same(value, given[name])]
        return answer | ({"changes": changed} if changed else {})
    except NotImplementedError as reason:
        return {"id": data["id"], "unsupported": _text(reason)}
    except (Exception, SystemExit) as error:  # whatever a solver raises is its answer
        return {"id": data["id"], "error": f"{type(error).__name__}: {_text(error)}"}


def _arguments(data: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """The arguments that a solver gets, and copies of them that it does not see."""
    given: dict[str, Any] = {name: np.array(data[name], dtype=np.float64) for name in ("X", "o")}
    given |= {"modalities": list(data["modalities"])}
    return given, {name: value.copy() for name, value in given.items()}


def _same(value: Any, other: Any) -> bool:
    return value == other if isinstance(value, list) else np.array_equal(value, other, equal_nan=True)


def _fields(found: Any) -> dict[str, Any]:
    if isinstance(found, Mapping):
        return {name: value for name, value in found.items() if name not in RESERVED}
    if isinstance(found, (tuple, list)):
        return dict(zip((*VECTORS, *OPTIONAL), found, strict=False))
    names = [name for name in (*VECTORS, *OPTIONAL) if getattr(found, name, None) is not None]
    return {name: getattr(found, name) for name in names}


def _plain(value: Any) -> Any:
    """Lists and floats; NaN and infinity stay, and are then no JSON."""
    if value is None or isinstance(value, str):
        return value
    entries = np.asarray(value)
    return entries.astype(np.float64).tolist() if entries.dtype.kind in "fiub" else entries.tolist()


def _text(error: BaseException) -> str:
    return escaped(str(error)) or "no message"
