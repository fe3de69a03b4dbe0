"""Problem and answer files: read strictly, written exactly."""

import math
import os
import re
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from convexperc.errors import FileFormatError, InputError, check_type
from convexperc.files import placed, read_json
from convexperc.problem.arrays import Vector
from convexperc.problem.conversion import MUST_BE_EXACT, ROUND, exact_float, exact_hex
from convexperc.problem.modalities import Modalities
from convexperc.problem.problem import Problem

MUST_BE_NUMBER = (
    "must be a finite number: a JSON number that float64 does not turn into 0 or infinity, or a C99 hex float"
    " in a string"
)
LAMBDAS = ("lambda1", "lambda2", "lambda3")
_HEX = re.compile(r"[+-]?0[xX](?:[0-9a-fA-F]+\.?[0-9a-fA-F]*|\.[0-9a-fA-F]+)(?:[pP][+-]?[0-9]{1,7})?")


@dataclass(frozen=True, eq=False)
class ProblemFile:
    """A problem as its file gives it.

    Attributes
    ----------
    id : str or None
        What the file calls it.
    problem : Problem
    """

    id: str | None
    problem: Problem


@dataclass(frozen=True, eq=False)
class AnswerFile:
    """An answer from anywhere to a problem; what the file claims of it is not kept.

    Attributes
    ----------
    id : str or None
        The id of the problem that it answers.
    w : float64 (n,), read-only
    u : float64 (d,), read-only
    """

    id: str | None
    w: Vector
    u: NDArray[np.float64]


def read_problem(path: str | os.PathLike[str]) -> ProblemFile:
    """Read a problem file.

    A JSON object with ``X`` (n rows of d numbers), ``o``, ``lambda1``, ``lambda2``, ``lambda3``; ``id``,
    ``n``, ``d`` and ``modalities`` (see `Modalities.of`; one modality without) may be left out. A number is
    a JSON number or a C99 hex float in a string; a decimal number stands for the nearest float64, an integer
    and a hex float for themselves.

    Raises
    ------
    FileFormatError
        Not readable, not JSON, a key that is unknown, missing or given twice, a number that is not finite, or
        that float64 would turn into 0, an integer or a hex float that it would round, rows of different
        lengths, an `n` or `d` that X does not have, or data that `Problem` refuses.
    """
    file, record = _object(path, ("X", "o", *LAMBDAS), ("id", "n", "d", "modalities"))
    rows = _list(record["X"] or None, f"{file}: X", "must be a list of at least one row")
    X = [_numbers(row, f"{file}: X[{i}]") for i, row in enumerate(rows)]
    for i, row in enumerate(X):
        if len(row) != len(X[0]):
            must = f"must have the {len(X[0])} entries that X[0] has"
            raise FileFormatError(f"{file}: X[{i}]", value=len(row), must=must)
    for key, size in (("n", len(X)), ("d", len(X[0]) if X else 0)):
        if key in record and (record[key] != size or type(record[key]) is not int):
            raise FileFormatError(f"{file}: {key}", value=record[key], must=f"must be {size}, as X has it")
    if "modalities" in record and record["modalities"] is None:
        raise FileFormatError(f"{file}: modalities", value=None, must="must be sizes or columns, or left out")
    o = _numbers(record["o"], f"{file}: o")
    lambda1, lambda2, lambda3 = (_number(record[name], f"{file}: {name}") for name in LAMBDAS)
    try:
        problem = Problem(
            X, o, modalities=record.get("modalities"), lambda1=lambda1, lambda2=lambda2, lambda3=lambda3
        )
    except InputError as error:
        raise placed(file, error) from None
    return ProblemFile(_id(record, file), problem)


def read_answer(path: str | os.PathLike[str], asked: ProblemFile) -> AnswerFile:
    """Read an answer to `asked`: a JSON object with ``w`` and ``u``.

    ``id``, ``objective`` and ``status`` may be there; the last two are claims and are not looked at.

    Raises
    ------
    FileFormatError
        As for `read_problem`; also another id than the problem's, or a w or u of another length.
    """
    check_type(asked, ProblemFile, "asked", FileFormatError)
    file, record = _object(path, ("w", "u"), ("id", "objective", "status"))
    given = _id(record, file)
    if given is not None and asked.id is not None and given != asked.id:
        raise FileFormatError(f"{file}: id", value=given, must=f"must be the problem's id {asked.id!r}")
    point = {}
    for key, length in (("w", asked.problem.n), ("u", asked.problem.d)):
        point[key] = np.array(_numbers(record[key], f"{file}: {key}"), dtype=np.float64)
        if point[key].size != length:
            must = f"must have {length} entries to fit the problem"
            raise FileFormatError(f"{file}: {key}", value=point[key].size, must=must)
        point[key].flags.writeable = False
    return AnswerFile(given, point["w"], point["u"])


def _object(
    path: str | os.PathLike[str], needed: tuple[str, ...], optional: tuple[str, ...]
) -> tuple[str, dict[str, Any]]:
    """Load a JSON object that has all the needed keys and no unknown ones."""
    file, record = read_json(path)
    if not isinstance(record, dict):
        raise FileFormatError(file, value=record, must="must hold a JSON object")
    unknown = [key for key in record if key not in (*needed, *optional)]
    if unknown:
        must = f"must not have keys other than {', '.join((*needed, *optional))}"
        raise FileFormatError(file, value=unknown, must=must, remedy="Remove or rename them.")
    missing = [key for key in needed if key not in record]
    if missing:
        raise FileFormatError(file, value=list(record), must=f"must have the keys {', '.join(missing)}")
    return file, record


def _id(record: dict[str, Any], file: str) -> str | None:
    if "id" in record and type(record["id"]) is not str:
        raise FileFormatError(f"{file}: id", value=record["id"], must="must be a string")
    return record.get("id")


def _list(value: Any, place: str, must: str) -> list[Any]:
    if not isinstance(value, list):
        raise FileFormatError(place, value=value, must=must)
    return value


def _numbers(value: Any, place: str) -> list[float]:
    entries = _list(value, place, "must be a list of numbers")
    return [_number(entry, f"{place}[{i}]") for i, entry in enumerate(entries)]


def _number(value: Any, place: str) -> float:
    number: float | None = math.nan
    try:
        if type(value) in (int, float):
            number = exact_float(value)
        elif isinstance(value, str) and _HEX.fullmatch(value):
            number = exact_hex(value)
    except OverflowError:
        pass
    if number is None:
        raise FileFormatError(place, value=value, must=MUST_BE_EXACT, remedy=ROUND)
    if not math.isfinite(number):
        raise FileFormatError(place, value=value, must=MUST_BE_NUMBER)
    return number


def problem_record(problem: Problem, name: str | None = None) -> dict[str, Any]:
    """What `read_problem` reads: exact, with hex floats throughout."""
    check_type(problem, Problem, "problem")
    check_type(name, (str, type(None)), "name")
    record: dict[str, Any] = {} if name is None else {"id": name}
    record |= {"n": problem.n, "d": problem.d, "modalities": partition_record(problem.modalities)}
    record |= {"X": [hex_floats(row) for row in problem.X], "o": hex_floats(problem.o)}
    return record | dict(zip(LAMBDAS, hex_floats(problem.lambdas), strict=True))


def partition_record(modalities: Modalities) -> dict[str, int | list[int]]:
    """Sizes where the modalities follow each other, else columns: what `Modalities.of` reads."""
    start = 0
    for columns, size in zip(modalities, modalities.sizes, strict=True):
        if not isinstance(columns, slice) or columns.start != start:
            each = [np.arange(modalities.d)[columns].tolist() for columns in modalities]
            return dict(zip(modalities.names, each, strict=True))
        start += size
    return dict(zip(modalities.names, modalities.sizes, strict=True))


def hex_floats(values: Iterable[float]) -> list[str]:
    """Each number as a C99 hex float: exact."""
    return [float(value).hex() for value in values]
