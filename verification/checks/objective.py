"""B1 by cases: the terms of F, the bounds of a certificate at any point, and F* of scaled data."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from convexperc.certificate import certificate as judge
from convexperc.problem import formulation as library
from convexperc.problem.problem import Problem
from convexperc.solution import single as solving
from verification.checks.acceptance import wrongly_certified
from verification.checks.interface import Check, Observation
from verification.checks.measures import (
    LARGE,
    LARGEST_MEASURE,
    ULP,
    drawn_point,
    magnitudes,
    number,
    share,
    size,
    underflow,
)
from verification.exact import referee
from verification.exact.formulation import norms, residuals
from verification.exact.numbers import Enclosure, Rationals, rationals, squares, total
from verification.exact.problem import ExactProblem
from verification.ledger.evidence import Outcome
from verification.problems.sources import Source

UNITS = 8
"""Units in the last place, times n + d, of the sum of magnitudes: one for each rounding, and room."""
NOWHERE, DISTANCES = -1.0, (2.0**-40, 2.0**-20, 2.0**-17, 2.0**-14, 2.0**-8)
"""A point from anywhere, or relative distances from the best known one: gaps of about their squares, on both
sides of the tolerances."""
TERMS = ("loss", "coupling", "view_norm", "modality_norm")


@dataclass(frozen=True)
class _Term:
    """One term of F: its exact value, the sum behind it without signs, and that without its lambda."""

    value: Enclosure
    size: Fraction
    plain: Fraction


def observe_terms(problem: Problem, source: Source) -> Iterator[Observation]:
    """Compare each of the library's terms, and their sum, with exact arithmetic at a drawn point."""
    w, u = drawn_point(problem, source)
    data, point = ExactProblem.of(problem), (rationals(w), rationals(u))
    true = _terms(data, *point)
    if max(max(term.size, term.plain) for term in true) > LARGE:
        yield Observation("B1/objective", Outcome.SKIPPED, detail="F may overflow float64 on the way")
        return
    with np.errstate(all="ignore"):
        terms, value = library.terms(problem, w, u), library.objective(problem, w, u)
    found = [*(getattr(terms, name) for name in TERMS), value]
    lost = underflow(data, *point)
    rooms = [UNITS * size(data) * (ULP * term.size + lost) for term in true]
    yield _worst_term(found, [term.value for term in true], rooms)


def _terms(data: ExactProblem, w: Rationals, u: Rationals) -> list[_Term]:
    """The four terms, and F."""
    (p, q), (sizes_p, sizes_q) = residuals(data, w, u), magnitudes(data, w, u)
    views, lengths = total(abs(x) for x in w), norms(data, u)
    shortest, longest = total(x.lower for x in lengths), total(x.upper for x in lengths)
    parts = (
        (Fraction(1), squares(p), squares(p), squares(sizes_p)),
        (data.lambda1, squares(q), squares(q), squares(sizes_q)),
        (data.lambda2, views, views, views),
        (data.lambda3, shortest, longest, longest),
    )
    found = [_Term(Enclosure(k * low, k * high), k * plain, plain) for k, low, high, plain in parts]
    ends = total(x.value.lower for x in found), total(x.value.upper for x in found)
    whole = total(x.size for x in found)
    return [*found, _Term(Enclosure(*ends), whole, whole)]


def _worst_term(found: list[float], values: list[Enclosure], rooms: list[Fraction]) -> Observation:
    worst, detail = 0.0, ""
    for name, value, true, room in zip((*TERMS, "F"), found, values, rooms, strict=True):
        measure = LARGEST_MEASURE
        if math.isfinite(value):
            away = max(true.lower - Fraction(value), Fraction(value) - true.upper, Fraction(0))
            measure = share(away, room)
        if measure > worst:
            worst, detail = measure, f"{name}: the library has {value!r}, exact is {number(true.lower)!r}"
    return Observation.of("B1/objective", worst <= 1.0, worst, detail)


def observe_bounds(problem: Problem, source: Source) -> Iterator[Observation]:
    """Let the referee judge what `certify` says of a point: anywhere, or near the optimum."""
    w, u = drawn_point(problem, source)
    near, thorough = source.choice((NOWHERE, 0.0, *DISTANCES)), bool(source.integer(0, 1))
    if near != NOWHERE:
        solution = solving.solve(problem)
        with np.errstate(over="ignore"):
            w, u = solution.w * (1.0 + near * np.sign(w)), solution.u * (1.0 + near * np.sign(u))
    proof = judge.certify(problem, w, u, thorough=thorough)
    truth = referee.optimum(problem)
    false = referee.violations(problem, w, u, proof, truth)
    if proof.certified:
        false += wrongly_certified(proof.gap, problem, truth)
    yield Observation.of("B1/dual", not false, float(len(false)), "; ".join(false))


CHECKS = (
    Check("terms", ("B1/objective",), observe_terms),
    Check("bounds", ("B1/dual",), observe_bounds, share=0.05, refereed=True),
)
