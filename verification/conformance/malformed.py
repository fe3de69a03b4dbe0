"""Malformed requests: lines with one fault each, the same at every run."""

import json
import math
from collections.abc import Callable, Iterator
from typing import Any

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
