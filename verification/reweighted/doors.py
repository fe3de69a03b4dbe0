"""Programs in a process of their own: a command, or a Python function that is imported there.

The program reads one line, a JSON object of the data by name, and writes one, the last line of its output:
``{"answer": ...}``, a number, a list or an object of lists by variable; or ``{"refused": "why"}``. It may
add ``"warned": ["text", ...]``. NaN and Infinity are written as Python writes them.
"""

import importlib
import json
import shlex
import subprocess
import sys
import warnings
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from convexperc.errors import InputError, SolverError, escaped

SECONDS = 60.0
"""Time for one answer."""

KEPT = 300
"""Characters of what a program wrote that a failure shows."""


class Command:
    """A program that is started for each answer; call it with the data by name.

    Parameters
    ----------
    command : str or sequence of str
        As a shell would split it; no shell runs it.
    seconds : float

    Raises
    ------
    InputError
        The command is empty.
    """

    def __init__(self, command: str | Sequence[str], seconds: float = SECONDS) -> None:
        self.words = shlex.split(command) if isinstance(command, str) else list(command)
        if not self.words:
            raise InputError("command", value=command, must="must name a program")
        self.seconds, self.__name__ = seconds, Path(self.words[0]).name

    def __call__(self, **data: Any) -> Any:
        """Ask for one answer.

        Raises
        ------
        SolverError
            The program fails, takes too long, or writes no answer.
        NotImplementedError
            It refuses the input.
        """
        line = json.dumps({name: np.asarray(value).tolist() for name, value in data.items()}) + "\n"
        try:
            done = subprocess.run(
                self.words, input=line.encode(), capture_output=True, timeout=self.seconds, check=False
            )
        except (OSError, subprocess.TimeoutExpired) as fault:
            raise self._failed(
                type(fault).__name__, f"must start, and answer within {self.seconds:g} s"
            ) from None
        if done.returncode:
            words = done.stderr.decode("utf-8", "replace").strip().splitlines()[-1:]
            raise self._failed(f"exit status {done.returncode}", f"must end with status 0, not {words}")
        return self._read(done.stdout.decode("utf-8", "replace"))

    def _read(self, text: str) -> Any:
        try:
            found = json.loads(text.strip().splitlines()[-1])
        except (IndexError, ValueError):
            found = None
        if not isinstance(found, dict) or len(found.keys() & {"answer", "refused"}) != 1:
            raise self._failed(text[-KEPT:], 'must write a JSON object with "answer" or "refused"')
        for warned in found.get("warned", ()):
            warnings.warn(str(warned), UserWarning, stacklevel=3)
        if "refused" in found:
            raise NotImplementedError(escaped(str(found["refused"])))
        return found["answer"]

    def _failed(self, value: str, must: str) -> SolverError:
        return SolverError(f"the program {self.__name__}", value=value, must=must[:KEPT])


def module(target: str, seconds: float = SECONDS) -> Command:
    """A Python function ``package.module:function``, imported in a process of its own for each answer."""
    return Command([sys.executable, "-m", "verification.reweighted.doors", target], seconds)


def serve(target: str, line: str) -> str:
    """The answer of a function to one line.

    Raises
    ------
    InputError
        The target does not name a function.
    """
    package, _, name = target.partition(":")
    function: Callable[..., Any] | None = (
        getattr(importlib.import_module(package), name, None) if name else None
    )
    if function is None:
        raise InputError("target", value=target, must="must be package.module:function")
    data = {
        key: np.array(value) if isinstance(value, list) else value for key, value in json.loads(line).items()
    }
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            found = {"answer": _plain(function(**data))}
        except (ValueError, NotImplementedError) as fault:
            found = {"refused": f"{type(fault).__name__}: {fault}"}
    told = [str(each.message) for each in caught if issubclass(each.category, UserWarning)]
    return json.dumps(found | ({"warned": told} if told else {}))


def _plain(found: Any) -> Any:
    if isinstance(found, dict):
        return {name: np.asarray(value).tolist() for name, value in found.items()}
    return np.asarray(found).tolist()


if __name__ == "__main__":
    sys.stdout.write(serve(sys.argv[1], sys.stdin.readline()) + "\n")
