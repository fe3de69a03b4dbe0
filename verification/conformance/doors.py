"""Doors: how a solver is asked. A program, a Python function, a folder of answers.

Whatever comes back, or does not, is a fault of the solver, told beside the answer; no door raises over it.
"""

import json
import shlex
import signal
import sys
import time
from collections.abc import Callable, Sequence, Set
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol, Self

from convexperc.errors import InputError
from convexperc.files import parse_json
from verification.conformance.answers import Answer, AnswerError, Refusal, parsed, read_answer, shown
from verification.conformance.calling import call
from verification.conformance.process import Listening, Process
from verification.conformance.request import Request

SECONDS = 10.0
"""Time for one answer, unless the caller says otherwise."""

STARTING = 30.0
"""More seconds for the first answer of a process: it may load or compile what it needs."""

LONGEST_WAIT = 86400.0
"""Most seconds that an answer may be given."""

FRUITLESS, PATIENT = 3, 100
"""Ends in a row without an answer after which a program is given up: one that never answered, and another."""

STRANGERS = 1000
"""Lines after a request that are not its answer, from which on nothing more is awaited."""

GRACE = 1.0
"""Seconds for the answer, once something came in its place that cannot be read or has another id."""

LONGEST = 1 << 22
"""Bytes of an answer beyond the numbers that it must hold: its trace and what surrounds them."""

PER_NUMBER = 64
"""Bytes that one number of an answer may take."""

ROOT = Path(__file__).parents[2]
SERVE = (
    "import sys; sys.path.insert(0, sys.argv.pop(1)); from verification.conformance.serve import main; main()"
)
"""Imports this kit first, whatever else is called like it where the solver is."""

LAST_WORDS = "; its standard error ends: "
"""What parts a fault from the end of standard error, which is the machine's own."""


class NotAskedError(Exception):
    """The solver was given up, and this request was not asked; the message says why."""


@dataclass
class Reply:
    """What came of a request.

    Attributes
    ----------
    answer : Answer, Refusal or None
        None where there is none that can be read.
    faults : list of str
        What was wrong with the way it came, or why there is none.
    seconds : float
        From the request to the answer.
    """

    answer: Answer | Refusal | None = None
    faults: list[str] = field(default_factory=list)
    seconds: float = 0.0

    def take(self, data: dict[str, Any], request: Request) -> None:
        """Read what answers a request; what cannot be read is a fault."""
        try:
            self.answer = read_answer(data, request)
        except AnswerError as fault:
            self.faults.append(str(fault))


class Door(Protocol):
    """How a solver is asked; one that was given up raises `NotAskedError`, and is tried anew after that.

    Attributes
    ----------
    name : str
        For reports.
    reads_lines : bool
        Whether it reads lines as they are, malformed JSON included.
    """

    name: str
    reads_lines: bool

    def ask(self, request: Request) -> Reply:
        """Ask for the answer to a request."""

    def ask_malformed(self, id: str, line: str) -> tuple[dict[str, Any] | None, list[str]]:  # noqa: A002
        """Send a line that is no valid request; return the object that came back, and faults."""

    def earlier(self) -> list[str]:
        """Faults that the last request showed, but that belong to the one before it."""

    def close(self) -> list[str]:
        """End; return the faults that were seen only then, such as a second answer to the last request."""


class Command:
    """A program that reads one request a line and writes one answer a line.

    It is started once for many requests, and again after it has ended or was killed.

    Parameters
    ----------
    command : str or sequence of str
        As a shell would split it; no shell runs it.
    seconds : float
        Time for one answer.
    starting : float
        More of it for the first answer of a process.
    name : str, optional
        For reports; the command where it is left out.
    folder : Path, optional
        Where it runs.

    Raises
    ------
    InputError
        The command is empty or has an open quote, there is no such program, or `seconds` is out of range.
    """

    reads_lines = True

    def __init__(
        self,
        command: str | Sequence[str],
        *,
        seconds: float = SECONDS,
        starting: float = STARTING,
        name: str = "",
        folder: Path | None = None,
    ) -> None:
        try:
            self.words = shlex.split(command) if isinstance(command, str) else list(command)
        except ValueError as problem:
            raise InputError("command", value=command, must=f"must be a command line: {problem}") from None
        if not self.words:
            raise InputError("command", value=command, must="must name a program")
        if not 0.0 < seconds <= LONGEST_WAIT:
            raise InputError("timeout", value=seconds, must=f"must be seconds, at most {LONGEST_WAIT:g}")
        self.name = name or shlex.join(self.words)
        self.seconds, self.starting, self.folder = seconds, starting, folder
        self._process: Process | None = None
        self._answered, self._asked = False, ""
        self._ever, self._fruitless = False, 0
        self._earlier: list[str] = []

    def ask(self, request: Request) -> Reply:
        """Ask; see `Door`."""
        reply, start = Reply(), time.perf_counter()
        room = LONGEST + PER_NUMBER * (request.problem.n + request.problem.d)
        data = self._answer(request.id, request.line, room, reply.faults)
        if data is not None:
            reply.take(data, request)
        reply.seconds = time.perf_counter() - start
        return reply

    def ask_malformed(self, id: str, line: str) -> tuple[dict[str, Any] | None, list[str]]:  # noqa: A002
        """Send a malformed line; see `Door`. The answer may have the id null where the line hides its id."""
        faults: list[str] = []
        return self._answer(id, line, LONGEST, faults, anonymous=True), faults

    def earlier(self) -> list[str]:
        """A second answer, other text after the answer, or a crash; see `Door`."""
        found, self._earlier = self._earlier, []
        return found

    def close(self) -> list[str]:
        """Close its input, read what it still writes, and end it."""
        process, self._process, self._fruitless = self._process, None, 0
        return [f"after the last answer: {shown(line)}" for line in (process.finish() if process else [])]

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def _answer(
        self,
        id: str,  # noqa: A002
        line: str,
        room: int,
        faults: list[str],
        *,
        anonymous: bool = False,
    ) -> dict[str, Any] | None:
        """Send a line; return the object that answers it, if one comes in time. Faults are added meanwhile.

        A program that ended in peace after an answer is started again and asked again.
        """
        for _ in range(2):
            process, again = self._started(), self._answered
            data = self._heard(process, id, line, room, faults, anonymous)
            if data is not None:
                self._answered, self._ever, self._fruitless = True, True, 0
                return data
            if not (again and process.popen.returncode == 0 and not faults):
                break
        return None

    def _heard(
        self,
        process: Process,
        id: str,  # noqa: A002
        line: str,
        room: int,
        faults: list[str],
        anonymous: bool,
    ) -> dict[str, Any] | None:
        """What a process answers; None, with the process ended, where that does not come in time."""
        before, self._asked = self._asked, id
        allowed, graced = self.seconds + (0.0 if self._answered else self.starting), False
        with process.listening(line.encode() + b"\n") as ready:
            for _ in range(STRANGERS):
                got = ready.line(allowed, room)
                if got is None:
                    self._ended(process, faults, ready, allowed, room, graced)
                    return None
                if not got.strip():
                    continue
                try:
                    data = self._read(got, faults)
                    given = data.get("id")
                    if given == id or (anonymous and given is None):
                        return data
                    repeated = bool(before) and given == before
                    if repeated:
                        self._earlier.append("answers a second time")
                    else:
                        faults.append(f"answers with the id {shown(given)}, asked was {shown(id)}")
                except AnswerError as fault:
                    faults.append(str(fault))
                    repeated = False
                if not repeated and not graced and got.lstrip(b"\xef\xbb\xbf \t")[:1] in (b"{", b"["):
                    allowed, graced = min(allowed, ready.elapsed + GRACE), True
        self._give_up(process, faults, "writes one line after the other that is no answer")
        return None

    def _read(self, line: bytes, faults: list[str]) -> dict[str, Any]:
        """Read a line; raises `AnswerError`."""
        return parsed(line)

    def _started(self) -> Process:
        process = self._process
        if process is not None and self._answered:
            self._earlier += [f"after its answer: {shown(line)}" for line in process.waiting()]
            if code := process.popen.poll():
                self._earlier.append(f"ended with {_ending(code)} after its answer")
                process.kill()
                self._process = None
        if self._process is not None:
            return self._process
        if self._fruitless >= (PATIENT if self._ever else FRUITLESS):
            count, self._fruitless = self._fruitless, 0
            raise NotAskedError(f"it was given up after {count} requests in a row without an answer")
        try:
            self._process = Process.start(self.words, self.folder)
        except OSError as problem:
            must = f"must name a program that can be started ({problem.strerror})"
            raise InputError("command", value=self.name, must=must) from None
        self._answered, self._asked = False, ""
        return self._process

    def _ended(
        self,
        process: Process,
        faults: list[str],
        ready: Listening,
        allowed: float,
        room: int,
        graced: bool,
    ) -> None:
        """Nothing more to read: it has ended, the time is over, or a line has no end."""
        if len(process.out) > room:
            self._give_up(process, faults, f"writes a line of more than {room} bytes")
            return
        code = ready.code(allowed)
        if code == 0 and self._answered and not process.out:
            self._process = None
            process.kill()
            return
        said = process.last_words[-400:]
        words = f"{LAST_WORDS}{shown(said)}" if said else ""
        if code is not None:
            why = f"ended with {_ending(code)} before it answered{words}"
        elif ready.closed:
            why = f"closed its output before it answered{words}"
        elif graced:
            why = ""
        elif ready.pending:
            why = f"did not read the request within {allowed:g} s"
        else:
            why = f"no answer within {allowed:g} s{words}"
        self._give_up(process, faults, why)

    def _give_up(self, process: Process, faults: list[str], why: str) -> None:
        faults += [why] if why else []
        process.kill()
        self._process = None
        self._fruitless += 1


def _ending(code: int) -> str:
    """How a program ended."""
    return f"signal {_signal(-code)}" if code < 0 else f"exit code {code}"


def _signal(number: int) -> str:
    """Its name; a real-time signal has none."""
    return signal.Signals(number).name if number in set(signal.Signals) else str(number)


class Module(Command):
    """A Python function ``solve(X, o, modalities, lambda1, lambda2, lambda3)``, in a process of its own.

    There a crash, an endless loop or a print is a finding and harms nobody; `serve` calls the function.

    Parameters
    ----------
    place : str
        ``package.module:function``.
    """

    reads_lines = False

    def __init__(
        self, place: str, *, seconds: float = SECONDS, starting: float = STARTING, folder: Path | None = None
    ) -> None:
        module, _, function = place.partition(":")
        if not all(part.isidentifier() for part in (*module.split("."), *function.split("."))):
            remedy = "A program is asked by its command: --command, or a list of words in assert_conforms."
            raise InputError("module", value=place, must="must be package.module:function", remedy=remedy)
        serve = [sys.executable, "-P", "-c", SERVE, str(ROOT), place]
        super().__init__(serve, seconds=seconds, starting=starting, name=place, folder=folder)

    def _read(self, line: bytes, faults: list[str]) -> dict[str, Any]:
        data = parsed(line)
        if "unusable" in data:
            must = f"must name a function that can be imported; {data['unusable']}"
            raise InputError("module", value=self.name, must=must)
        faults += _changes(data)
        return data


def _changes(data: dict[str, Any]) -> list[str]:
    """What `calling.call` says of arguments that a function changed."""
    return [f"changes {name}, which belongs to the caller" for name in data.pop("changes", ())]


class Function:
    """A Python function that is called in this process: a crash or an endless loop in it is one here.

    Parameters
    ----------
    solve : callable
        ``solve(X, o, modalities, lambda1, lambda2, lambda3)``; see `verification.conformance.calling.call`.
    """

    reads_lines = False

    def __init__(self, solve: Callable[..., Any]) -> None:
        self.solve, self.name = solve, getattr(solve, "__qualname__", repr(solve))

    def ask(self, request: Request) -> Reply:
        """Call it; see `Door`."""
        reply, start = Reply(), time.perf_counter()
        data = call(self.solve, request.as_json())
        reply.seconds = time.perf_counter() - start
        reply.faults += _changes(data)
        reply.take(data, request)
        return reply

    def ask_malformed(self, id: str, line: str) -> tuple[dict[str, Any] | None, list[str]]:  # noqa: A002
        """Call it with what the line says; see `Door`."""
        data = call(self.solve, json.loads(line))
        return data, _changes(data)

    def earlier(self) -> list[str]:
        """Nothing; see `Door`."""
        return []

    def close(self) -> list[str]:
        """Nothing is left over."""
        return []


class Results:
    """Answers that were made elsewhere: every ``*.json`` and ``*.jsonl`` of a folder, one answer a line.

    Parameters
    ----------
    folder : Path
    known : set of str
        Every id there is, whether or not it is asked for this time.

    Raises
    ------
    InputError
        There is no such folder, or no such file in it.
    """

    reads_lines = True

    def __init__(self, folder: Path, known: Set[str]) -> None:
        self.name, self.known = str(folder), known
        files = sorted(each for each in folder.glob("*.json*") if each.suffix in {".json", ".jsonl"})
        if not files:
            must = "must be a folder with answers in *.json or *.jsonl"
            raise InputError("results", value=str(folder), must=must)
        self.found: dict[str, list[dict[str, Any]]] = {}
        self.nameless: list[dict[str, Any]] = []
        self.strays: list[str] = []
        for file in files:
            for line, text in enumerate(_answers(file), 1):
                self._take(text, f"{file.name}:{line}")

    def _take(self, text: bytes, place: str) -> None:
        try:
            data = parsed(text)
        except AnswerError as fault:
            self.strays.append(f"{place}: {fault}")
            return
        if isinstance(data.get("id"), str):
            self.found.setdefault(data["id"], []).append(data)
        elif "error" in data:
            self.nameless.append(data)
        else:
            self.strays.append(f"{place}: has no id")

    def ask(self, request: Request) -> Reply:
        """Look the answer up; see `Door`."""
        reply = Reply()
        data, reply.faults = self._told(request.id)
        if data is not None:
            reply.take(data, request)
        return reply

    def ask_malformed(self, id: str, line: str) -> tuple[dict[str, Any] | None, list[str]]:  # noqa: A002
        """Look the answer up; see `Door`. An error without an id answers one line, whichever that was."""
        if id not in self.found and self.nameless:
            return self.nameless.pop(), []
        return self._told(id)

    def _told(self, id: str) -> tuple[dict[str, Any] | None, list[str]]:  # noqa: A002
        found = self.found.get(id, [])
        faults = [] if len(found) == 1 else [f"{len(found)} answers"] if found else ["no answer"]
        return (found[0] if found else None), faults

    def earlier(self) -> list[str]:
        """Nothing; see `Door`."""
        return []

    def close(self) -> list[str]:
        """What is no answer to any request."""
        unknown = sorted(set(self.found) - self.known)
        return self.strays + [f"answers {shown(each)}, which there is not" for each in unknown]


def _answers(file: Path) -> list[bytes]:
    """The answers of a file: its lines, or the whole file where that is one JSON object.

    Raises
    ------
    InputError
        It is no ordinary file that can be read, or one JSON list.
    """
    remedy = "Remove or rename it."
    if not file.is_file():
        what = "a link that leads nowhere" if not file.exists() else "no ordinary file"
        raise InputError(f"results: {file}", value=what, must="must be a file of answers", remedy=remedy)
    try:
        content = file.read_bytes()
    except OSError as problem:
        must = "must be a file that can be read"
        raise InputError(f"results: {file}", value=problem.strerror, must=must, remedy=remedy) from None
    try:
        whole = parse_json(content, file.name)
    except InputError:
        return [line for line in content.splitlines() if line.strip()]
    if isinstance(whole, list):
        remedy = "Write each answer on a line of its own, without brackets and commas around it."
        raise InputError(
            f"results: {file}", value="a list", must="must have one answer a line", remedy=remedy
        )
    return [content]
