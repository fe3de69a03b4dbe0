"""R1 and B4 by cases: the label of small template libraries against the exact optimum of every template."""

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from convexperc.problem.problem import Problem
from convexperc.recognition import label as recognizing
from convexperc.recognition.recognition import Recognition, Verdict
from verification.checks.interface import REFEREED, Check, Observation
from verification.checks.measures import number
from verification.exact import referee
from verification.exact.numbers import Enclosure, rationals, squares
from verification.exact.problem import ExactProblem
from verification.ledger.evidence import Outcome
from verification.problems.sources import Source

PARTS = ("R1/separated", "B4/label", "B4/share", "B4/tie")
FRESH, COPY, SWAPPED = "another template", "the same again", "two columns of equal data exchanged"
NEGATED = "the first one negated"
"""Its optimum is that of the first one, at (-w, -u): no interval can separate them, and no order either."""


@dataclass(frozen=True)
class _Library:
    """A problem whose X may have two equal columns, its templates, and those that are the first one again."""

    problem: Problem
    templates: tuple[np.ndarray, ...]
    twins: tuple[int, ...]


def observe(problem: Problem, source: Source) -> Iterator[Observation]:
    """Recognise among two to four templates, copies and permuted ones among them."""
    library = _drawn(problem, source)
    posed = library.problem
    lambda1, lambda2, lambda3 = posed.lambdas
    found = recognizing.recognize(
        posed.X, np.stack(library.templates).T, modalities=posed.modalities,
        lambda1=lambda1, lambda2=lambda2, lambda3=lambda3,
    )  # fmt: skip
    values = [referee.optimum(posed.for_template(o)).value for o in library.templates]
    yield _separated(found, values, [squares(rationals(o)) for o in library.templates])
    yield _label(found, values)
    yield _share(
        found, [_quotient(v, squares(rationals(o))) for v, o in zip(values, library.templates, strict=True)]
    )
    yield _tie(found, library.twins)


def _drawn(problem: Problem, source: Source) -> _Library:
    group = next((g for g in ExactProblem.of(problem).groups if len(g) > 1), None)
    templates, twins, X = [problem.o], [0], problem.X
    kinds = (FRESH, COPY, NEGATED, SWAPPED) if group else (FRESH, COPY, NEGATED)
    for j in range(1, source.integer(2, 4)):
        kind, o = source.choice(kinds), problem.o.copy()
        if kind == FRESH:
            o = source.matrix(1, problem.d)[0]
        elif kind == NEGATED:
            o = -o
        else:
            twins.append(j)
        if kind == SWAPPED and group:
            X = X.copy()
            X[:, group[1]] = X[:, group[0]]
            o[[group[0], group[1]]] = o[[group[1], group[0]]]
        templates.append(o)
    lambda1, lambda2, lambda3 = problem.lambdas
    posed = Problem(
        X, problem.o, modalities=problem.modalities, lambda1=lambda1, lambda2=lambda2, lambda3=lambda3
    )
    return _Library(posed, tuple(templates), tuple(twins))


def _place(found: Recognition) -> int | None:
    """Number of the proved label."""
    return None if found.label is None else found.names.index(found.label)


def _rivals(values: list[Enclosure], j: int) -> list[int]:
    """Templates that the exact optima do not place above template j."""
    return [k for k, value in enumerate(values) if k != j and value.lower <= values[j].upper]


def _separated(found: Recognition, values: list[Enclosure], targets: list[Fraction]) -> Observation:
    """Proved only where one optimum lies below all others; another verdict only where none does."""
    part, best = "R1/separated", min(range(len(values)), key=lambda j: values[j].upper)
    alone, proved = not _rivals(values, best), found.verdict is Verdict.PROVED
    detail = f"{found.verdict.value} ({found.reason}), F* = {[number(v.upper) for v in values]}"
    if alone and not proved:
        if found.verdict is Verdict.UNDECIDED:
            return Observation(part, Outcome.UNDECIDED, detail=detail)
        if all(value.upper >= target for value, target in zip(values, targets, strict=True)):
            return Observation(part, Outcome.SKIPPED, detail="every optimum is w = u = 0")
    return Observation.of(part, alone == proved, 0.0, detail)


def _label(found: Recognition, values: list[Enclosure]) -> Observation:
    j = _place(found)
    if j is None:
        return Observation("B4/label", Outcome.SKIPPED, detail=f"no label: {found.verdict.value}")
    below = [k for k in range(len(values)) if k != j and values[k].upper < values[j].lower]
    detail = f"{found.label} is proved, but F* = {[number(v.upper) for v in values]}"
    return Observation.of("B4/label", not below, float(len(below)), detail)


def _quotient(value: Enclosure, square: Fraction) -> tuple[Fraction, Fraction]:
    """Bounds of F* / ||o||^2; 1 of a template of length 0."""
    return (value.lower / square, value.upper / square) if square else (Fraction(1), Fraction(1))


def _share(found: Recognition, left: list[tuple[Fraction, Fraction]]) -> Observation:
    """The same answers decided by the explained fraction."""
    again = recognizing.decided_by(found, "explained fraction")
    j = _place(again)
    if j is None:
        return Observation("B4/share", Outcome.SKIPPED, detail=f"no label: {again.verdict.value}")
    below = [k for k in range(len(left)) if k != j and left[k][1] < left[j][0]]
    detail = f"{again.label} is proved, but F* / ||o||^2 = {[number(high) for _, high in left]}"
    return Observation.of("B4/share", not below, float(len(below)), detail)


def _tie(found: Recognition, twins: tuple[int, ...]) -> Observation:
    """Of twins none is proved and none is a candidate without the others."""
    if len(twins) < 2:
        return Observation("B4/tie", Outcome.SKIPPED, detail="no two templates are the same")
    names = [found.names[j] for j in twins]
    told = found.label in names
    parted = {name in found.candidates for name in names} == {True, False}
    detail = f"{', '.join(names)} are the same: {found.verdict.value}, candidates {found.candidates}"
    return Observation.of("B4/tie", not (told or parted), float(told or parted), detail)


CHECKS = (Check("label", PARTS, observe, REFEREED, largest=(3, 6), share=0.04),)
