"""A counterexample as a JSON record: read, checked against its schema, and written whole."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Any

from convexperc.errors import FileFormatError
from verification.counterexamples.fields import ID, KINDS, SCHEMA, WITHOUT_PROBLEM, RecordData, fits, names
from verification.exact.problem import NUMBER, ExactProblem
from verification.ledger.claims import PARTS


@dataclass(frozen=True)
class Size:
    """How small a counterexample is.

    Attributes
    ----------
    text : str
        What was searched, or why it is smallest.
    number : int
        For ordering: 1000 (n + d), plus the sizes of all numbers of the problem added up.
    """

    text: str
    number: int


@dataclass(frozen=True)
class Record:
    """One counterexample.

    Attributes
    ----------
    id : str
        Lower-case letters, digits and hyphens; also the name of its file.
    part : str
        A key of `verification.ledger.claims.PARTS`.
    kind : str
        A key of `verification.counterexamples.fields.KINDS`: what confirms it.
    statement : str
        What fails, in one line.
    problem : ExactProblem or None
        None where the kind needs none.
    fields : mapping
        What the kind needs more; numbers as strings p/q.
    expect : mapping
        What confirming it must find, as it was found first.
    origin : str
        "catalogue", or the search that found it.
    size : Size
    """

    id: str
    part: str
    kind: str
    statement: str
    problem: ExactProblem | None
    fields: Mapping[str, Any]
    origin: str
    size: Size
    expect: Mapping[str, Any] = field(default_factory=dict)

    @property
    def claim(self) -> str:
        """The id of the claim."""
        return PARTS[self.part].claim

    def expecting(self, found: Mapping[str, Any]) -> "Record":
        """The same record with what was found."""
        return replace(self, expect=dict(found))

    def as_json(self) -> dict[str, Any]:
        """Plain data in a stable order."""
        return {
            "schema": SCHEMA,
            "id": self.id,
            "claim": self.claim,
            "part": self.part,
            "kind": self.kind,
            "statement": self.statement,
            "problem": None if self.problem is None else self.problem.as_json(),
            "fields": {name: self.fields[name] for name in names(self.kind) if name in self.fields},
            "expect": dict(self.expect),
            "origin": self.origin,
            "size": {"text": self.size.text, "number": self.size.number},
        }


def magnitude(problem: ExactProblem) -> int:
    """1000 (n + d) plus the sizes of all numbers, |p| + q - 1 for p/q."""
    total = sum(abs(x.numerator) + x.denominator - 1 for x in problem.numbers)
    return 1000 * (problem.n + problem.d) + total


def parse(data: Any, source: str) -> Record:
    """Read a record from JSON data.

    Raises
    ------
    FileFormatError
        It does not follow the schema; the message names the place.
    """
    keys = RecordData.__annotations__
    if not isinstance(data, dict) or set(data) != set(keys):
        got = sorted(data) if isinstance(data, dict) else data
        raise FileFormatError(source, value=got, must=f"must be an object with keys {', '.join(keys)}")
    _check_heading(data, source)
    for name in ("fields", "expect"):
        if not isinstance(data[name], dict):
            raise FileFormatError(f"{source}: {name}", value=data[name], must="must be an object")
    if not fits(data["kind"], set(data["fields"])):
        must = f"must have {', '.join(names(data['kind']))} in kind {data['kind']}, as the schema says"
        raise FileFormatError(f"{source}: fields", value=sorted(data["fields"]), must=must)
    try:
        problem = None if data["problem"] is None else ExactProblem.from_json(data["problem"])
        size = Size(str(data["size"]["text"]), int(data["size"]["number"]))
    except (KeyError, TypeError, ValueError, ZeroDivisionError) as fault:
        if isinstance(fault, FileFormatError):
            raise
        must = f"must have problem and size as the schema says ({type(fault).__name__}: {fault})"
        raise FileFormatError(source, value=data["problem"], must=must) from None
    if problem is None and data["kind"] not in WITHOUT_PROBLEM:
        must = f"may be null in kinds {', '.join(WITHOUT_PROBLEM)} alone"
        raise FileFormatError(f"{source}: problem", value=data["problem"], must=must)
    named = {name: data[name] for name in ("id", "part", "kind", "statement", "fields", "expect", "origin")}
    return Record(problem=problem, size=size, **named)


def _check_heading(data: dict[str, Any], source: str) -> None:
    if data["schema"] != SCHEMA:
        raise FileFormatError(f"{source}: schema", value=data["schema"], must=f"must be {SCHEMA!r}")
    for name in ("id", "claim", "part", "kind", "statement", "origin"):
        if not isinstance(data[name], str):
            raise FileFormatError(f"{source}: {name}", value=data[name], must="must be a string")
    if not re.fullmatch(ID, data["id"]):
        must = "must be words of a-z and 0-9 joined by hyphens"
        raise FileFormatError(f"{source}: id", value=data["id"], must=must)
    if data["kind"] not in KINDS:
        must = f"must be one of {', '.join(KINDS)}"
        raise FileFormatError(f"{source}: kind", value=data["kind"], must=must)
    if data["part"] not in PARTS:
        raise FileFormatError(f"{source}: part", value=data["part"], must="must be a part of the ledger")
    if PARTS[data["part"]].claim != data["claim"]:
        must = f"must be {PARTS[data['part']].claim!r}, the claim of {data['part']}"
        raise FileFormatError(f"{source}: claim", value=data["claim"], must=must)


def numbers_of(record: Record, values: Any, name: str) -> tuple[Fraction, ...]:
    """Return strings p/q as Fractions.

    Raises
    ------
    FileFormatError
        One of them is no string p/q, or they are no list.
    """
    if not isinstance(values, list):
        raise FileFormatError(f"{record.id}: {name}", value=values, must="must be a list of strings p/q")
    for value in values:
        if not isinstance(value, str) or not NUMBER.fullmatch(value):
            raise FileFormatError(f"{record.id}: {name}", value=value, must="must be a string p/q")
    return tuple(Fraction(value) for value in values)
