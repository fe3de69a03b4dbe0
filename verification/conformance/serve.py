"""The program behind ``--module``: reads requests, calls a Python function, writes its answers.

What the function prints goes to standard error, so that it cannot be taken for an answer.
"""

import importlib
import json
import os
import sys
from collections.abc import Callable
from typing import Any

from convexperc.errors import escaped
from verification.conformance.calling import call


def function(place: str) -> Callable[..., Any]:
    """The function that ``package.module:function`` names."""
    module, _, path = place.partition(":")
    found: Any = importlib.import_module(module)
    for name in path.split("."):
        found = getattr(found, name)
    if not callable(found):
        raise TypeError(f"{place} is no function")
    return found  # type: ignore[no-any-return]


def serve(place: str) -> None:
    """Answer every line of standard input until it ends; where there is no such function, say why."""
    with os.fdopen(os.dup(1), "w", encoding="utf-8") as answers:
        os.dup2(2, 1)
        try:
            solve = function(place)
        except BaseException as error:  # whatever a module raises when it is imported
            found = f"{type(error).__name__}: {escaped(str(error))}"
            print(json.dumps({"unusable": found}), file=answers, flush=True)
            return
        for line in sys.stdin:
            print(json.dumps(call(solve, json.loads(line)), default=repr), file=answers, flush=True)


def main() -> None:
    """Serve the function that the command line names; it is looked for in the working directory first."""
    sys.path.insert(0, os.getcwd())  # noqa: PTH109 - as Python itself puts it there
    serve(sys.argv[1])
