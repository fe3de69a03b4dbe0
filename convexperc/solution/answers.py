"""The answers to all templates of one frame, with what is proved of each; large vectors only on demand."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Bool, Float, Int

from convexperc.certificate.lasso import is_lasso
from convexperc.problem.arrays import FeatureVector
from convexperc.problem.library import Projection
from convexperc.problem.problem import Problem
from convexperc.problem.scaling import Scaling
from convexperc.solution.single import solve
from convexperc.solution.solution import Solution, Status
from convexperc.solvers.interface import SolverResult
from convexperc.solvers.newton.method import Batch, Newton


@dataclass(frozen=True)
class Stages:
    """Wall-clock seconds of each stage, all templates together.

    Attributes
    ----------
    read : float
        The Gram matrices, X O and the lengths: one pass over the data, shared by all answers of a path.
    solve : float
        Solving, and cheap lower bounds where templates may be excluded by them.
    prove : float
        The bounds of every answer, from the reduced data.
    fall_back : float
        The templates that this did not certify, one by one on the original data.
    """

    read: float
    solve: float
    prove: float
    fall_back: float

    @property
    def total(self) -> float:
        """Seconds in all."""
        return self.read + self.solve + self.prove + self.fall_back


@dataclass(frozen=True, eq=False)
class Answers:
    """One answer a template, on the original data; arrays are read-only.

    Attributes
    ----------
    projection : Projection
        The data; it refers to the templates as given.
    lambdas : (float, float, float)
    w : float64 (p, n)
    modality_norms : float64 (p, m)
        ||u^i||_2, to rounding.
    lower, upper, gap : float64 (p,)
        lower <= F* <= upper and F(w, u) - F* <= gap, proved.
    zero_views : bool (p, n)
        True where w*_j = 0 is proved of every optimal w*.
    zero_modalities : bool (p, m)
        True where u*^i = 0 is proved of every optimal u*.
    batch : Batch
        The reduced answers, normalised, from which u is recovered.
    singles : mapping of int to Solution
        Templates that the reduced data could not certify, or that a named solver answered, one by one.
    relative_tolerance, absolute_tolerance : float
        See `convexperc.certificate.certificate.Certificate`.
    stages : Stages
    """

    projection: Projection
    lambdas: tuple[float, float, float]
    w: Float[np.ndarray, "p n"]
    modality_norms: Float[np.ndarray, "p m"]
    lower: Float[np.ndarray, " p"]
    upper: Float[np.ndarray, " p"]
    gap: Float[np.ndarray, " p"]
    zero_views: Bool[np.ndarray, "p n"]
    zero_modalities: Bool[np.ndarray, "p m"]
    batch: Batch
    singles: Mapping[int, Solution]
    relative_tolerance: float
    absolute_tolerance: float
    stages: Stages = field(repr=False)

    def __post_init__(self) -> None:
        self._freeze()

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._freeze()

    def _freeze(self) -> None:
        for value in self.__dict__.values():
            if isinstance(value, np.ndarray):
                value.flags.writeable = False

    def __len__(self) -> int:
        return self.lower.size

    @property
    def iterations(self) -> Int[np.ndarray, " p"]:
        """Steps of the solver on each template."""
        counts = self.batch.iterations.copy()
        for j, solution in self.singles.items():
            counts[j] = solution.iterations
        return np.asarray(counts)

    @cached_property
    def certified(self) -> Bool[np.ndarray, " p"]:
        """Whether the gap of (w, u) is within the tolerances."""
        close = self._within(self.gap)
        for j, solution in self.singles.items():
            close[j] = solution.certificate.certified
        close.flags.writeable = False
        return close

    @cached_property
    def enclosed(self) -> Bool[np.ndarray, " p"]:
        """Whether [lower, upper] is as narrow as the tolerances ask, whatever the point is."""
        close = np.asarray(self.certified | self._within(self.upper - self.lower))
        for j, solution in self.singles.items():
            close[j] = solution.certificate.enclosed
        close.flags.writeable = False
        return close

    def _within(self, gaps: Float[np.ndarray, " p"]) -> Bool[np.ndarray, " p"]:
        tolerances = self.relative_tolerance, self.absolute_tolerance
        return within(gaps, self.lower, self.projection.squares[0], tolerances)

    def status(self, j: int) -> Status:
        """What is known of template j."""
        if self.certified[j]:
            return Status.CERTIFIED
        return Status.ENCLOSED if self.enclosed[j] else Status.NOT_CERTIFIED

    def problem(self, j: int) -> Problem:
        """Template j's problem as given."""
        return self.projection.problem(j, self.lambdas)

    def u(self, j: int) -> FeatureVector:
        """Recover the feature weights of template j: u^i = t_i X_i' q."""
        if j in self.singles:
            return self.singles[j].u
        data = self.projection
        u = data.reduction.recover(self.batch.T[j], self.batch.Q[j])
        return np.asarray(np.ldexp(u, int(data.exponents[j]) - 3 * data.x))

    def solution(self, j: int) -> Solution:
        """Template j's answer with a certificate of its own on the original data.

        One that was excluded before it was certified is solved now.
        """
        if j in self.singles:
            return self.singles[j]
        problem = self.problem(j)
        return solve(
            problem,
            _Known(self, j, problem) if self.certified[j] else None,
            escalate=True,
            relative_tolerance=self.relative_tolerance,
            absolute_tolerance=self.absolute_tolerance,
        )


def within(
    gaps: Float[np.ndarray, " p"],
    lower: Float[np.ndarray, " p"],
    target: Float[np.ndarray, " p"],
    tolerances: tuple[float, float],
) -> Bool[np.ndarray, " p"]:
    """Whether each gap is at most a share of the lower bound of F*, or of that of ||o||^2."""
    relative, absolute = tolerances
    return np.asarray((gaps <= relative * lower) | (gaps <= absolute * target))


@dataclass(frozen=True, eq=False)
class _Known:
    """A solver that knows one answer already."""

    answers: Answers
    j: int
    problem: Problem

    @property
    def name(self) -> str:
        return Newton().name

    def solve(self, problem: Problem) -> SolverResult:
        """The answer, in the units of the normalised problem."""
        scaling, found = Scaling.of(self.problem), self.answers
        w, u = scaling.point(np.array(found.w[self.j]), found.u(self.j))
        shift = int(found.projection.exponents[self.j]) + found.projection.x - scaling.x - scaling.o
        b = np.ldexp(-2.0 * found.batch.Q[self.j], shift)
        if is_lasso(found.lambdas):
            b[:] = 0.0
        dual = 2.0 * (problem.X.T @ w - problem.o), b
        return SolverResult(w, u, "stopped", int(found.batch.iterations[self.j]), dual)
