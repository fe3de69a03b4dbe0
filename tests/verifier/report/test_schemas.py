"""The JSON Schemas are those of the types, and each kind of type has its own."""

import json
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any, Literal, NotRequired, TypedDict

import jsonschema
import pytest

from verification.report.schema import COMMITTED, json_schema


class Color(StrEnum):
    """For the test."""

    RED = "red"
    BLUE = "blue"


class Place(TypedDict):
    """For the test."""

    name: str
    floor: NotRequired[int]


@dataclass(frozen=True)
class Inner:
    """For the test."""

    color: Color
    size: float = 0.0


@dataclass(frozen=True)
class Outer(Inner):
    """For the test; inherited fields are fields."""

    done: bool = False
    count: Annotated[int, {"minimum": 1}] = 1
    mode: Literal["a", 2] = "a"
    inner: Inner | None = None
    pair: tuple[int, str] = (1, "")
    many: tuple[Inner, ...] = ()
    names: tuple[str, ...] | list[int] = ()
    by_color: dict[Color, int] | None = None
    place: Place | None = None
    anything: Any = None


GOOD: dict[str, Any] = {
    "color": "red",
    "size": 1,
    "done": True,
    "count": 1,
    "mode": 2,
    "inner": {"color": "blue", "size": "inf"},
    "pair": [1, "x"],
    "many": [{"color": "red", "size": 0.5}],
    "names": ["x"],
    "by_color": {"red": 3},
    "place": {"name": "here"},
    "anything": [{}],
}
WRONG: dict[str, list[Any]] = {
    "color": ["green", None],
    "size": ["1", None, "infinite"],
    "done": [1, "true"],
    "count": [0, 1.5, True],
    "mode": ["b", 1],
    "inner": [{"color": "red"}, {"color": "red", "size": 1, "extra": 1}, 3],
    "pair": [[1], [1, "x", 2], ["x", 1]],
    "many": [[{"color": "red", "size": True}], {}],
    "names": [["x", 1], "x"],
    "by_color": [{"green": 1}, {"red": "1"}],
    "place": [{}, {"name": "here", "floor": "one"}, {"name": "here", "door": 1}],
}


@pytest.fixture(scope="module")
def validator() -> jsonschema.Draft202012Validator:
    made = json_schema(Outer, "urn:test", "For the test")
    jsonschema.Draft202012Validator.check_schema(made)
    return jsonschema.Draft202012Validator(made)


def test_what_a_type_allows_is_valid(validator: jsonschema.Draft202012Validator) -> None:
    validator.validate(GOOD)
    validator.validate(GOOD | {"inner": None, "names": [1], "place": {"name": "here", "floor": 2}})


@pytest.mark.parametrize("name", GOOD)
def test_what_a_type_does_not_allow_is_refused(validator: jsonschema.Draft202012Validator, name: str) -> None:
    for value in WRONG.get(name, []):
        assert not validator.is_valid(GOOD | {name: value}), value
    assert not validator.is_valid({key: value for key, value in GOOD.items() if key != name})
    assert not validator.is_valid(GOOD | {"extra": 1})


def test_a_type_without_a_schema_is_refused() -> None:
    @dataclass
    class Odd:
        value: complex

    with pytest.raises(TypeError, match="complex"):
        json_schema(Odd, "urn:test", "For the test")


@pytest.mark.parametrize("path", COMMITTED, ids=lambda path: path.name)
def test_the_committed_schema_is_that_of_the_types(path: Path) -> None:
    made = COMMITTED[path]()
    jsonschema.Draft202012Validator.check_schema(made)
    remedy = 'python -c "from verification.report.schema import write; write()"'
    assert json.loads(path.read_text(encoding="utf-8")) == made, remedy
