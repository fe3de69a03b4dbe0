"""Questions to a program: other inputs made of one, each with its own objective to judge the answer by.

A question never compares two answers: where the optimum is not unique, both may be right.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from convexperc.errors import InputError, check_type

Data = Mapping[str, Any]
"""Arguments of a program by name: arrays, numbers, texts."""

POWERS = (-9, 9, -6, 6, -3, 3, -8, 8, -7, 7, -5, 5, -4, 4, -2, 2, -1, 1)
"""Powers of ten by which data are multiplied; inputs that are drawn are asked with the first of them."""


@dataclass(frozen=True)
class Question:
    """A way to make another input of an input.

    Attributes
    ----------
    name : str
    variants : tuple
        Numbers of the ways to make it.
    derive : function of data and a variant
        The other input, or None where there is none.
    twice : bool
        Whether the program is called twice with the same arrays, and its second answer judged.
    beside : bool
        Whether a failure counts only where the program is right on the input as given.
    """

    name: str
    variants: tuple[int, ...]
    derive: Callable[[Data, int], Data | None]
    twice: bool = False
    beside: bool = True


def as_given() -> Question:
    """The input as it is."""
    return Question("as given", (0,), lambda data, _: data, beside=False)


def asked_twice() -> Question:
    """The same arrays again: what writes into them, or keeps what it found, may answer otherwise."""
    return Question("ask twice", (0,), lambda data, _: data, twice=True)


def other_units(powers: Mapping[str, int]) -> Question:
    """Data in units from 10**-9 to 10**9.

    Parameters
    ----------
    powers : mapping of str to int
        The data that are measured in the unit, and in which power of it; for a lasso with y in metres,
        ``{"y": 1, "penalty": 1}``.
    """

    def derive(data: Data, k: int) -> Data:
        return {**data, **{name: _times_ten(_named(data, name), k * power) for name, power in powers.items()}}

    return Question("other units", POWERS, derive)


def _named(data: Data, name: str) -> Any:
    """The data of a name.

    Raises
    ------
    InputError
        There are none.
    """
    if name not in data:
        must = f"must be among the data, which have {', '.join(data)}"
        raise InputError("a name in rows, columns, powers or start", value=name, must=must)
    return data[name]


def _array(data: Data, name: str, dimensions: int) -> NDArray[Any]:
    """The data of a name, with so many dimensions or more.

    Raises
    ------
    InputError
        There are none, or they have fewer.
    """
    found = np.asarray(_named(data, name))
    if found.ndim < dimensions:
        must = f"must have {dimensions} dimensions or more to be named in rows, columns or start"
        raise InputError(name, value=found, must=must)
    return found


def _times_ten(values: Any, k: int) -> Any:
    try:
        given = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError("what is named in powers", value=values, must="must be numbers") from None
    found = given * 10.0**k if k >= 0 else given / 10.0**-k
    return found if found.ndim else float(found)


def duplicated(rows: Sequence[str]) -> Question:
    """The first or the last row once more, in all of these arrays."""
    places = (0, -1)
    return _rows("duplicate a row", rows, 2, lambda array, k: np.concatenate([array, array[[places[k]]]]))


def permuted(rows: Sequence[str]) -> Question:
    """The rows of these arrays backwards, or the first one last."""
    changes = (lambda array: array[::-1].copy(), lambda array: np.roll(array, -1, axis=0))
    return _rows("permute rows", rows, 2, lambda array, k: changes[k](array))


def with_zero_row(rows: Sequence[str]) -> Question:
    """A row of zeros more, in all of these arrays."""
    return _rows(
        "add a zero row", rows, 1, lambda array, _: np.concatenate([array, np.zeros_like(array[:1])])
    )


def with_zero_column(columns: Sequence[str]) -> Question:
    """A column of zeros more, in all of these arrays."""

    def add(array: Any, _: int) -> Any:
        return np.concatenate([array, np.zeros_like(array[:, :1])], axis=1)

    return _rows("add a zero column", columns, 1, add, 2)


def _rows(
    name: str, names: Sequence[str], variants: int, change: Callable[[Any, int], Any], dimensions: int = 1
) -> Question:
    def derive(data: Data, k: int) -> Data:
        return {**data, **{each: change(_array(data, each, dimensions), k) for each in names}}

    return Question(name, tuple(range(variants)), derive)


def started_at(start: str, points: str, most: int = 5) -> Question:
    """A start at a row of the data.

    Parameters
    ----------
    start : str
        The argument that takes a start; the objective need not take it.
    points : str
        The data of which a row is a start.
    most : int
        Rows to try.
    """

    def derive(data: Data, k: int) -> Data | None:
        rows = _array(data, points, 1)
        return {**data, start: rows[k].copy()} if k < len(rows) else None

    return Question("start at a data point", tuple(range(most)), derive, beside=False)


def all_questions(
    *,
    rows: Sequence[str] = (),
    columns: Sequence[str] = (),
    powers: Mapping[str, int] | None = None,
    start: tuple[str, str] | None = None,
) -> tuple[Question, ...]:
    """All questions that these names allow.

    Parameters
    ----------
    rows : sequence of str
        Data that have one row for each sample or point.
    columns : sequence of str
        Data that have one column for each variable.
    powers : mapping of str to int
        See `other_units`.
    start : pair of str
        See `started_at`.
    """
    found = [as_given()]
    if powers:
        found.append(other_units(powers))
    if rows:
        found += [duplicated(rows), permuted(rows), with_zero_row(rows)]
    if columns:
        found.append(with_zero_column(columns))
    if start is not None:
        found.append(started_at(*start))
    return (*found, asked_twice())


def checked(questions: Sequence[Question] | None) -> tuple[Question, ...]:
    """The questions; each input as it is, and the same input twice, where there are none given.

    Raises
    ------
    InputError
        They are no sequence, or one is no question.
    """
    if questions is None:
        return all_questions()
    check_type(questions, Sequence, "questions")
    for question in questions:
        check_type(question, Question, "a question")
    return tuple(questions)
