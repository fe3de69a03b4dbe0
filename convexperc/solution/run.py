"""One choice of the lambdas under way: which templates are solved, and what is proved of each so far."""

import math
import time
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from convexperc.certificate.lasso import is_lasso, judge_merged
from convexperc.certificate.reduced import Bounds, Shared, judge
from convexperc.errors import PointError, ProblemError
from convexperc.problem.arrays import nonnegative_number
from convexperc.problem.library import Projection
from convexperc.recognition.decision import Decision, Intervals, costs
from convexperc.solution.answers import Answers, Stages, within
from convexperc.solution.single import solve
from convexperc.solution.solution import Solution
from convexperc.solvers.interface import Solver
from convexperc.solvers.newton.loop import Race
from convexperc.solvers.newton.method import Batch, Newton, Start, lassos

MARGIN = 1e-6
"""A template is given up only this far, relatively, above the best one: it must be proved to lie above."""
SHARE = 0.3
"""Part of the tolerance that the solver is asked for; the rest is left to rounding."""

Lambdas = tuple[float, float, float]
Chosen = Int[np.ndarray, " chosen"]
Given = tuple[Shared, Float[np.ndarray, "k n"], Float[np.ndarray, " k"], Float[np.ndarray, "k 3"]]
"""The frame, and c, ||o||^2 and the lambdas of the chosen templates, normalised."""


def read_lambdas(lambda1: Any, lambda2: Any, lambda3: Any) -> Lambdas:
    """Return the three as finite floats >= 0."""
    return (
        nonnegative_number(lambda1, "lambda1"),
        nonnegative_number(lambda2, "lambda2"),
        nonnegative_number(lambda3, "lambda3"),
    )


class _Values(NamedTuple):
    """Bounds of every F* and gap on the original data, and which gaps are within the tolerances."""

    lower: Float[np.ndarray, " p"]
    upper: Float[np.ndarray, " p"]
    gap: Float[np.ndarray, " p"]
    certified: Bool[np.ndarray, " p"]


@dataclass
class Run:
    """The state of p templates; grows until `answers` freezes it.

    Attributes
    ----------
    projection : Projection
    lambdas : (float, float, float)
    normalised : float64 (p, 3)
        The lambdas in each template's own units.
    ready : bool (p,)
        Where the reduced data may be used; the others are for `fall_back`.
    batch : Batch
        Normalised answers.
    bounds : Bounds
        Normalised.
    singles : dict of int to Solution
    """

    projection: Projection
    lambdas: Lambdas
    normalised: Float[np.ndarray, "p 3"]
    ready: Bool[np.ndarray, " p"]
    batch: Batch
    bounds: Bounds
    relative_tolerance: float
    absolute_tolerance: float
    warm: bool
    singles: dict[int, Solution] = field(default_factory=dict)
    solving: float = 0.0
    proving: float = 0.0
    falling_back: float = 0.0

    @classmethod
    def of(
        cls,
        projection: Projection,
        lambdas: Lambdas,
        relative_tolerance: float,
        absolute_tolerance: float,
        start: Answers | None = None,
    ) -> "Run":
        """Nothing is solved yet; `start` gives the first (w, t) of every template.

        Raises
        ------
        ProblemError
            `start` is of another size.
        """
        relative = nonnegative_number(relative_tolerance, "relative_tolerance", error=PointError)
        absolute = nonnegative_number(absolute_tolerance, "absolute_tolerance", error=PointError)
        (p, n), m = projection.C.shape, len(projection.modalities)
        normalised, inside = projection.lambdas(lambdas)
        ready = projection.sound & inside
        if is_lasso(lambdas) and not projection.distinct.floor > 0.0:
            ready[:] = False
        batch = Batch(np.zeros((p, n)), np.zeros((p, m)), np.zeros((p, n)), np.zeros(p, dtype=np.int64))
        run = cls(
            projection, lambdas, normalised, ready, batch, Bounds.unknown(p, n, m),
            relative, absolute, start is not None,
        )  # fmt: skip
        if start is not None:
            run._start_from(start)
        return run

    def _start_from(self, start: Answers) -> None:
        sizes = self.batch.W.shape, self.batch.T.shape
        if (start.w.shape, start.modality_norms.shape) != sizes:
            must = f"must be answers of {sizes[0]} views and {sizes[1]} modalities"
            found = start.w.shape, start.modality_norms.shape
            raise ProblemError("start", value=found, must=must, remedy="Start anew.")
        x, k = self.projection.x, self.projection.exponents[:, None]
        with np.errstate(over="ignore", under="ignore", divide="ignore", invalid="ignore"):
            W = np.ldexp(start.w, x - k)
            T = 2.0 * np.ldexp(start.modality_norms, 2 * x - k) / self.normalised[:, 2:]
        self.batch.W[:] = np.where(np.isfinite(W), W, 0.0)
        self.batch.T[:] = np.where(np.isfinite(T), T, 0.0)

    @property
    def lasso(self) -> bool:
        """Whether the lambdas make a lasso in w of the problem."""
        return is_lasso(self.lambdas)

    def advance(
        self, chosen: Chosen, ceiling: float | None = None, decision: Decision = Decision.OBJECTIVE
    ) -> None:
        """Solve the chosen templates from the reduced data, and prove what can be proved.

        With a `ceiling`, one whose cost is seen to lie above it, or above an earlier one, is given up.
        """
        if chosen.size == 0:
            return
        began, data = time.perf_counter(), self.projection
        if self.lasso:
            found = lassos(data.distinct, data.C[chosen], self.normalised[chosen], len(data.modalities))
            self.solving += time.perf_counter() - began
            self.prove(chosen, found)
            return
        n = data.C.shape[1]
        start = Start(self.batch.W[chosen], self.batch.T[chosen]) if self.warm else None
        solver = Newton(tolerance=max(SHARE * self.relative_tolerance, 1e-13))
        clipped = np.minimum(self.normalised[chosen], [np.inf, 4.0, 8.0 * n])
        contest = None
        if ceiling is not None:
            contest = self._contest(chosen, ceiling, decision)
        found = solver.batch(data.shared, data.C[chosen], data.targets[chosen], clipped, start, contest)
        self.solving += time.perf_counter() - began
        self.prove(chosen, found)

    def _contest(self, chosen: Chosen, ceiling: float, decision: Decision) -> Race:
        """The ceiling in units that all templates share."""
        data = self.projection
        if decision is Decision.EXPLAINED_SHARE:
            return Race(1.0 / data.targets[chosen], ceiling, MARGIN)
        largest = int(data.exponents.max())
        units = np.ldexp(1.0, 2 * (data.exponents[chosen] - largest))
        return Race(units, math.ldexp(ceiling, -2 * largest), MARGIN)

    def prove(self, chosen: Chosen, found: Batch, *, thorough: bool = True) -> None:
        """Keep what is found for the chosen templates together with its bounds.

        Without `thorough`, the first dual point is tried alone.
        """
        began, data = time.perf_counter(), self.projection
        given = data.shared, data.C[chosen], data.targets[chosen], self.normalised[chosen]
        if self.lasso:
            bounds = judge_merged(data.distinct, *given, found.W, found.T, found.Q)
        else:
            bounds = Bounds.unknown(chosen.size, data.C.shape[1], len(data.modalities))
            tolerance = self.relative_tolerance if thorough else math.inf
            judge(*given, found.W, found.T, found.Q, tolerance, bounds)
            if thorough:
                bounds = self._helped(bounds, given, found)
        for mine, new in zip(self.bounds, bounds, strict=True):
            mine[chosen] = new
        for name in ("W", "T", "Q", "iterations"):
            getattr(self.batch, name)[chosen] = getattr(found, name)
        self._changed()
        self.proving += time.perf_counter() - began

    def _helped(self, bounds: Bounds, given: Given, found: Batch) -> Bounds:
        """Also ask the lasso below F*, where the lambdas are so small that rounding hides a dual point."""
        tolerances = self.relative_tolerance, self.absolute_tolerance
        missed = ~within(bounds.gap, bounds.lower, given[2] * (1.0 - 2.0**-20), tolerances)
        if not missed.any() or not self.projection.distinct.floor > 0.0:
            return bounds
        lasso = judge_merged(self.projection.distinct, *given, found.W, found.T, found.Q)
        return bounds._replace(
            lower=np.maximum(bounds.lower, lasso.lower), gap=np.minimum(bounds.gap, lasso.gap)
        )

    def finish(self) -> None:
        """Solve every template to the end."""
        self.advance(self.ready.nonzero()[0])
        self.fall_back((~self.certified()).nonzero()[0])

    def fall_back(self, chosen: Chosen, solver: Solver | None = None, *, escalate: bool = True) -> None:
        """Solve the chosen templates one by one, on the original data."""
        if chosen.size == 0:
            return
        began, data = time.perf_counter(), self.projection
        first = data.problem(int(chosen[0]), self.lambdas)
        for j in chosen.tolist():
            self.singles[j] = solve(
                first.for_template(data.template(j)),
                solver,
                escalate=escalate,
                relative_tolerance=self.relative_tolerance,
                absolute_tolerance=self.absolute_tolerance,
            )
        self._changed()
        self.falling_back += time.perf_counter() - began

    def intervals(self) -> tuple[Float[np.ndarray, " p"], Float[np.ndarray, " p"]]:
        """Proved bounds of every F*, on the original data."""
        return self._values.lower, self._values.upper

    def costs(self, decision: Decision) -> Intervals:
        """Proved bounds of what decides; see `convexperc.recognition.decision`."""
        return costs(decision, self.intervals(), self.projection.squares)

    def certified(self) -> Bool[np.ndarray, " p"]:
        """Which answers are proved to be within the tolerances."""
        return self._values.certified

    @cached_property
    def _values(self) -> "_Values":
        """What is proved on the original data; powers of two in the safe range are exact."""
        shift, bounds = 2 * self.projection.exponents, self.bounds
        lower, upper, gap = (np.ldexp(x, shift) for x in (bounds.lower, bounds.upper, bounds.gap))
        if not self.ready.all():
            lower[~self.ready], upper[~self.ready], gap[~self.ready] = 0.0, np.inf, np.inf
        least, most = self.projection.squares
        upper = np.minimum(upper, most)
        certified = within(gap, lower, least, (self.relative_tolerance, self.absolute_tolerance))
        for j, solution in self.singles.items():
            proof = solution.certificate
            lower[j], upper[j], gap[j] = proof.lower, proof.upper, proof.gap
            certified[j] = proof.certified
        return _Values(lower, upper, gap, certified)

    def _changed(self) -> None:
        """Forget the values of before."""
        self.__dict__.pop("_values", None)

    def answers(self) -> Answers:
        """Everything that is known, on the original data."""
        data = self.projection
        k = data.exponents[:, None]
        lower, upper, gap, _ = self._values
        w = np.ldexp(self.batch.W, k - data.x)
        norms = np.ldexp(self.bounds.modality_norms, k - 2 * data.x)
        views, modalities = self.bounds.zero_views, self.bounds.zero_modalities
        for j, solution in self.singles.items():
            w[j], norms[j] = solution.w, solution.modality_norms
            views[j], modalities[j] = solution.certificate.zero_views, solution.certificate.zero_modalities
        return Answers(
            data, self.lambdas, w, norms, lower, upper, gap, views, modalities, self.batch,
            self.singles, self.relative_tolerance, self.absolute_tolerance,
            Stages(data.seconds, self.solving, self.proving, self.falling_back),
        )  # fmt: skip
