"""One problem in one precision after the other, until its interval is narrow or the budget is spent."""

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import flint
import numpy as np

from convexperc.certificate.rationals import exact_optimum
from convexperc.certificate.tolerances import Tolerances
from convexperc.enclosure.active_set import Start
from convexperc.enclosure.balls import Number, float_above, float_below, precision
from convexperc.enclosure.budget import Budget, OutOfBudget
from convexperc.enclosure.exact_data import ExactData, ExactViews
from convexperc.enclosure.exact_point import ExactPoint, float_point
from convexperc.enclosure.interval import Interval
from convexperc.enclosure.reduced import ReducedBalls
from convexperc.enclosure.result import Enclosure
from convexperc.errors import SolverError
from convexperc.problem.arrays import FeatureVector, Vector, point_entries
from convexperc.problem.problem import Problem
from convexperc.problem.scaling import Scaling
from convexperc.solvers.newton.method import Newton

BITS = (128, 256, 512, 2048, 8192)
"""Precisions that are tried in turn; entries from 1e-150 to 1e150 in one matrix need the last ones."""


@dataclass(frozen=True, eq=False)
class Known:
    """What does not depend on the precision.

    Attributes
    ----------
    problem : Problem
    scaling : Scaling
    data : ExactData
        With the budget of the call.
    optimum : Fraction or None
        The exact one of the equality case.
    near : Start or None
        A float64 answer, normalised.
    """

    problem: Problem
    scaling: Scaling
    data: ExactData
    optimum: Fraction | None
    near: Start | None

    @classmethod
    def of(
        cls,
        problem: Problem,
        near: tuple[Vector, FeatureVector] | None,
        budget: Budget,
        shared: ExactViews | None = None,
    ) -> "Known":
        """Read the data exactly.

        Parameters
        ----------
        problem : Problem
        near : pair of float64 (n,) and (d,), or None
            A point (w, u), normalised, from which Newton's method starts.
        budget : Budget
        shared : ExactViews, optional
            Those of another template of the same views.

        Raises
        ------
        OutOfBudget
        """
        with budget.running():
            data = ExactData.of(problem, budget, shared)
            optimum = exact_optimum(problem)
        return cls(
            problem, Scaling.of(problem), data, optimum, None if near is None else _start(problem, near)
        )

    def levels(self, bits: int, tolerances: Tolerances) -> Iterator[Enclosure]:
        """The best enclosure so far, after each precision from `bits` on, until one is within the tolerances.

        It ends early, perhaps without any, where the budget is spent.
        """
        best = None
        for more in (bits, *(larger for larger in BITS if larger > bits)):
            try:
                found = self._level(more, tolerances)
            except OutOfBudget:
                return
            if best is None or not best.steps or found.share_of_target < best.share_of_target:
                best = found
            yield best
            if best.steps and tolerances.met_by_shares(best.relative_width, best.share_of_target):
                return
            if self.data.budget.spent:
                return

    def _level(self, bits: int, tolerances: Tolerances) -> Enclosure:
        """The best that one precision gives."""
        scaling, budget = self.scaling, self.data.budget
        with precision(bits), budget.running():
            reduced = ReducedBalls.of(self.problem, (scaling.x, scaling.o), self.data)
            interval = Interval(reduced, _scaled_ball(self.optimum, scaling), tolerances)
            with suppress(OutOfBudget):
                self._narrow(interval)
            point = np.zeros(self.problem.n), np.zeros(self.problem.d)
            with suppress(OutOfBudget):
                point = float_point(self.problem, self.data, scaling, reduced, interval.point)
            unit = flint.arb(2) ** (2 * scaling.o)
            ends = max(0.0, float_below(interval.lower * unit)), float_above(interval.upper * unit)
            exact = ExactPoint.of(interval, scaling)
            widths, method = (interval.relative, interval.share), f"ball arithmetic, {bits} bits"
            return Enclosure(*ends, *widths, *point, bits, interval.steps, exact, method)

    def _narrow(self, interval: Interval) -> None:
        """Newton's method from the float64 answer, then the central path."""
        if self.optimum is None and self.near is not None:
            with suppress(ZeroDivisionError):  # a matrix that is singular in this precision
                interval.refine(self.near)
        if not (interval.steps and interval.narrow):
            with suppress(ZeroDivisionError):
                interval.follow()


def float_answer(problem: Problem, given: tuple[Any, Any] | None) -> tuple[Vector, FeatureVector] | None:
    """A point (w, u) near the optimum, normalised: the one given, or Newton's; None where there is none.

    Raises
    ------
    PointError
        The one given has a wrong shape, or NaN or infinity.
    """
    scaling = Scaling.of(problem)
    if given is not None:
        w = point_entries(given[0], problem.n, "w", finite=True)
        return scaling.point(w, point_entries(given[1], problem.d, "u", finite=True))
    try:
        with np.errstate(all="ignore"):
            found = Newton().solve(scaling.normalise(problem))
    except (SolverError, ArithmeticError, np.linalg.LinAlgError):
        return None
    return found.w, found.u


def _start(problem: Problem, near: tuple[Vector, FeatureVector]) -> Start | None:
    """(w, t) of a normalised point; None where they are not finite."""
    w, u = near
    normal, t = Scaling.of(problem).normalise(problem), np.zeros(problem.m)
    if normal.lambda3 > 0.0:
        with np.errstate(over="ignore"):
            t = 2.0 * normal.modalities.norms(u) / normal.lambda3
    return Start(w, t) if np.isfinite(w).all() and np.isfinite(t).all() else None


def _scaled_ball(exact: Fraction | None, scaling: Scaling) -> Number | None:
    """The exact optimum of the equality case, normalised, in the precision in force."""
    if exact is None:
        return None
    value = exact / Fraction(2) ** (2 * scaling.o)
    return flint.arb(flint.fmpq(value.numerator, value.denominator))
