"""Answers: one JSON line read strictly, whatever a program under judgement has written."""

import json
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from pydantic_core import from_json

from convexperc.errors import FileFormatError, escaped
from convexperc.files import NoFloat, parse_json
from convexperc.problem.arrays import Vector
from verification.conformance.request import Request

HEX = re.compile(r"[+-]?0[xX][0-9a-fA-F]+(\.[0-9a-fA-F]*)?([pP][+-]?[0-9]{1,5})?", re.ASCII)
KEYS = frozenset(("id", "w", "u", "objective", "status", "trace"))
REFUSALS = ("error", "unsupported")
FAR, LONG = re.compile("e[-+]?[0-9]{3}"), 200
"""An exponent, and characters of a number, from which on `parse_json` must look whether float64 holds it."""
SHOWN, TOLD = 120, 3
"""Most characters of a line, and most of several faults, that a finding shows."""


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
    ignored : tuple of str
        Keys that an answer need not have, which nobody reads.
    """

    w: Vector
    u: Vector
    objective: float | None = None
    trace: Vector | None = None
    ignored: tuple[str, ...] = ()


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
        value = _undoubted(line) or parse_json(line, "line")
    except FileFormatError:
        raise AnswerError(f"not JSON, or a key twice: {shown(line)}") from None
    if not isinstance(value, dict):
        raise AnswerError(f"not a JSON object: {shown(line)}")
    return value


def _undoubted(line: bytes | str) -> dict[str, Any] | None:
    """Read a flat object of numbers, lists of numbers and texts fast; None where `parse_json` must decide.

    It must, where a number may be beyond float64 or lost in it: only with an exponent of three digits, or if
    it is `LONG`; and where a key may be there twice: each that is lost leaves its quotation marks behind.
    """
    text = line if isinstance(line, str) else line.decode("utf-8", "replace")
    if FAR.search(text.lower()) or max(map(len, text.split(","))) >= LONG:
        return None
    try:
        data = from_json(line, allow_inf_nan=False)
    except (ValueError, TypeError):  # the latter for text with half a surrogate pair
        return None
    if not isinstance(data, dict) or not all(map(_is_flat, data.values())):
        return None
    texts = len(data) + sum(isinstance(value, str) for value in data.values())
    return data if text.count('"') == 2 * texts else None


def _is_flat(value: Any) -> bool:
    kinds = set(map(type, value)) if isinstance(value, list) else {type(value)} - {str, type(None)}
    return kinds <= {float, int}


def read_answer(data: dict[str, Any], request: Request) -> Answer | Refusal:
    """Read the answer to `request`, whose id has been compared already.

    Raises
    ------
    AnswerError
        A key is missing, a number is none or not finite, or a vector has another length.
    """
    data = {key: value for key, value in data.items() if value is not None}
    refusals = [key for key in REFUSALS if key in data]
    if refusals:
        if beside := sorted({"w", "u", "objective", "trace", *refusals[1:]} & set(data)):
            raise AnswerError(f"{refusals[0]} stands beside {', '.join(beside)}")
        text = data[refusals[0]]
        if not isinstance(text, str) or not text.strip():
            raise AnswerError(f"{refusals[0]} must say why in a string, not {shown(text)}")
        return Refusal(refusals[0], escaped(text))
    if missing := [key for key in ("w", "u") if key not in data]:
        raise AnswerError(f"has no {' and no '.join(missing)}")
    n, d = request.problem.n, request.problem.d
    objective = number(data["objective"], "objective") if "objective" in data else None
    trace = vector(data["trace"], "trace") if "trace" in data else None
    ignored = tuple(shown(key) for key in sorted(set(data) - KEYS))
    return Answer(vector(data["w"], "w", n), vector(data["u"], "u", d), objective, trace, ignored)


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
    if set(map(type, values)) <= {float}:  # `number` tells of the others, and of what is not finite
        found = np.array(values, dtype=np.float64)
        if np.isfinite(found).all():
            return found
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


def told(faults: Sequence[str]) -> str:
    """The first faults, how many more there are, and the last."""
    more = len(faults) - TOLD - 1
    return "; ".join(faults if more <= 0 else [*faults[:TOLD], f"and {more} more", faults[-1]])


def shown(value: Any) -> str:
    """A short form of what a program wrote, on one line."""
    if isinstance(value, bytes):
        value = value[: 4 * SHOWN].decode("utf-8", "replace")
    text = value if isinstance(value, str) else json.dumps(value, default=str)[: 4 * SHOWN]
    return escaped(text if len(text) <= SHOWN else f"{text[:SHOWN]} ...")
