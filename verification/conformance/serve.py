"""The program behind ``--module``: reads requests, calls a Python function, writes its answers.

What the function prints goes to standard error, so that it cannot be taken for an answer.
"""

import importlib
import json
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import IO, Any

from pydantic_core import from_json, to_json

from convexperc.errors import escaped
from verification.conformance.answers import AnswerError, number, parsed, vector
from verification.conformance.calling import call
from verification.conformance.process import PIPE
from verification.conformance.request import LAMBDAS


def function(place: str) -> Callable[..., Any]:
    """The function that ``package.module:function`` names."""
    module, _, path = place.partition(":")
    found: Any = importlib.import_module(module)
    for name in path.split("."):
        found = getattr(found, name)
    if not callable(found):
        raise TypeError(f"{place} is no function")
    return found  # type: ignore[no-any-return]


def serve(solve: Callable[..., Any], read: Callable[[bytes], dict[str, Any]] = from_json) -> None:
    """Answer every line of standard input until it ends; a line that `read` refuses gets an error."""
    with _answers() as answers:
        _serve(solve, read, answers)


@contextmanager
def _answers() -> Iterator[IO[bytes]]:
    """Where answers are written; what else is printed goes to standard error."""
    with os.fdopen(os.dup(1), "wb") as answers:
        os.dup2(2, 1)
        yield answers


def _serve(solve: Callable[..., Any], read: Callable[[bytes], dict[str, Any]], answers: IO[bytes]) -> None:
    with os.fdopen(os.dup(0), "rb", PIPE) as requests:
        for line in requests:
            try:
                answer = call(solve, read(line))
            except AnswerError as fault:
                answer = {"id": _id(line), "error": str(fault)}
            _write(answer, answers)


def _write(answer: dict[str, Any], answers: IO[bytes]) -> None:
    """Write an answer as one line; what is no JSON value becomes text, which the kit takes for no number."""
    fast = all(_is_plain(key) and _is_plain(value) for key, value in answer.items())
    answers.write((to_json(answer) if fast else json.dumps(answer, default=repr).encode()) + b"\n")
    answers.flush()


def _is_plain(value: Any) -> bool:
    """Whether it is ASCII text, a float or a list of floats, which pydantic-core writes as `json` does."""
    if isinstance(value, list):
        return set(map(type, value)) <= {float}
    return value.isascii() if type(value) is str else type(value) is float


def strictly(line: bytes | str) -> dict[str, Any]:
    """Read a request, or say what is wrong with it; that the numbers fit each other is the solver's to check.

    Raises
    ------
    AnswerError
        It is no JSON object, a key is missing, or a value has another type or size than it must have.
    """
    data = parsed(line)
    if missing := [key for key in ("id", "n", "d", "modalities", "X", "o", *LAMBDAS) if key not in data]:
        raise AnswerError(f"has no {' and no '.join(missing)}")
    if not isinstance(data["X"], list) or len(data["X"]) != data["n"] or data["n"] == 0:
        raise AnswerError("X must be a list of n >= 1 rows")
    X = [vector(row, f"X[{k}]", data["d"]).tolist() for k, row in enumerate(data["X"])]
    sizes = data["modalities"]
    if not isinstance(sizes, list) or not all(type(size) is int for size in sizes):
        raise AnswerError("modalities must be a list of whole numbers")
    weights = {name: number(data[name], name) for name in LAMBDAS}
    return data | {"X": X, "o": vector(data["o"], "o", data["d"]).tolist()} | weights


def _id(line: bytes) -> Any:
    """The id of a line that is no request, as far as there is one."""
    try:
        return parsed(line).get("id")
    except AnswerError:
        return None


def main() -> None:
    """Serve the function that the command line names, or say why there is none.

    It is looked for in the working directory first.
    """
    sys.path.insert(0, os.getcwd())  # noqa: PTH109 - as Python itself puts it there
    with _answers() as answers:
        try:
            solve = function(sys.argv[1])
        except BaseException as error:  # whatever a module raises when it is imported
            found = f"{type(error).__name__}: {escaped(str(error))}"
            _write({"unusable": found}, answers)
            return
        _serve(solve, from_json, answers)
