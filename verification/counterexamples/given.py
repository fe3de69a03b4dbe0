"""What a counterexample is about, in one line: the problem, the point, the update, in exact numbers."""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

from verification.counterexamples.record import Record
from verification.exact.problem import ExactProblem
from verification.ledger.claims import order_in_words

LONGEST = 16
"""Letters of a fraction that is shown as it is, though it be a float64."""
MOST_ENTRIES = 32
"""Entries of X that are shown."""
VECTORS = ("w", "u", "v", "t")


def given(record: Record) -> str:
    """Say what a record is about; its file has every number exactly.

    Parameters
    ----------
    record : Record
    """
    fields = record.fields
    told = [] if record.problem is None else [in_words(record.problem)]
    told += [f"{name} = {_vector(fields[name])}" for name in VECTORS if name in fields]
    told += _update(fields)
    if "templates" in fields:
        told.append("templates " + " and ".join(f"o = {_vector(each['o'])}" for each in fields["templates"]))
    return "; ".join(told)


def in_words(problem: ExactProblem) -> str:
    """X, o, the modalities and the lambdas; the sizes alone where X is large."""
    lambdas = ", ".join(f"lambda{i} = {_number(x)}" for i, x in enumerate(problem.lambdas, 1))
    if problem.n * problem.d > MOST_ENTRIES:
        return f"n = {problem.n}, d = {problem.d}, m = {len(problem.groups)}, {lambdas}"
    rows = "; ".join(" ".join(_number(x) for x in row) for row in problem.X)
    data = f"X = [{rows}], o = [{' '.join(_number(x) for x in problem.o)}]"
    sizes = ", ".join(str(len(group)) for group in problem.groups)
    columns = "" if problem.d == 1 else f"modalities of {sizes} columns, "
    return f"{data}, {columns}{lambdas}"


def _update(fields: Mapping[str, Any]) -> list[str]:
    """The update and where it starts."""
    if "reading" not in fields:
        return []
    order = order_in_words(fields["order"])
    eps = f", eps = {_number(fields['eps'])}" if fields["reading"] == "smoothed" else ""
    start = fields["start"]
    if start == "paper":
        return [f"{fields['reading']} update, {order}{eps}, from the paper's start"]
    point = ", ".join(f"{name} = {_vector(start[name])}" for name in ("w", "u"))
    return [f"{fields['reading']} update, {order}{eps}, from {point}"]


def _vector(values: Sequence[Any]) -> str:
    return f"({', '.join(_number(value) for value in values)})"


def _number(value: Any) -> str:
    """A fraction, or where it is long the decimal that is read as this float64: exact in either case."""
    exact = Fraction(value)
    text = str(exact)
    return text if len(text) <= LONGEST or Fraction(float(exact)) != exact else repr(float(exact))
