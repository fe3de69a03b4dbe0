"""What the checks measure by: rounding of formulas of degree 2, shares, points of a fitting size, counts."""

from collections.abc import Iterable
from dataclasses import fields, replace
from fractions import Fraction
from typing import Any

import numpy as np

from convexperc.problem.arrays import FeatureVector, Vector
from convexperc.problem.problem import Problem
from verification.exact.formulation import residuals
from verification.exact.numbers import Rational
from verification.exact.problem import ExactProblem
from verification.problems.sources import Source

ULP = Fraction(1, 2**52)
"""One unit in the last place, as a share of a number."""
SMALLEST = Fraction(1, 2**1074)
"""The smallest positive float: what one underflow can lose."""
LARGEST_MEASURE = 1e300
"""Measures stay finite, so that they can be written to JSON and driven up."""
LARGE = Fraction(2) ** 1000
"""Sums beyond this may overflow float64 on the way."""
FAR = 900
"""Points are scaled by no more than 2^900, so that their entries are finite."""


def size(problem: ExactProblem) -> int:
    """Return n + d."""
    return problem.n + problem.d


def magnitudes(
    problem: ExactProblem, w: Iterable[Fraction], u: Iterable[Fraction]
) -> tuple[Rational, Rational]:
    """X'w - o and Xu - w with every sign taken as +: what their rounding is a share of."""
    rows = tuple(tuple(map(abs, row)) for row in problem.rows)
    positive = replace(problem, rows=rows, target=tuple(-abs(x) for x in problem.target))
    p, q = residuals(positive, [abs(x) for x in w], [-abs(x) for x in u])
    return p, tuple(-x for x in q)


def underflow(problem: ExactProblem, w: Iterable[Fraction], u: Iterable[Fraction]) -> Fraction:
    """Bound what underflow may take from any formula of degree 2 in X, w, u and o."""
    largest = Fraction(max(map(abs, (x for row in problem.rows for x in row))), problem.unit)
    entries = [
        largest,
        Fraction(max(map(abs, problem.target)), problem.target_unit),
        *map(abs, w),
        *map(abs, u),
    ]
    factor = (1 + max(entries)) ** 3 * (1 + max(problem.lambdas))
    return size(problem) ** 2 * factor * SMALLEST


def number(value: Fraction) -> float:
    """The nearest float, infinite beyond the largest."""
    try:
        return float(value)
    except OverflowError:
        return np.inf if value > 0 else -np.inf


def share(part: Fraction, whole: Fraction) -> float:
    """Divide `part` by `whole`, as a float from 0 to `LARGEST_MEASURE`; that where only `whole` is 0."""
    if part <= 0:
        return 0.0
    return min(number(part / whole), LARGEST_MEASURE) if whole else LARGEST_MEASURE


def is_finite(*vectors: np.ndarray) -> bool:
    """Whether no entry is NaN or infinite, as those of weights beyond float64 are."""
    return all(bool(np.isfinite(vector).all()) for vector in vectors)


def drawn_point(problem: Problem, source: Source) -> tuple[Vector, FeatureVector]:
    """Draw (w, u) of the size that optima have: about ||o|| / ||X|| and ||o|| / ||X||^2."""
    views, target = _exponent(problem.X), _exponent(problem.o)
    w, u = source.matrix(1, problem.n)[0], source.matrix(1, problem.d)[0]
    return _shifted(w, target - views), _shifted(u, target - 2 * views)


def _exponent(values: np.ndarray) -> int:
    return int(np.frexp(np.abs(values).max())[1])


def _shifted(values: np.ndarray, exponent: int) -> np.ndarray:
    with np.errstate(under="ignore"):
        return np.asarray(np.ldexp(values, max(-FAR, min(FAR, exponent))))


def add_fields(counts: Any, others: Any) -> None:
    """Add to each field of a dataclass the same field of another object of the class."""
    for each in fields(counts):
        setattr(counts, each.name, getattr(counts, each.name) + getattr(others, each.name))
