"""The vectors: problems, recognition sets and malformed requests, with what is proved of each.

``vectors/problems.json``, ``vectors/recognition.json`` and ``vectors/malformed.json`` come with the package;
``vectors/vectors.schema.json`` says how they are written. `verification.conformance.making` makes them.
"""

import hashlib
import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cache, cached_property
from importlib.resources import files
from typing import Any

import numpy as np

from convexperc.errors import FileFormatError
from convexperc.problem.problem import Problem
from verification.conformance.request import LAMBDAS, Request
from verification.exact.numbers import rationals, squares

SCHEMA = "convexperc/conformance/1"
VERSION = "1.0.0"
"""Of the set of vectors: a change of any of them changes it."""

DIGESTS = {
    "problems": "e7b3059ab5fd4d0f24221e9952ce654a679f816fcb9effc26550f71366840506",
    "recognition": "a701887674dd38d3928e52e2cac1a510e87add5ade43616ceddaaaac62d98208",
    "malformed": "ba7722e6550b29ea3e9a152b116cd9c02faef2aeed494e0ceb66788546853459",
}
"""SHA-256 of each file: that of what `verification.conformance.making` writes."""

NAMES = tuple(DIGESTS)
ROUNDING = 1e-12
"""Of a product of n + d terms in float64, by far: what a slack is lowered by."""

FLAGS = {
    "degenerate": "of a degenerate family: zeros, duplicates, rank deficiency, lambdas that are 0, scales",
    "float64": "its numbers are no float32, or no float32 point is optimal; for the profile float64 alone",
    "extreme": "sizes near the ends of float64, where squares overflow or vanish; asked with --filter alone",
    "critical": "lambda2 or lambda3 at, just below or just above the value from which on w or u is 0",
    "large": "many robots or many features",
    "real": "features of photographs",
    "tie": "two templates have the same optimum; either is a right label",
}


@dataclass(frozen=True, eq=False)
class Vector:
    """One problem and what is proved of it.

    Attributes
    ----------
    request : Request
    lower, upper : Fraction
        lower <= F* <= upper.
    comment : str
        What is special about it.
    flags : frozenset of str
        Keys of `FLAGS`.
    zero_views, zero_modalities : tuple of int
        w*_j = 0 and u*^i = 0 are proved of every optimum.
    dual : (float64 (d,), float64 (n,))
        (a, b) behind `lower`, rounded; empty where there are no zeros to bound.
    primal : (float64 (n,), float64 (d,))
        (w, u) behind `upper`, rounded; empty where it is not known.
    """

    request: Request
    lower: Fraction
    upper: Fraction
    comment: str = ""
    flags: frozenset[str] = frozenset()
    zero_views: tuple[int, ...] = ()
    zero_modalities: tuple[int, ...] = ()
    dual: tuple[Any, Any] = ((), ())
    primal: tuple[Any, Any] = ((), ())

    @property
    def id(self) -> str:
        """Its name."""
        return self.request.id

    @cached_property
    def target(self) -> Fraction:
        """||o||^2, exactly."""
        return squares(rationals(self.request.problem.o))

    @cached_property
    def view_slack(self) -> dict[int, Fraction]:
        """Lower bounds of lambda2 - |Xa - b|_j of the zero views."""
        problem, (a, b) = self.request.problem, self.dual
        with np.errstate(all="ignore"):
            sizes = {
                j: (abs(problem.X[j] @ a - b[j]), np.abs(problem.X[j]) @ np.abs(a) + abs(b[j]))
                for j in self.zero_views
            }
            return {j: _least(problem.lambda2 - v - ROUNDING * size) for j, (v, size) in sizes.items()}

    @cached_property
    def modality_slack(self) -> dict[int, Fraction]:
        """Lower bounds of lambda3 - ||X_i'b|| of the zero modalities."""
        problem, (_, b) = self.request.problem, self.dual
        blocks = {i: problem.blocks()[i] for i in self.zero_modalities}
        with np.errstate(all="ignore"):
            sizes = {
                i: (math.hypot(*(X.T @ b)), math.hypot(*(np.abs(X).T @ np.abs(b)))) for i, X in blocks.items()
            }
            return {i: _least(problem.lambda3 - pull - ROUNDING * size) for i, (pull, size) in sizes.items()}


def _least(slack: float) -> Fraction:
    return Fraction(max(0.0, float(slack))) if np.isfinite(slack) else Fraction(0)


@dataclass(frozen=True, eq=False)
class RecognitionSet:
    """Templates of one set of views, and the proved label.

    Attributes
    ----------
    id : str
    names : tuple of str
        Of the templates.
    templates : tuple of Vector
        Their problems, in the same order.
    labels : tuple of str
        The template of the lowest optimum; of a tie, all that have it.
    margin : float
        Lower bound of the distance from the lowest optimum to that of the best template that is no label, by
        the lowest optimum.
    comment : str
    flags : frozenset of str
    """

    id: str
    names: tuple[str, ...]
    templates: tuple[Vector, ...]
    labels: tuple[str, ...]
    margin: float
    comment: str = ""
    flags: frozenset[str] = frozenset()


@dataclass(frozen=True)
class Malformed:
    """A line that is no valid request.

    Attributes
    ----------
    id : str
    line : str
    fault : str
        What kind of fault it has, a key of `FAULTS`.
    comment : str
    """

    id: str
    line: str
    fault: str
    comment: str

    @property
    def callable(self) -> bool:
        """Whether it has all arguments of a Python function, so that the function itself must refuse it."""
        return self.fault in {"not finite", "negative", "shape", "modalities"}


FAULTS = {
    "syntax": "the line is no JSON object, or repeats a key",
    "missing": "a key is missing",
    "type": "a value has another type than it must have",
    "shape": "lengths do not fit, or there is nothing",
    "size": "n or d is not what X has",
    "modalities": "the sizes of the modalities are no partition of the columns",
    "not finite": "a number is NaN, infinite, or beyond float64",
    "negative": "a lambda is negative",
}


@dataclass(frozen=True, eq=False)
class Vectors:
    """All vectors of one version."""

    problems: tuple[Vector, ...]
    recognition: tuple[RecognitionSet, ...]
    malformed: tuple[Malformed, ...]
    version: str = VERSION
    records: Mapping[str, Any] = field(default_factory=dict, repr=False)

    @cached_property
    def ids(self) -> frozenset[str]:
        """Every id that a solver may be asked for."""
        templates = (each.id for found in self.recognition for each in found.templates)
        return frozenset(
            (*(each.id for each in self.problems), *templates, *(each.id for each in self.malformed))
        )


@cache
def all_vectors() -> Vectors:
    """The vectors that come with the package.

    Raises
    ------
    FileFormatError
        One of the files is damaged.
    """
    texts = {name: place(name).read_bytes() for name in NAMES}
    for name, text in texts.items():
        if (found := hashlib.sha256(text).hexdigest()) != DIGESTS[name]:
            must, remedy = f"must have the SHA-256 {DIGESTS[name]}", "Install the package again."
            raise FileFormatError(f"vectors/{name}.json", value=found, must=must, remedy=remedy)
    return read({name: json.loads(text) for name, text in texts.items()})


def place(name: str) -> Any:
    """Where a file of the vectors is."""
    return files(__package__) / "vectors" / f"{name}.json"


def read(records: Mapping[str, Any]) -> Vectors:
    """Read the records of the three files."""
    problems = tuple(_vector(entry) for entry in records["problems"]["problems"])
    recognition = tuple(_set(entry) for entry in records["recognition"]["sets"])
    malformed = tuple(Malformed(**entry) for entry in records["malformed"]["requests"])
    return Vectors(problems, recognition, malformed, records["problems"]["version"], records)


def proofs(vectors: Vectors) -> Iterator[tuple[str, dict[str, Any]]]:
    """The id and the proof file of every problem, templates of sets included."""
    for entry in vectors.records["problems"]["problems"]:
        yield entry["id"], entry["proof"]
    for found in vectors.records["recognition"]["sets"]:
        for template in found["templates"]:
            yield f"{found['id']}/{template['name']}", template_proof(found, template)


def template_proof(found: Mapping[str, Any], template: Mapping[str, Any]) -> dict[str, Any]:
    """The proof file of a template: what the set shares, and what is its own."""
    own = {key: template["proof"][key] for key in ("schema", "sha256", "claim", "primal", "dual")}
    return own | {"problem": found["views"] | {"o": template["o"]}}


def _vector(entry: Mapping[str, Any], proof: Mapping[str, Any] | None = None) -> Vector:
    proof = entry["proof"] if proof is None else proof
    lower, upper = (Fraction(float.fromhex(proof["claim"][end])) for end in ("lower", "upper"))
    zeros = tuple(entry.get("zero_views", ())), tuple(entry.get("zero_modalities", ()))
    dual = _floats(proof["dual"]["a"]), _floats(proof["dual"]["b"])
    primal = _floats(proof["primal"]["w"]), _floats(proof["primal"]["u"])
    request = Request(entry["id"], _problem(proof["problem"]))
    flags = frozenset(entry.get("flags", ()))
    return Vector(request, lower, upper, entry.get("comment", ""), flags, *zeros, dual, primal)


def _set(entry: Mapping[str, Any]) -> RecognitionSet:
    templates = tuple(
        _vector(
            each | {"id": f"{entry['id']}/{each['name']}", "flags": entry["flags"]},
            template_proof(entry, each),
        )
        for each in entry["templates"]
    )
    names = tuple(each["name"] for each in entry["templates"])
    margin = float.fromhex(entry["margin"])
    flags = frozenset(entry["flags"])
    return RecognitionSet(
        entry["id"], names, templates, tuple(entry["labels"]), margin, entry["comment"], flags
    )


def _problem(record: Mapping[str, Any]) -> Problem:
    X = [_floats(row) for row in record["X"]]
    weights = {name: float.fromhex(record[name]) for name in LAMBDAS}
    return Problem(X, _floats(record["o"]), modalities=list(record["modalities"].values()), **weights)


def _floats(values: list[str]) -> Any:
    return np.array([float.fromhex(value) for value in values])
