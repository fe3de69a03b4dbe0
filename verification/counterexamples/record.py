"""A counterexample as a JSON record: read, checked against its schema, and written whole."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Any

from convexperc.errors import FileFormatError
from verification.exact.problem import NUMBER, ExactProblem
from verification.ledger.claims import PARTS

SCHEMA = "convexperc/counterexample/1"
KINDS: dict[str, tuple[str, ...]] = {
    "rise": ("reading", "order", "eps", "start", "iterations"),
    "wrong_limit": ("reading", "order", "eps", "start", "iterations", "period", "box", "limit"),
    "locked": ("reading", "order", "eps", "start", "iterations", "zero", "best", "better"),
    "singular": ("system", "reading", "order", "eps", "start", "iterations"),
    "inequality": ("relation", "v", "t", "w", "u"),
    "derivative": ("variable", "w", "u", "h"),
    "similarity": ("optima",),
    "tie": ("templates",),
    "exponent": ("step", "sizes", "claimed"),
    "case": ("check", "drawn", "largest"),
}
"""The fields of each kind, besides those of every record."""

OPTIONAL = ("eps", "period", "box", "limit", "v", "t", "w", "u")
"""Fields that not every record of a kind has."""

WITHOUT_PROBLEM = ("exponent", "inequality")
"""Kinds whose problem may be null; an inequality between vectors has none."""

ID = re.compile(r"[a-z0-9]+(-[a-z0-9]+)*")
_KEYS = (
    "schema",
    "id",
    "claim",
    "part",
    "kind",
    "statement",
    "problem",
    "fields",
    "expect",
    "origin",
    "size",
)


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
        A key of `KINDS`: what confirms it.
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
            "fields": {name: self.fields[name] for name in KINDS[self.kind] if name in self.fields},
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
    if not isinstance(data, dict) or tuple(sorted(data)) != tuple(sorted(_KEYS)):
        got = sorted(data) if isinstance(data, dict) else data
        raise FileFormatError(source, value=got, must=f"must be an object with keys {', '.join(_KEYS)}")
    _check_heading(data, source)
    for name in ("fields", "expect"):
        if not isinstance(data[name], dict):
            raise FileFormatError(f"{source}: {name}", value=data[name], must="must be an object")
    known, given = KINDS[data["kind"]], data["fields"]
    if set(given) - set(known) or any(name not in given for name in known if name not in OPTIONAL):
        must = f"must have {', '.join(known)} in kind {data['kind']} ({', '.join(OPTIONAL)} where they apply)"
        raise FileFormatError(f"{source}: fields", value=sorted(given), must=must)
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
    if not ID.fullmatch(data["id"]):
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
