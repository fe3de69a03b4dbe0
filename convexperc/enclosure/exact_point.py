"""A point in balls on its way back to the original data: as rationals, and rounded to float64."""

from dataclasses import dataclass
from fractions import Fraction

import flint
import numpy as np

from convexperc.certificate.rationals import LONGER, WORD_BITS, RowSpace, column
from convexperc.enclosure.balls import Number, Numbers
from convexperc.enclosure.budget import Budget
from convexperc.enclosure.central_path import Central
from convexperc.enclosure.dyadic import exact_balls
from convexperc.enclosure.exact_data import ExactData
from convexperc.enclosure.interval import Interval
from convexperc.enclosure.reduced import ReducedBalls
from convexperc.problem.arrays import Vector
from convexperc.problem.problem import Problem
from convexperc.problem.scaling import Scaling

LARGEST_SQUARE = Fraction(2) ** 2112
"""More than ||o||^2 of any o in float64: 2^64 entries below 2^1024."""


@dataclass(frozen=True)
class ExactPoint:
    """The point behind an enclosure before any rounding, on the original data.

    Attributes
    ----------
    w : n Fractions
    t : m Fractions
        u^i = t_i X_i' q where lambda1, lambda3 > 0; without meaning elsewhere.
    q : n Fractions
        The dual point's b is about -2 q.
    value : Fraction
        Upper bound of F at the point.
    lower, upper : Fraction
        lower <= F* <= upper <= value.
    """

    w: tuple[Fraction, ...]
    t: tuple[Fraction, ...]
    q: tuple[Fraction, ...]
    value: Fraction
    lower: Fraction
    upper: Fraction

    @classmethod
    def zero(cls, n: int, m: int) -> "ExactPoint":
        """w = u = 0, with bounds that hold of any float64 data."""
        nothing = Fraction(0)
        ends = LARGEST_SQUARE, nothing, LARGEST_SQUARE
        return cls((nothing,) * n, (nothing,) * m, (nothing,) * n, *ends)

    @classmethod
    def of(cls, interval: Interval, scaling: Scaling) -> "ExactPoint":
        """Take the point and the ends of a normalised interval."""
        x, o, point = scaling.x, scaling.o, interval.point
        t = point.t or [flint.arb(0)] * len(interval.reduced.K)
        ends = (_fraction(end, 2 * o) for end in (interval.value, interval.lower, interval.upper))
        return cls(
            tuple(_fraction(v, o - x) for v in point.w),
            tuple(_fraction(v, -4 * x) for v in t),
            tuple(_fraction(v, x + o) for v in point.q),
            *ends,
        )


def _fraction(value: Number, exponent: int) -> Fraction:
    """A ball without radius times 2^exponent."""
    whole, own = (int(part) for part in value.mid().man_exp())
    return whole * Fraction(2) ** (own + exponent)


def float_point(
    problem: Problem, data: ExactData, scaling: Scaling, reduced: ReducedBalls, point: Central
) -> tuple[Vector, np.ndarray]:
    """The point (w, u) on the original data, rounded to nearest; within the data's budget."""
    unit = flint.arb(2) ** (scaling.o - scaling.x)
    w, u = np.array([float(v * unit) for v in point.w]), np.zeros(problem.d)
    if problem.lambda1 == 0.0:
        return w, u
    if reduced.space is not None:
        found = _coupling(reduced.space, point.w, data.budget)
        return w, np.array([float(v * unit) for v in found])
    unit = unit * flint.arb(2) ** (-2 * scaling.x)
    parts = [[weight * v * unit for v in point.q] for weight in point.t]
    for columns, part in zip(problem.modalities, data.columns(parts), strict=True):
        u[columns] = [float(v) for v in part]
    return w, u


def _coupling(space: RowSpace, w: Numbers, budget: Budget) -> Numbers:
    """The u of least norm for which Xu is the projection of w onto the range of X."""
    whole = exact_balls(w, -space.exponent)
    longer = max(1.0, max(int(abs(value)).bit_length() for value in whole.whole) / WORD_BITS / space.words)
    budget.require((1 if space.rank == space.A.nrows() else LONGER) * longer * space.work)
    found, unit = space.coupling(column(whole.whole)), flint.arb(2) ** whole.exponent
    return [flint.arb(value) * unit for value in found.entries()]
