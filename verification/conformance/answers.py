"""Answers: one JSON line read strictly, whatever a program under judgement has written."""

import json
import math
import re
from dataclasses import dataclass
from typing import Any

import numpy as np

from convexperc.errors import FileFormatError, escaped
from convexperc.files import NoFloat, parse_json
from convexperc.problem.arrays import Vector
from verification.conformance.request import Request

HEX = re.compile(r"[+-]?0[xX][0-9a-fA-F]+(\.[0-9a-fA-F]*)?([pP][+-]?[0-9]{1,5})?", re.ASCII)
KEYS = frozenset(("id", "w", "u", "objective", "status", "trace"))
REFUSALS = ("error", "unsupported")
SHOWN = 120
"""Most characters of a line that a finding shows."""


class AnswerError(Exception):
    """A line is no answer; the message says why, in words for the solver's author."""


@dataclass(frozen=True, eq=False)
class Answer:
    """What a solver says of one request.

    Attributes
    ----------
    w : float64 (n,)
    u : float64 (d,)
    objective : float or None
        F(w, u), if the solver says so.
    trace : float64 (k,) or None
        F by iteration, if the solver says so.
    """

    w: Vector
    u: Vector
    objective: float | None = None
    trace: Vector | None = None


@dataclass(frozen=True)
class Refusal:
    """A solver gives no answer, and says why.

    Attributes
    ----------
    kind : str
        "error": the request cannot be used, or the solver failed; "unsupported": it is not for this solver.
    text : str
    """

    kind: str
    text: str


def parsed(line: bytes | str) -> dict[str, Any]:
    """Read one line as a JSON object.

    Raises
    ------
    AnswerError
        It is no JSON object in UTF-8, or repeats a key.
    """
    try:
        value = parse_json(line, "line")
    except FileFormatError:
        raise AnswerError(f"not JSON, or a key twice: {shown(line)}") from None
    if not isinstance(value, dict):
        raise AnswerError(f"not a JSON object: {shown(line)}")
    return value


def read_answer(data: dict[str, Any], request: Request) -> Answer | Refusal:
    """Read the answer to `request`, whose id has been compared already.

    Raises
    ------
    AnswerError
        A key is missing or unknown, a number is none or not finite, or a vector has another length.
    """
    refusals = [key for key in REFUSALS if key in data]
    if refusals:
        if set(data) - {"id"} != {refusals[0]}:
            raise AnswerError(
                f"{refusals[0]} stands beside {', '.join(sorted(set(data) - {'id', *refusals[:1]}))}"
            )
        text = data[refusals[0]]
        if not isinstance(text, str) or not text.strip():
            raise AnswerError(f"{refusals[0]} must say why in a string, not {shown(text)}")
        return Refusal(refusals[0], escaped(text))
    if missing := [key for key in ("w", "u") if key not in data]:
        raise AnswerError(f"has no {' and no '.join(missing)}")
    if unknown := sorted(set(data) - KEYS):
        raise AnswerError(f"has unknown keys: {shown(', '.join(unknown))}")
    n, d = request.problem.n, request.problem.d
    objective = None if data.get("objective") is None else number(data["objective"], "objective")
    trace = None if data.get("trace") is None else vector(data["trace"], "trace")
    return Answer(vector(data["w"], "w", n), vector(data["u"], "u", d), objective, trace)


def vector(values: Any, name: str, length: int | None = None) -> Vector:
    """Read a list of finite numbers.

    Raises
    ------
    AnswerError
        It is none, or has another length.
    """
    if not isinstance(values, list):
        raise AnswerError(f"{name} must be a list of numbers, not {shown(values)}")
    if length is not None and len(values) != length:
        raise AnswerError(f"{name} must have {length} numbers, not {len(values)}")
    return np.array([number(value, f"{name}[{k}]") for k, value in enumerate(values)], dtype=np.float64)


def number(value: Any, name: str) -> float:
    """Read a JSON number, or a C99 hex float in a string.

    Raises
    ------
    AnswerError
        It is neither, or not finite in float64.
    """
    try:
        found = float.fromhex(value) if isinstance(value, str) and HEX.fullmatch(value) else _plain(value)
    except OverflowError:
        found = math.inf
    if found is None and not isinstance(value, NoFloat):
        raise AnswerError(f"{name} must be a number, not {shown(value)}")
    if found is None or not math.isfinite(found):
        raise AnswerError(f"{name} must be finite in float64, not {shown(value)}")
    return found


def _plain(value: Any) -> float | None:
    return float(value) if isinstance(value, (int, float)) and not isinstance(value, bool) else None


def shown(value: Any) -> str:
    """A short form of what a program wrote, on one line."""
    if isinstance(value, bytes):
        value = value[: 4 * SHOWN].decode("utf-8", "replace")
    text = value if isinstance(value, str) else json.dumps(value, default=str)[: 4 * SHOWN]
    return escaped(text if len(text) <= SHOWN else f"{text[:SHOWN]} ...")
