"""The optimum of a convex objective of squares, norms and losses, between two rational numbers.

Clarabel suggests a point and a dual vector on data that are moved to a least squares fit and divided by
powers of two. Newton's method in long numbers improves the point where no kink is met, and holds it where
one is. From there on everything is exact, or a ball: F at the point from above; from below the dual vector,
moved over the rationals until sum A'v = 0, and shortened until each part allows it (`conjugates`). Both
bounds hold whatever the suggestion was.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

from flint import arb, fmpq

from verification.exact.balls import Numbers, enclosed, exact, precision
from verification.lassos.referee import ends
from verification.reweighted.objectives.conjugates import blocks
from verification.reweighted.objectives.newton import polished
from verification.reweighted.objectives.objective import Objective
from verification.reweighted.objectives.scaling import Scaled
from verification.reweighted.objectives.suggestion import suggested
from verification.reweighted.objectives.system import BITS, System
from verification.reweighted.terms.expressions import fraction

ENOUGH = Fraction(1, 1 << 100)
"""Relative width of the optimum with which the search for better bounds ends."""


@dataclass(frozen=True)
class Optimum:
    """lower <= F* <= upper = F(point).

    Attributes
    ----------
    lower : Fraction or None
        None: no lower bound was found.
    upper : Fraction
        At least F(point), to 2**-200 or so.
    point : mapping of str to tuples of Fraction
        Entries of each variable.
    reason : str
        Why there is no lower bound.
    """

    lower: Fraction | None
    upper: Fraction
    point: Mapping[str, tuple[Fraction, ...]]
    reason: str = ""

    @property
    def gap(self) -> float:
        """(upper - lower)/upper; 0 where both are 0, infinite without a lower bound."""
        if self.lower is None:
            return float("inf")
        return float((self.upper - self.lower) / self.upper) if self.upper else 0.0


def optimum(objective: Objective) -> Optimum:
    """Enclose F*.

    Parameters
    ----------
    objective : Objective
        Convex: of squares and of the losses that `conjugates` reads.

    Raises
    ------
    NotCoveredError
        It has another loss.
    """
    parts = blocks(objective)
    with precision(BITS):
        if not objective.sizes or not parts:
            value = enclosed(objective.at({name: [fmpq(0)] * k for name, k in objective.sizes.items()}))
            zeros = {name: (Fraction(0),) * size for name, size in objective.sizes.items()}
            return Optimum(value.lower, value.upper, zeros)
        scaled = Scaled.of(System(parts))
        primal, dual = suggested(scaled.system)
        bounds = _Bounds(scaled.system)
        bounds.try_(primal, dual)
        bounds.try_([fmpq(0)] * scaled.system.n, None)
        for better, vector in () if dual is None else polished(scaled.system, primal, dual):
            bounds.try_(better, vector)
            if bounds.tight:
                break
        point = _named(objective, scaled.point(bounds.point))
        upper = enclosed(objective.at({name: list(map(exact, part)) for name, part in point.items()})).upper
        lower = None if bounds.lower is None else scaled.factor * bounds.lower
    if lower is None:
        return Optimum(None, upper, point, "Clarabel returned no dual vector of finite numbers.")
    return Optimum(fraction(lower), upper, point)


@dataclass
class _Bounds:
    """The best point and the best lower bound so far."""

    system: System
    point: Numbers = field(default_factory=list)
    upper: Any = None
    lower: Any = None

    def try_(self, point: Numbers, vector: Numbers | None) -> None:
        """Take what is better."""
        upper = ends(arb(self.system.value(point)))[1]
        if self.upper is None or upper < self.upper:
            self.point, self.upper = point, upper
        vector = None if vector is None else self.system.feasible(vector)
        if vector is not None:
            lower = self.system.below(vector)
            self.lower = lower if self.lower is None else max(self.lower, lower)

    @property
    def tight(self) -> bool:
        """Whether no better bounds are needed."""
        return self.lower is not None and bool(self.upper - self.lower <= exact(ENOUGH) * self.upper)


def _named(objective: Objective, z: Numbers) -> dict[str, tuple[Fraction, ...]]:
    found, at = {}, 0
    for name, size in objective.sizes.items():
        found[name] = tuple(fraction(x) for x in z[at : at + size])
        at += size
    return found
