"""JSON Schemas, made from the types: `write` makes the committed files anew.

python -c "from verification.report.schema import write; write()"
"""

import types
from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass
from enum import Enum
from pathlib import Path
from typing import (
    Annotated,
    Any,
    Literal,
    NotRequired,
    Union,
    get_args,
    get_origin,
    get_type_hints,
    is_typeddict,
)

from convexperc.files import json_bytes, write_atomic
from verification.counterexamples.fields import KINDS, WITHOUT_PROBLEM, RecordData
from verification.experiments.record.contents import ExperimentsData
from verification.report.contents import Report

DIALECT = "https://json-schema.org/draft/2020-12/schema"
NUMBER = {"anyOf": [{"type": "number"}, {"enum": ["inf", "-inf", "nan"]}]}
"""A float, as `verification.report.plain.plain` writes it."""
SIMPLE: dict[Any, dict[str, Any]] = {
    str: {"type": "string"},
    int: {"type": "integer"},
    float: NUMBER,
    bool: {"type": "boolean"},
    type(None): {"type": "null"},
    Any: {},
}
HERE = Path(__file__).parents[1]


def json_schema(kind: type, identity: str, title: str) -> dict[str, Any]:
    """Describe the JSON data of a class.

    Parameters
    ----------
    kind : type
        A dataclass or a TypedDict whose fields are such classes, str, int, float, bool, None, Any, an Enum,
        Literal, tuple, list, dict, a union of these, or ``Annotated`` with a dict of further keywords.
    identity, title : str
        $id and title of the schema.

    Returns
    -------
    dict
        JSON Schema 2020-12, without additional properties.

    Raises
    ------
    TypeError
        A field has another type.
    """
    definitions: dict[str, Any] = {}
    _schema(kind, definitions)
    own = definitions.pop(kind.__name__)
    return {"$schema": DIALECT, "$id": identity, "title": title, **own, "$defs": definitions}


def report_schema() -> dict[str, Any]:
    """Of report.json."""
    return json_schema(Report, "urn:convexperc:report:3", "A verification report, machine readable")


def counterexample_schema() -> dict[str, Any]:
    """Of a counterexample: what its fields are, and whether it has a problem, follows from its kind."""
    found = json_schema(
        RecordData, "convexperc/counterexample/1", "A counterexample to a claim, in exact numbers"
    )
    found["properties"]["kind"] = {"enum": list(KINDS)}
    found["allOf"] = [_of_kind(kind, found["$defs"]) for kind in KINDS]
    return found


def experiments_schema() -> dict[str, Any]:
    """Of experiments.json."""
    title = "What `python -m verification experiments` writes"
    return json_schema(ExperimentsData, "urn:convexperc:experiments:1", title)


COMMITTED: dict[Path, Callable[[], dict[str, Any]]] = {
    HERE / "report" / "report.schema.json": report_schema,
    HERE / "counterexamples" / "counterexample.schema.json": counterexample_schema,
    HERE / "experiments" / "record" / "record.schema.json": experiments_schema,
}


def write() -> None:
    """Write the committed schemas anew."""
    for path, make in COMMITTED.items():
        write_atomic(path, json_bytes(make()))


def _of_kind(kind: str, definitions: dict[str, Any]) -> dict[str, Any]:
    shapes = [_schema(shape, definitions) for shape in KINDS[kind]]
    then: dict[str, Any] = {"fields": shapes[0] if len(shapes) == 1 else {"oneOf": shapes}}
    if kind not in WITHOUT_PROBLEM:
        then["problem"] = {"type": "object"}
    return {"if": {"properties": {"kind": {"const": kind}}}, "then": {"properties": then}}


def _schema(kind: Any, definitions: dict[str, Any]) -> dict[str, Any]:
    """The schema of a type; classes with fields go to the definitions and are referred to."""
    if (origin := get_origin(kind)) is not None:
        return _generic(origin, get_args(kind), definitions)
    if kind in SIMPLE:
        return dict(SIMPLE[kind])
    if is_dataclass(kind) or is_typeddict(kind):
        name = kind.__name__
        if name not in definitions:
            definitions[name] = {}  # it may contain itself
            definitions[name] |= _object(kind, definitions)
        return {"$ref": f"#/$defs/{name}"}
    if issubclass(kind, Enum):
        return {"enum": [member.value for member in kind]}
    raise TypeError(f"no JSON Schema for {kind}")


def _generic(origin: Any, args: tuple[Any, ...], definitions: dict[str, Any]) -> dict[str, Any]:
    if origin is Annotated:
        further: dict[str, Any] = args[1]
        return _schema(args[0], definitions) | further
    if origin in (Union, types.UnionType):
        return {"anyOf": [_schema(each, definitions) for each in args]}
    if origin is Literal:
        return {"enum": list(args)}
    if origin is list or (origin is tuple and args[1:] == (...,)):
        return {"type": "array", "items": _schema(args[0], definitions)}
    if origin is tuple:
        items = [_schema(each, definitions) for each in args]
        return {"type": "array", "prefixItems": items, "minItems": len(items), "maxItems": len(items)}
    if origin is dict:
        names = {} if args[0] is str else {"propertyNames": _schema(args[0], definitions)}
        return {"type": "object", **names, "additionalProperties": _schema(args[1], definitions)}
    raise TypeError(f"no JSON Schema for {origin} of {args}")


def _object(kind: Any, definitions: dict[str, Any]) -> dict[str, Any]:
    members = list(_members(kind))
    return {
        "type": "object",
        "properties": {name: _schema(each, definitions) for name, each, _ in members},
        "required": [name for name, _, required in members if required],
        "additionalProperties": False,
    }


def _members(kind: Any) -> Iterator[tuple[str, Any, bool]]:
    """Name and type of each field, and whether it must be there."""
    hints = get_type_hints(kind, include_extras=True)
    for name in [each.name for each in fields(kind)] if is_dataclass(kind) else hints:
        hint = hints[name]
        optional = get_origin(hint) is NotRequired
        yield name, get_args(hint)[0] if optional else hint, not optional
