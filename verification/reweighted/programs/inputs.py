"""Inputs of programs: as arrays, as plain data, and by their digest."""

import hashlib
import json
from collections.abc import Mapping
from fractions import Fraction
from typing import Any

import numpy as np

from convexperc.errors import InputError, check_type
from verification.reweighted.programs.questions import Data

DIGITS = 16
"""Hexadecimal digits of the id of an input or a finding."""


def arrays(data: Data) -> dict[str, Any]:
    """Lists as arrays, of float64 unless all are integers.

    Raises
    ------
    InputError
        It is no mapping, or holds rows of several lengths or masked entries.
    """
    check_type(data, Mapping, "an input")
    found = {}
    for name, value in data.items():
        if np.ma.is_masked(value):
            raise InputError(f"input {name}", value="masked entries", must="must have none")
        try:
            found[name] = np.array(value) if isinstance(value, list | tuple) else value
        except ValueError as fault:
            must = f"must be an array: {fault}"
            raise InputError(f"input {name}", value=value, must=must) from None
    return found


def plain(value: Any) -> Any:
    """JSON; a number that JSON has not as text."""
    if isinstance(value, Mapping):
        return {name: plain(part) for name, part in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if isinstance(value, list | tuple):
        return [plain(part) for part in value]
    if isinstance(value, Fraction) or (isinstance(value, float) and not np.isfinite(value)):
        return str(value)
    return value


def digest(question: str, data: Data) -> str:
    """The id of an input under a question; that of the input alone where the question is empty.

    Raises
    ------
    InputError
        See `line`.
    """
    content = {"question": question, "input": plain(data)}
    text = line(content, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()[:DIGITS]


def listed(data: Data) -> dict[str, Any]:
    """The data with arrays as lists, as a program elsewhere gets them."""
    return {name: np.asarray(value).tolist() for name, value in data.items()}


def line(content: Mapping[str, Any], **options: Any) -> str:
    """One line of JSON, from which float64 numbers are read as they are; NaN and Infinity as in Python.

    Parameters
    ----------
    content : mapping of str to Any
    **options : Any
        Of `json.dumps`.

    Raises
    ------
    InputError
        It holds something that JSON does not have, such as a function.
    """
    try:
        return json.dumps(content, **options)
    except (TypeError, ValueError) as fault:
        must = f"must hold numbers, texts and arrays of these alone, to be written as JSON: {fault}"
        raise InputError("an input", value=dict(content), must=must) from None
