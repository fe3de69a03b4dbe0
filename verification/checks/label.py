"""R1 and B4 by cases: the label of small template libraries against the exact optimum of every template."""

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction

import numpy as np

from convexperc.problem.problem import Problem
from convexperc.recognition import label as recognizing
from convexperc.recognition.recognition import Recognition, Verdict
from verification.checks.interface import REFEREED, Check, Observation
from verification.checks.libraries import drawn_templates, recognized
from verification.checks.measures import number
from verification.exact import referee
from verification.exact.numbers import Enclosure, rationals, squares
from verification.ledger.evidence import Outcome
from verification.problems.sources import Source

PARTS = ("R1/separated", "B4/label", "B4/share", "B4/tie")
TOLERANCES = (1e-9, 1e-2)
"""The relative tolerance asked for; the looser one leaves intervals that overlap, to be narrowed."""
RESOLVED = Fraction(1, 10**12)
"""Optima further apart than this share must be told apart: narrowed intervals are some 1e-16 wide."""
SMALLEST = Fraction(1, 10**290)
"""Optima below this are not told apart: the ends of float64 intervals are subnormal there."""


def observe(problem: Problem, source: Source) -> Iterator[Observation]:
    """Recognise among two to four templates, copies, near and permuted ones among them."""
    library = drawn_templates(problem, source)
    tolerance, escalate = source.choice(TOLERANCES), source.integer(0, 3) > 0
    found, how = recognized(library, source, relative_tolerance=tolerance, escalate=escalate)
    values = [referee.optimum(posed).value for posed in library.problems]
    targets = [squares(rationals(o)) for o in library.templates]
    wrong = _false_intervals(found, values)
    if wrong:
        yield Observation("R1/separated", Outcome.FAILED, 1.0, f"{how}: {wrong}")
    else:
        yield _separated(found, values, targets, narrowed=escalate)
    yield _label(found, values, _ends(found.answers.lower.size, source))
    yield _share(found, [_quotient(v, square) for v, square in zip(values, targets, strict=True)])
    yield _tie(found, library.twins)


def _false_intervals(found: Recognition, values: list[Enclosure]) -> str:
    """What contradicts the intervals behind a verdict, and that each template is excluded or answered."""
    for name, low, high, value in zip(
        found.names, found.answers.lower, found.answers.upper, values, strict=True
    ):
        if low > value.upper or high < value.lower:
            return f"[{low!r}, {high!r}] of {name} misses F* = {number(value.upper)!r}"
    done = found.excluded | found.answers.enclosed
    return "" if done.all() else f"neither excluded nor answered: {[bool(x) for x in done]}"


def _ends(p: int, source: Source) -> list[tuple[int, int]]:
    """Intervals with small integers for ends, so that some end where others begin."""
    lower = [source.integer(0, 3) for _ in range(p)]
    return [(low, low + source.integer(0, 3)) for low in lower]


def _decided_otherwise(found: Recognition, ends: list[tuple[int, int]]) -> str:
    """What contradicts the verdict on other intervals.

    A template whose lower end equals the lowest upper end may be as good as the best: it is a rival.
    """
    lower, upper = (np.array(each, dtype=np.float64) for each in zip(*ends, strict=True))
    given = replace(found.answers, lower=lower, upper=upper)
    again = recognizing.decide(given, found.names, found.views)
    rivals = {name for name, low in zip(found.names, lower, strict=True) if low <= upper.min()}
    excluded = {name for name, out in zip(found.names, again.excluded, strict=True) if out}
    # where every optimum is w = u = 0, all are candidates, in any order, whatever the intervals
    everyone = again.verdict is Verdict.TIE and sorted(again.candidates) == sorted(again.names)
    fits = everyone or (set(again.candidates) == rivals and (again.label is None or len(rivals) == 1))
    if fits and excluded == set(found.names) - rivals:
        return ""
    return f"{again.verdict.value} among {again.candidates}, {excluded} excluded: intervals {ends}"


def _place(found: Recognition) -> int | None:
    """Number of the proved label."""
    return None if found.label is None else found.names.index(found.label)


def _rivals(values: list[Enclosure], j: int) -> list[int]:
    """Templates that the exact optima do not place above template j."""
    return [k for k, value in enumerate(values) if k != j and value.lower <= values[j].upper]


def _separated(
    found: Recognition, values: list[Enclosure], targets: list[Fraction], *, narrowed: bool
) -> Observation:
    """Proved only where one optimum lies below all others; another verdict only where none does."""
    part, best = "R1/separated", min(range(len(values)), key=lambda j: values[j].upper)
    alone, proved = not _rivals(values, best), found.verdict is Verdict.PROVED
    detail = f"{found.verdict.value} ({found.reason}), F* = {[number(v.upper) for v in values]}"
    if alone and not proved:
        if found.verdict is Verdict.UNDECIDED and not (narrowed and _far_apart(values, best)):
            return Observation(part, Outcome.UNDECIDED, detail=detail)
        if all(value.upper >= target for value, target in zip(values, targets, strict=True)):
            return Observation(part, Outcome.SKIPPED, detail="every optimum is w = u = 0")
    return Observation.of(part, alone == proved, 0.0, detail)


def _far_apart(values: list[Enclosure], best: int) -> bool:
    """Whether the lowest optimum is as far below all others as narrowed intervals resolve."""
    limit = values[best].upper * (1 + RESOLVED) + SMALLEST
    return all(value.lower > limit for j, value in enumerate(values) if j != best)


def _label(found: Recognition, values: list[Enclosure], ends: list[tuple[int, int]]) -> Observation:
    wrong = _decided_otherwise(found, ends)
    if wrong:
        return Observation("B4/label", Outcome.FAILED, 1.0, wrong)
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
