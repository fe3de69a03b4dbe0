"""Malformed requests: lines with one fault each, the same at every run."""

import json
import math
from collections.abc import Callable, Iterator
from typing import Any

from convexperc.errors import FileFormatError
from convexperc.files import NoFloat, parse_json
from verification.conformance.request import LAMBDAS

GOOD = {
    "n": 2,
    "d": 3,
    "modalities": [2, 1],
    "X": [[1.0, 0.5, -0.25], [0.25, 1.0, 0.75]],
    "o": [1.0, 0.75, 0.5],
    "lambda1": 0.5,
    "lambda2": 0.125,
    "lambda3": 0.25,
}
"""A request without fault, before it gets one; its id comes first."""


def malformed_requests() -> Iterator[dict[str, str]]:
    """Each line has one fault."""
    faults = [*_broken_text(), *_broken_values()]
    for k, (fault, comment, write) in enumerate(faults):
        name = f"malformed-{k:02}"
        yield {"id": name, "line": write(name), "fault": fault, "comment": comment}


Fault = tuple[str, str, Callable[[str], str]]


def _request(name: str, **changes: Any) -> dict[str, Any]:
    return {"id": name} | GOOD | changes


def _broken_text() -> Iterator[Fault]:
    """Lines that are no JSON object."""
    whole = json.dumps
    yield "syntax", "an open brace", lambda name: "{"
    yield "syntax", "plain text", lambda name: "solve this problem"
    yield "syntax", "a list", lambda name: whole([name, 1, 2])
    yield "syntax", "null", lambda name: "null"
    yield "syntax", "a number", lambda name: "17"
    yield "syntax", "a request that is cut off", lambda name: whole(_request(name))[:-20]
    yield "syntax", "a request with text behind it", lambda name: whole(_request(name)) + " end"
    yield "syntax", "a comma too many", lambda name: whole(_request(name))[:-1] + ",}"
    yield "syntax", "keys in single quotes", lambda name: whole(_request(name)).replace('"', "'")
    yield "syntax", "lambda2 twice", lambda name: whole(_request(name))[:-1] + ', "lambda2": 4.0}'
    for token in ("NaN", "Infinity", "1e999"):
        yield (
            "not finite",
            f"{token} in X",
            lambda name, token=token: whole(_request(name)).replace("-0.25", token),  # type: ignore[misc]
        )


def _broken_values() -> Iterator[Fault]:
    """JSON objects that are no request."""
    for key in ("X", "o", "modalities", *LAMBDAS):
        yield "missing", f"no {key}", _without(key)
    changes: tuple[tuple[str, str, dict[str, Any]], ...] = (
        ("type", "X is a string", {"X": "1 0.5 -0.25"}),
        ("type", "X is a number", {"X": 1.0}),
        ("type", "X is a single row", {"X": [1.0, 0.5, -0.25]}),
        ("type", "an entry of X is null", {"X": [[1.0, None, -0.25], [0.25, 1.0, 0.75]]}),
        (
            "type",
            "an entry of X is a string that is no number",
            {"X": [[1.0, "half", -0.25], [0.25, 1.0, 0.75]]},
        ),
        ("type", "o is null", {"o": None}),
        ("type", "lambda1 is null", {"lambda1": None}),
        ("type", "lambda2 is a string that is no number", {"lambda2": "small"}),
        ("type", "lambda3 is a list", {"lambda3": [0.25]}),
        ("shape", "o is too short", {"o": [1.0, 0.75]}),
        ("shape", "o is too long", {"o": [1.0, 0.75, 0.5, 0.25]}),
        ("shape", "rows of different lengths", {"X": [[1.0, 0.5, -0.25], [0.25, 1.0]]}),
        ("shape", "X has no rows", {"n": 0, "X": []}),
        ("shape", "X has no columns", {"d": 0, "X": [[], []], "o": [], "modalities": []}),
        ("size", "n is not the number of rows", {"n": 3}),
        ("size", "d is not the number of columns", {"d": 4}),
        ("modalities", "sizes that add up to less than d", {"modalities": [1, 1]}),
        ("modalities", "sizes that add up to more than d", {"modalities": [2, 2]}),
        ("modalities", "a size of 0", {"modalities": [3, 0]}),
        ("modalities", "a negative size", {"modalities": [4, -1]}),
        ("modalities", "no modality", {"modalities": []}),
        ("modalities", "a size that is no whole number", {"modalities": [1.5, 1.5]}),
        ("not finite", "o has NaN", {"o": [1.0, math.nan, 0.5]}),
        ("not finite", "o has -Infinity", {"o": [1.0, 0.75, -math.inf]}),
        ("not finite", "lambda1 is Infinity", {"lambda1": math.inf}),
        ("not finite", "lambda2 is NaN", {"lambda2": math.nan}),
        ("negative", "lambda1 is negative", {"lambda1": -0.5}),
        ("negative", "lambda2 is negative", {"lambda2": -0.125}),
        ("negative", "lambda3 is negative", {"lambda3": -0.25}),
    )
    for fault, comment, change in changes:
        yield fault, comment, _changed(change)


def _without(key: str) -> Callable[[str], str]:
    return lambda name: json.dumps({k: value for k, value in _request(name).items() if k != key})


def _changed(change: dict[str, Any]) -> Callable[[str], str]:
    return lambda name: json.dumps(_request(name, **change))


def fault_of(line: str) -> str | None:
    """What is wrong with a request, as a key of `vectors.FAULTS`; None where nothing is."""
    try:
        data = parse_json(line, "request")
    except FileFormatError:
        return "syntax"
    if not isinstance(data, dict):
        return "syntax"
    if not {"id", *GOOD} <= set(data):
        return "missing"
    return next(_faults(data), None)


def _faults(data: dict[str, Any]) -> Iterator[str]:
    X, o, sizes = data["X"], data["o"], data["modalities"]
    lists = all(isinstance(each, list) for each in (X, o, sizes)) and all(isinstance(row, list) for row in X)
    rows = X if lists else []
    numbers = [*(x for row in rows for x in row), *(o if lists else []), *(data[name] for name in LAMBDAS)]
    if any(isinstance(x, NoFloat) for x in numbers):
        yield "not finite"
    if not lists or any(type(x) not in {int, float} for x in numbers):
        yield "type"
    elif {len(row) for row in rows} != {len(o)} or not o:
        yield "shape"
    elif (data["n"], data["d"]) != (len(rows), len(o)):
        yield "size"
    elif not all(type(size) is int and size > 0 for size in sizes) or sum(sizes) != len(o):
        yield "modalities"
    elif min(data[name] for name in LAMBDAS) < 0:
        yield "negative"
