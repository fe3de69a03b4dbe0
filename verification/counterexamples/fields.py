"""The shape of a record's file: the fields of every record, and those of each kind.

The schema, the reader and the order of the fields in a file follow from these classes.
"""

from typing import Annotated, Any, Literal, NotRequired, TypedDict

from verification.ledger.claims import ORDERS, READINGS

SCHEMA = "convexperc/counterexample/1"
ID = "[a-z0-9]+(-[a-z0-9]+)*"

Number = Annotated[str, {"pattern": "^-?[0-9]+(/[1-9][0-9]*)?$"}]
Nonnegative = Annotated[str, {"pattern": "^[0-9]+(/[1-9][0-9]*)?$"}]
Words = Annotated[str, {"minLength": 1}]
Whole = Annotated[int, {"minimum": 0}]
Positive = Annotated[int, {"minimum": 1}]
Vector = Annotated[list[Number], {"minItems": 1}]
Intervals = Annotated[list[tuple[Number, Number]], {"minItems": 1}]


class ProblemData(TypedDict):
    """The data of Eq. (full); `modalities` are numbers of columns."""

    X: Annotated[list[Vector], {"minItems": 1}]
    o: Vector
    modalities: Annotated[list[Positive], {"minItems": 1}]
    lambda1: Nonnegative
    lambda2: Nonnegative
    lambda3: Nonnegative


class SizeData(TypedDict):
    """How small it is."""

    text: Words
    number: Whole


class RecordData(TypedDict):
    """One counterexample to a claim, in exact numbers."""

    schema: Annotated[str, {"const": SCHEMA}]
    id: Annotated[str, {"pattern": f"^{ID}$"}]
    claim: Words
    part: Annotated[str, {"pattern": "^[A-Z][0-9]+[a-z]?(/[a-z0-9_]+)+$"}]
    kind: str
    statement: Words
    problem: ProblemData | None
    fields: dict[str, Any]
    expect: dict[str, Any]
    origin: Words
    size: SizeData


class Point(TypedDict):
    """A point (w, u)."""

    w: Vector
    u: Vector


class Box(TypedDict):
    """Intervals that hold w and u."""

    w: Intervals
    u: Intervals


class Rise(TypedDict):
    """F rises at iteration `iterations` of this update."""

    reading: Annotated[str, {"enum": list(READINGS)}]
    order: Annotated[str, {"enum": list(ORDERS)}]
    eps: Number
    start: Literal["paper"] | Point
    iterations: Whole


class Cycle(Rise):
    """The iterates repeat after `period` iterations."""

    period: Positive


class Trap(Rise):
    """The iterates stay in a box, where `limit` is a fixed point if it is given."""

    box: Box
    limit: NotRequired[Point]


class Locked(Rise):
    """Entries `zero` of (w, u) stay 0; `best` is the best point with these zeros, `better` has a lower F."""

    zero: Annotated[list[Whole], {"minItems": 1}]
    best: Point
    better: Point


class _System(TypedDict):
    system: Literal["w", "u"]


class Singular(_System, Rise):
    """The system for w or u has no unique solution after these iterations."""


class Analogue(TypedDict):
    """Vectors for the l1 analogue of Lemma 1."""

    relation: Literal["l1-analogue"]
    v: Vector
    t: Vector


class Substitution(TypedDict):
    """Vectors for the substitution of the appendix."""

    relation: Literal["substitution"]
    v: Vector
    w: Vector


class AppendixObjective(TypedDict):
    """A point for the objective of the appendix."""

    relation: Literal["appendix-objective"]
    w: Vector
    u: Vector


class Variable(TypedDict):
    """An entry of w or u."""

    name: Literal["w", "u"]
    index: Whole


class Derivative(TypedDict):
    """A point, an entry, and the step of the difference quotient."""

    variable: Variable
    w: Vector
    u: Vector
    h: Number


class Optimum(TypedDict):
    """An optimum for this lambda3."""

    lambda3: Number
    w: Vector
    u: Vector


class Similarity(TypedDict):
    """Optima for several lambda3."""

    optima: Annotated[list[Optimum], {"minItems": 2}]


class Template(TypedDict):
    """A template with its optimum."""

    o: Vector
    w: Vector
    u: Vector


class Tie(TypedDict):
    """Templates with equal optima."""

    templates: Annotated[list[Template], {"minItems": 2}]


class Exponent(TypedDict):
    """Sizes at which the operations of a step are counted, and the exponent that is claimed."""

    step: Literal["6", "7"]
    sizes: Annotated[list[Positive], {"minItems": 2}]
    claimed: Whole


class Case(TypedDict):
    """A check, what it drew, and the largest sizes of its source."""

    check: Words
    drawn: list[Any]
    largest: tuple[Positive, Positive]


KINDS: dict[str, tuple[Any, ...]] = {
    "rise": (Rise,),
    "wrong_limit": (Cycle, Trap),
    "locked": (Locked,),
    "singular": (Singular,),
    "inequality": (Analogue, Substitution, AppendixObjective),
    "derivative": (Derivative,),
    "similarity": (Similarity,),
    "tie": (Tie,),
    "exponent": (Exponent,),
    "case": (Case,),
}
"""By kind: the alternatives for `fields`."""

WITHOUT_PROBLEM = ("exponent", "inequality")
"""Kinds whose problem may be null; an inequality between vectors has none."""


def names(kind: str) -> list[str]:
    """All fields of a kind, in the order in which they are written."""
    return list(dict.fromkeys(name for shape in KINDS[kind] for name in shape.__annotations__))


def fits(kind: str, given: set[str]) -> bool:
    """Whether these are the fields of one of the alternatives."""
    return any(shape.__required_keys__ <= given <= set(shape.__annotations__) for shape in KINDS[kind])
