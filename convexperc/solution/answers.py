"""The answers to all templates of one set of views, with what is proved of each; u only on demand."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeVar

import numpy as np
from jaxtyping import Bool, Float, Int

from convexperc.caching import cached_property
from convexperc.certificate.cases import AnswerBounds
from convexperc.certificate.data_bounds import DataBounds
from convexperc.certificate.tolerances import Tolerances
from convexperc.enclosure.budget import Budget
from convexperc.errors import InputError, is_integer
from convexperc.problem.arrays import FeatureVector
from convexperc.problem.penalties import Penalties
from convexperc.problem.problem import Problem
from convexperc.problem.reduced import ReducedData
from convexperc.problem.scaling import Scaling
from convexperc.solution.single import certified, solve
from convexperc.solution.solution import Solution, Status, Timings
from convexperc.solvers.interface import SolverResult
from convexperc.solvers.newton.method import Batch, Newton

Found = TypeVar("Found", bound=np.ndarray)


@dataclass(frozen=True)
class Stages:
    """Wall-clock seconds of each stage, all templates together.

    Attributes
    ----------
    read : float
        The Gram matrices, X O and the lengths: one pass over the data, shared by all answers of a path.
    solve : float
        Solving, and the bounds of every answer, from the reduced data.
    fall_back : float
        The templates that this did not certify, one by one on the original data.
    """

    read: float
    solve: float
    fall_back: float

    @property
    def total(self) -> float:
        """Seconds in all."""
        return self.read + self.solve + self.fall_back


@dataclass(frozen=True, eq=False)
class Answers:
    """One answer a template, on the original data; arrays are read-only.

    Attributes
    ----------
    bounds : DataBounds
        The data with bounds of their rounding; it refers to the templates as given.
    penalties : Penalties
    tolerances : Tolerances
    lower, upper, gap : float64 (p,)
        lower <= F* <= upper and F(w, u) - F* <= gap, proved.
    reduced : Batch
        The reduced answers, normalised, from which w and u are recovered.
    proved : AnswerBounds
        What is proved of the reduced answers, normalised.
    singles : mapping of int to Solution
        Templates that the reduced data could not certify, or that a named solver answered, one by one.
    stages : Stages
    """

    bounds: DataBounds
    penalties: Penalties
    tolerances: Tolerances
    lower: Float[np.ndarray, " p"]
    upper: Float[np.ndarray, " p"]
    gap: Float[np.ndarray, " p"]
    reduced: Batch
    proved: AnswerBounds
    singles: Mapping[int, Solution]
    stages: Stages = field(repr=False)

    def __post_init__(self) -> None:
        for bound in (self.lower, self.upper, self.gap):
            bound.setflags(write=False)

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        for value in (*state.values(), *self.proved, *vars(self.reduced).values()):
            if isinstance(value, np.ndarray):
                value.flags.writeable = False

    def __len__(self) -> int:
        return self.lower.size

    @property
    def data(self) -> ReducedData:
        """The views and the templates."""
        return self.bounds.data

    @property
    def relative_tolerance(self) -> float:
        """Largest share of F* that the gap of a certified answer may be."""
        return self.tolerances.relative

    @property
    def absolute_tolerance(self) -> float:
        """Largest share of ||o||^2 that the gap of a certified answer may be."""
        return self.tolerances.absolute

    @property
    def lambdas(self) -> tuple[float, float, float]:
        """(lambda1, lambda2, lambda3)."""
        one, two, three = self.penalties
        return one, two, three

    @cached_property
    def w(self) -> Float[np.ndarray, "p n"]:
        """Weights of the views."""
        found = self.reduced.W / (self.data.library.lengths.inverses * math.ldexp(1.0, self.data.x))[:, None]
        return completed(found, self.singles, lambda single: single.w)

    @cached_property
    def modality_norms(self) -> Float[np.ndarray, "p m"]:
        """||u^i||_2, to rounding."""
        found = np.ldexp(self.proved.modality_norms, self.data.exponents[:, None] - 2 * self.data.x)
        return completed(found, self.singles, lambda single: single.modality_norms)

    @cached_property
    def zero_views(self) -> Bool[np.ndarray, "p n"]:
        """True where w*_j = 0 is proved of every optimal w*."""
        found = self.proved.zero_views.copy()
        return completed(found, self.singles, lambda single: single.certificate.zero_views)

    @cached_property
    def zero_modalities(self) -> Bool[np.ndarray, "p m"]:
        """True where u*^i = 0 is proved of every optimal u*."""
        found = self.proved.zero_modalities.copy()
        return completed(found, self.singles, lambda single: single.certificate.zero_modalities)

    @cached_property
    def iterations(self) -> Int[np.ndarray, " p"]:
        """Steps of the solver on each template."""
        return completed(self.reduced.iterations.copy(), self.singles, lambda single: single.iterations)

    @cached_property
    def certified(self) -> Bool[np.ndarray, " p"]:
        """Whether the gap of (w, u) is within the tolerances."""
        return certified_gaps(self.gap, self.lower, self.bounds, self.tolerances, self.singles)

    @cached_property
    def enclosed(self) -> Bool[np.ndarray, " p"]:
        """Whether [lower, upper] is as narrow as the tolerances ask, whatever the point is."""
        width = np.where(self.upper > self.lower, np.nextafter(self.upper - self.lower, np.inf), 0.0)
        narrow = self.tolerances.met(width, self.lower, self.bounds.squares[0])
        found = np.asarray(self.certified | narrow)
        return completed(found, self.singles, lambda single: single.certificate.enclosed)

    def status(self, j: int) -> Status:
        """What is known of template j."""
        self._check(j)
        if self.certified[j]:
            return Status.CERTIFIED
        return Status.ENCLOSED if self.enclosed[j] else Status.NOT_CERTIFIED

    def problem(self, j: int) -> Problem:
        """Template j's problem as given."""
        self._check(j)
        return self.data.problem(j, self.penalties)

    def u(self, j: int) -> FeatureVector:
        """Recover the feature weights of template j: u^i = t_i X_i' q."""
        self._check(j)
        if j in self.singles:
            return self.singles[j].u
        unit = math.ldexp(1.0, int(self.data.exponents[j]) - 3 * self.data.x)
        return self.data.views.reduction.recover(self.reduced.T[j], self.reduced.Q[j], unit)

    def solution(self, j: int) -> Solution:
        """Template j's answer with a certificate of its own on the original data.

        One that was excluded before it was certified is solved now.
        """
        self._check(j)
        if j in self.singles:
            return self.singles[j]
        problem = self.problem(j)
        if not self.certified[j]:
            relative, absolute = self.tolerances.relative, self.tolerances.absolute
            return solve(problem, relative_tolerance=relative, absolute_tolerance=absolute)
        scaling = Scaling.of(problem)
        shared = problem.views.normalised  # held, so that it is made once
        found = certified(
            problem, scaling, Newton().name, self._result(j, problem, scaling), self.tolerances, Budget(),
            timings=Timings(0.0, 0.0, 0.0),
        )  # fmt: skip
        del shared
        return found

    def _check(self, j: int) -> None:
        """Refuse what is no template; one counted from the end would be missed in `singles`."""
        if not is_integer(j) or not 0 <= j < self.data.p:
            raise InputError("template", value=j, must=f"must be an integer from 0 to {self.data.p - 1}")

    def _result(self, j: int, problem: Problem, scaling: Scaling) -> SolverResult:
        """The reduced answer to template j as the solver's result, in units of the scaling."""
        w, u = scaling.point(np.array(self.w[j]), self.u(j))
        X, o, _ = scaling.data(problem)
        b = np.zeros(self.data.n)
        if not self.penalties.uncoupled:
            batch = self.data.scaling(j)
            b = np.ldexp(-2.0 * self.reduced.Q[j], batch.x + batch.o - scaling.x - scaling.o)
        status = self.reduced.status(j, self.tolerances.relative, Newton().max_iterations)
        return SolverResult(w, u, status, int(self.reduced.iterations[j]), (2.0 * (X.T @ w - o), b))


def certified_gaps(
    gap: Float[np.ndarray, " p"],
    lower: Float[np.ndarray, " p"],
    bounds: DataBounds,
    tolerances: Tolerances,
    singles: Mapping[int, Solution],
) -> Bool[np.ndarray, " p"]:
    """Whether each gap is within the tolerances; the certificate tells for an answer on the original data."""
    found = np.asarray(tolerances.met(gap, lower, bounds.squares[0]))
    return completed(found, singles, lambda single: single.certificate.certified)


def completed(found: Found, singles: Mapping[int, Solution], of: Callable[[Solution], Any]) -> Found:
    """The same array, read-only, with the rows of the templates that were answered on the original data."""
    for j, single in singles.items():
        found[j] = of(single)
    found.setflags(write=False)
    return found
