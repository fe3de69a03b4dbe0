"""Programs in a process of their own: a command, or a Python function that is imported there.

The program reads one line, a JSON object of the data by name, and writes one, the last line of its output:
``{"answer": ...}``, a number, a list or an object of lists by variable; or ``{"refused": "why"}``. It may
add ``"warned": ["text", ...]``. NaN and Infinity are written as Python writes them.
"""

import importlib
import json
import shlex
import sys
import warnings
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from convexperc.errors import InputError, SolverError, escaped
from verification.conformance.process import Process
from verification.reweighted.programs.inputs import arrays, line, listed

SECONDS = 60.0
"""Time for one answer."""

KEPT = 300
"""Characters of what a program wrote that a failure shows."""

LONGEST = 1 << 26
"""Bytes that a program may write."""


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
        """Ask for one answer; the program and all that it started are ended then.

        Raises
        ------
        SolverError
            The program fails, takes too long, writes too much, or writes no answer.
        NotImplementedError
            It refuses the input.
        """
        sent = f"{line(listed(data))}\n".encode()
        try:
            process = Process.start(self.words, None)
        except OSError as fault:
            raise self._failed(type(fault).__name__, "must start") from None
        try:
            with process.listening(sent, last=True) as ready:
                while len(process.out) <= LONGEST and ready(ready.start + self.seconds):
                    pass
                code = ready.code(self.seconds)
        finally:
            process.kill()
        if len(process.out) > LONGEST:
            raise self._failed(f"more than {LONGEST} bytes", "must write an answer")
        if code is None:
            raise self._failed("no answer", f"must answer and end within {self.seconds:g} s")
        if code:
            words = process.last_words.splitlines()[-1:]
            raise self._failed(f"exit status {code}", f"must end with status 0, not {words}")
        return self._read(process.out.decode("utf-8", "replace"))

    def _read(self, text: str) -> Any:
        try:
            found = json.loads(text.strip().splitlines()[-1])
        except (IndexError, ValueError):
            found = None
        return answered(found, self._what, text[-KEPT:])

    @property
    def _what(self) -> str:
        return f"the program {self.__name__}"

    def _failed(self, value: str, must: str) -> SolverError:
        return SolverError(self._what, value=value, must=must[:KEPT])


def answered(found: Any, what: str, text: str) -> Any:
    """What an object says that answers an input; warnings of the program are given.

    Parameters
    ----------
    found : Any
        As read from JSON.
    what, text : str
        Who wrote it, and how, for the error.

    Raises
    ------
    SolverError
        It has not one of ``answer`` and ``refused``, or ``warned`` is no list; null stands for nothing.
    NotImplementedError
        The program refuses the input.
    """
    if isinstance(found, dict):  # an answer that is null is none that can be read
        given = {key: value for key, value in found.items() if value is not None}
        found = given if given.keys() & {"answer", "refused"} else found
    if not isinstance(found, dict) or len(found.keys() & {"answer", "refused"}) != 1:
        raise SolverError(what, value=text, must='must write a JSON object with "answer" or "refused"')
    warned = found.get("warned", [])
    if not isinstance(warned, list):
        raise SolverError(what, value=text, must='must write "warned" as a list of texts')
    for each in warned:
        warnings.warn(str(each), UserWarning, stacklevel=3)
    if "refused" in found:
        raise NotImplementedError(escaped(str(found["refused"])))
    return found["answer"]


def module(target: str, seconds: float = SECONDS) -> Command:
    """A Python function ``package.module:function``, imported in a process of its own for each answer."""
    return Command([sys.executable, "-m", "verification.reweighted.programs.doors", target], seconds)


def serve(target: str, given: str) -> str:
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
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            answer, refused = function(**arrays(json.loads(given))), ""
        except (ValueError, NotImplementedError) as fault:
            answer, refused = None, f"{type(fault).__name__}: {fault}"
    found = {"refused": refused} if refused else {"answer": _plain(answer)}
    told = [str(each.message) for each in caught if issubclass(each.category, UserWarning)]
    return json.dumps(found | ({"warned": told} if told else {}))


def _plain(found: Any) -> Any:
    if isinstance(found, dict):
        return {name: np.ma.asarray(value).tolist() for name, value in found.items()}
    return np.ma.asarray(found).tolist()


if __name__ == "__main__":
    sys.stdout.write(serve(sys.argv[1], sys.stdin.readline()) + "\n")
