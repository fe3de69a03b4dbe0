"""B1 by cases: F is homogeneous in two ways, so F* of scaled data is known from F* of the data."""

from collections.abc import Iterator
from fractions import Fraction

import numpy as np

from convexperc.problem.problem import Problem
from convexperc.solution import single as solving
from convexperc.solution.solution import Status
from verification.checks.interface import Check, Observation
from verification.checks.measures import number, share
from verification.ledger.evidence import Outcome
from verification.problems.sources import Source

PART = "B1/scaling"
SMALLEST_NORMAL = 2.0**-1022
LAMBDAS = Fraction(2**52 + 1, 2**52) ** 3
"""A scaled lambda is rounded once or twice, by half a unit each; F* grows by no larger factor."""
BINARY, DECIMAL = 40, 6
"""Largest exponents: enough to leave every fixed tolerance behind."""


def observe(problem: Problem, source: Source) -> Iterator[Observation]:
    """Solve o, lambda2, lambda3 times t and X, lambda1, lambda2, lambda3 times s, s^2, s, s^2 as well.

    Formula: F* becomes t^2 F*.
    """
    s, t = _factor(source), _factor(source)
    scaled = _scaled(problem, s, t) or _scaled(problem, _binary(s), _binary(t))
    if scaled is None:
        yield Observation(PART, Outcome.SKIPPED, detail=f"s = {s}, t = {t} leave float64")
        return
    first, (second, t) = solving.solve(problem), (solving.solve(scaled[0]), scaled[1])
    if Status.NOT_CERTIFIED in (first.status, second.status):
        yield Observation(PART, Outcome.UNDECIDED, detail="an answer is not certified")
        return
    proofs = first.certificate, second.certificate
    ends = [x for proof in proofs for x in (proof.lower, proof.upper)]
    if not np.isfinite(ends).all():
        yield Observation(PART, Outcome.SKIPPED, detail="F* is beyond float64")
        return
    low, high, scaled_low, scaled_high = (Fraction(x) for x in ends)
    apart = max(scaled_low - LAMBDAS * t * t * high, t * t * low / LAMBDAS - scaled_high)
    detail = f"t = {t}: [{ends[0]!r}, {ends[1]!r}] became [{ends[2]!r}, {ends[3]!r}]"
    yield Observation.of(PART, apart <= 0, share(apart, t * t * high), detail)


def _factor(source: Source) -> Fraction:
    """A power of two or of ten."""
    if source.integer(0, 1):
        return Fraction(10) ** source.integer(-DECIMAL, DECIMAL)
    return Fraction(2) ** source.integer(-BINARY, BINARY)


def _binary(factor: Fraction) -> Fraction:
    """The power of two below."""
    return Fraction(2) ** int(np.floor(np.log2(float(factor))))


def _scaled(problem: Problem, s: Fraction, t: Fraction) -> tuple[Problem, Fraction] | None:
    """The scaled problem and t, or None unless X and o scale exactly and the lambdas stay normal."""
    with np.errstate(all="ignore"):
        X, o = problem.X * float(s), problem.o * float(t)
    weights = [Fraction(x) * f for x, f in zip(problem.lambdas, (s * s, s * t, s * s * t), strict=True)]
    lambdas = [number(x) for x in weights]
    if not (np.isfinite(X).all() and np.isfinite(o).all() and np.isfinite(lambdas).all()):
        return None
    if any(0.0 < x < SMALLEST_NORMAL or (x == 0.0 and y) for x, y in zip(lambdas, weights, strict=True)):
        return None
    for before, after, factor in ((problem.X, X, s), (problem.o, o, t)):
        pairs = zip(before.flat, after.flat, strict=True)
        if any(Fraction(float(x)) * factor != Fraction(float(y)) for x, y in pairs):
            return None
    scaled = Problem(
        X, o, modalities=problem.modalities, lambda1=lambdas[0], lambda2=lambdas[1], lambda3=lambdas[2]
    )
    return scaled, t


CHECKS = (Check("scaling", (PART,), observe, share=0.5),)
