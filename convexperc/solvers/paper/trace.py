"""The trace of Algorithm 1: its iterates, the values of F, and why the loop ended."""

from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

import numpy as np
from jaxtyping import Float, Int

from convexperc.errors import InputError
from convexperc.problem.arrays import FeatureVector, Vector, nonnegative_number
from convexperc.problem.formulation import objective, residuals
from convexperc.problem.problem import Problem
from convexperc.solvers.paper.systems import MACHINE_EPSILON, LinearSolver
from convexperc.solvers.paper.variants import Order, UpdateVariant

RISE_ROUNDING = 1e-12
"""An increase of F below this fraction of max(F(start), ||o||^2) is rounding: F is a sum of n + d terms, each
with a relative error of about 1e-16."""

DIVERGENCE_FACTOR = 1e12
"""F above this multiple of max(F(start), ||o||^2) counts as divergence: too few of the 16 digits are left to
recover from it."""

LOCK_SLACK = 100.0
"""The optimality condition at a zero counts as violated beyond this many tolerances: the limit itself has an
error of some tolerances."""

Point = tuple[Vector, FeatureVector]


class Stop(StrEnum):
    """Why the loop ended.

    ``converged``: the steps are small. ``locked_at_zero``: the steps are small, but a coordinate or block is
    exactly 0 although its optimality condition fails, so that the limit is not the optimum. ``singular``: a
    system has no unique solution. ``diverged``: not finite, or F grew by `DIVERGENCE_FACTOR`.
    ``iteration_limit``: none of these within the largest number of iterations.
    """

    CONVERGED = "converged"
    LOCKED_AT_ZERO = "locked_at_zero"
    SINGULAR = "singular"
    DIVERGED = "diverged"
    ITERATION_LIMIT = "iteration_limit"


@dataclass(frozen=True, eq=False)
class PaperTrace:
    """The record of one run of Algorithm 1; every array is read-only.

    Attributes
    ----------
    variant : UpdateVariant
        With its eps made explicit.
    order : Order
    linear_solver : LinearSolver
    stop : Stop
        Why it ended.
    w : float64 (n,)
        The last complete iterate.
    u : float64 (d,)
        The last complete iterate.
    F : float64 (k + 1,)
        F at the start and after each of the k iterations.
    own : float64 (k + 1,) or (0,)
        The objective that the variant descends, at the same points; empty if it has none.
    steps : float64 (k, 2)
        Relative change of w and of u in each iteration.
    path_w : float64 (k + 1, n) or (0, n)
        Every w, with ``keep_iterates``.
    path_u : float64 (k + 1, d) or (0, d)
        Every u, with ``keep_iterates``.
    scale : float
        max(F(start), ||o||^2), the scale of rounding errors.
    locked_views, locked_modalities : tuple of int
        Exact zeros of the last iterate that no update changes although their optimality condition fails.
    """

    variant: UpdateVariant
    order: Order
    linear_solver: LinearSolver
    stop: Stop
    w: Vector
    u: FeatureVector
    F: Float[np.ndarray, " k1"]
    own: Float[np.ndarray, " own"]
    steps: Float[np.ndarray, "k 2"]
    path_w: Float[np.ndarray, "path n"]
    path_u: Float[np.ndarray, "path d"]
    scale: float
    locked_views: tuple[int, ...]
    locked_modalities: tuple[int, ...]

    def __post_init__(self) -> None:
        for array in (self.w, self.u, self.F, self.own, self.steps, self.path_w, self.path_u):
            array.flags.writeable = False

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self.__post_init__()

    @property
    def iterations(self) -> int:
        """Number of complete iterations, k."""
        return len(self.F) - 1

    def rises(self, tolerance: float = RISE_ROUNDING) -> Int[np.ndarray, " rises"]:
        """Return each i >= 1 with F(i) > F(i-1) + tolerance max(F(start), ||o||^2).

        The allowance covers the rounding of F, not that of the systems, which are normal equations and have
        larger errors on data scaled over many orders of magnitude. Confirm small rises in exact arithmetic.
        """
        return _rises(self.F, tolerance * self.scale)

    def own_rises(self, tolerance: float = RISE_ROUNDING) -> Int[np.ndarray, " rises"]:
        """Return the same for the objective of the variant itself; none if it has no objective."""
        return _rises(self.own, tolerance * self.scale)


@dataclass
class Log:
    """The run so far, and its stopping rule; the last complete and finite iterate is the result.

    Attributes
    ----------
    problem : Problem
    variant : UpdateVariant
        With its eps made explicit.
    tolerance : float
        Relative, of the convergence test; see `convexperc.solvers.paper.run`.
    max_iterations : int
    keep_iterates : bool
        Whether `points` holds every iterate, or only the last.
    stop : Stop or None
        None while the loop runs.
    points : list of (w, u)
        Of shapes (n,) and (d,).
    F : list of float
        F at the start and after each complete iteration.
    own : list of float
        The variant's own objective at the same points; empty if it has none.
    steps : list of (float, float)
        Relative change of w and of u in each iteration.
    """

    problem: Problem
    variant: UpdateVariant
    tolerance: float
    max_iterations: Any
    keep_iterates: bool
    stop: Stop | None = None
    points: list[Point] = field(default_factory=list)
    F: list[float] = field(default_factory=list)
    own: list[float] = field(default_factory=list)
    steps: list[tuple[float, float]] = field(default_factory=list)

    def __post_init__(self) -> None:
        nonnegative_number(self.tolerance, "tolerance", error=InputError)
        count = self.max_iterations
        if isinstance(count, bool) or not isinstance(count, (int, np.integer)) or count < 0:
            raise InputError("max_iterations", value=count, must="must be an integer >= 0")

    @property
    def scale(self) -> float:
        """max(F(start), ||o||^2), as in `PaperTrace`."""
        return max(self.F[0], float(self.problem.o @ self.problem.o))

    def add(self, w: Vector, u: FeatureVector) -> None:
        """Record the start or an iterate, and decide whether to stop."""
        value = objective(self.problem, w, u)
        if self.points and not (np.isfinite(value) and np.isfinite(w).all() and np.isfinite(u).all()):
            self.stop = Stop.DIVERGED
            return
        self.F.append(value)
        if self.variant.own:
            self.own.append(self.variant.own_objective(self.problem, w, u))
        settled = bool(self.points) and self._settled(w, u)
        if not self.keep_iterates:
            self.points.clear()
        self.points.append((w, u))
        if value > DIVERGENCE_FACTOR * self.scale:
            self.stop = Stop.DIVERGED
        elif settled:
            self.stop = Stop.CONVERGED
        elif len(self.steps) >= self.max_iterations:
            self.stop = Stop.ITERATION_LIMIT

    def _settled(self, w: Vector, u: FeatureVector) -> bool:
        """Whether the steps are small and no penalised size still grows."""
        before_w, before_u = self.points[-1]
        self.steps.append((_change(before_w, w), _change(before_u, u)))
        if max(self.steps[-1]) > self.tolerance:
            return False
        before, after = self._sizes(before_w, before_u), self._sizes(w, u)
        return bool((after <= (1.0 + self.tolerance) * before).all())

    def _sizes(self, w: Vector, u: FeatureVector) -> Float[np.ndarray, " sizes"]:
        views = np.abs(self.variant.view_diagonal(w).sizes) * (self.problem.lambda2 > 0.0)
        modalities = self.variant.modality_diagonal(u, self.problem.modalities).sizes
        return np.concatenate([views, modalities * (self.problem.lambda3 > 0.0)])

    def trace(self, order: Order, linear_solver: LinearSolver) -> PaperTrace:
        """Return the finished run; convergence to a locked zero is reported as `Stop.LOCKED_AT_ZERO`."""
        w, u = self.points[-1]
        views, modalities = _locked(self.problem, self.variant, self.tolerance, w, u)
        stop = Stop.ITERATION_LIMIT if self.stop is None else self.stop
        path = self.points if self.keep_iterates else []
        return PaperTrace(
            variant=self.variant,
            order=order,
            linear_solver=linear_solver,
            stop=Stop.LOCKED_AT_ZERO if stop is Stop.CONVERGED and (views or modalities) else stop,
            w=w,
            u=u,
            F=np.array(self.F),
            own=np.array(self.own),
            steps=np.array(self.steps).reshape(-1, 2),
            path_w=np.array([point[0] for point in path]).reshape(-1, self.problem.n),
            path_u=np.array([point[1] for point in path]).reshape(-1, self.problem.d),
            scale=self.scale,
            locked_views=views,
            locked_modalities=modalities,
        )


def _locked(
    problem: Problem, variant: UpdateVariant, tolerance: float, w: Vector, u: FeatureVector
) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Return the exact zeros that the updates keep, although |Xa - b|_j > lambda2 or ||X_i'b|| > lambda3.

    a = 2(X'w - o), b = 2 lambda1 (Xu - w); the lambdas are those of the objective that the variant descends
    (lambda2/2 and lambda3/2 for `ABSOLUTE`), or of F if there is none.
    """
    factor = variant.factor if variant.own else 1.0
    lambda2, lambda3 = factor * problem.lambda2, factor * problem.lambda3
    p, q = residuals(problem, w, u)
    a, b = 2.0 * p, 2.0 * problem.lambda1 * q
    slack = LOCK_SLACK * max(tolerance, MACHINE_EPSILON)
    error_a = slack * 2.0 * (np.linalg.norm(p) + 2.0 * np.linalg.norm(problem.o))
    error_b = slack * 2.0 * problem.lambda1 * (np.linalg.norm(q) + 2.0 * np.linalg.norm(w))
    allowed = (1.0 + slack) * lambda2 + np.linalg.norm(problem.X, axis=1) * error_a + error_b
    held = np.isinf(variant.view_diagonal(w).times(lambda2))
    views = np.flatnonzero(held & (np.abs(problem.X @ a - b) > allowed))
    still = np.isinf(variant.modality_diagonal(u, problem.modalities).times(lambda3))
    modalities = [
        i
        for i, (columns, block) in enumerate(zip(problem.modalities, problem.blocks(), strict=True))
        if still[columns].all()
        and np.linalg.norm(block.T @ b) > (1.0 + slack) * lambda3 + np.linalg.norm(block) * error_b
    ]
    return tuple(views.tolist()), tuple(modalities)


def _change(before: Float[np.ndarray, " k"], after: Float[np.ndarray, " k"]) -> float:
    """Return ||after - before|| relative to the larger of the two norms; 0 between two zeros."""
    largest = max(np.linalg.norm(before), np.linalg.norm(after))
    return float(np.linalg.norm(after - before) / largest) if largest > 0.0 else 0.0


def _rises(values: Float[np.ndarray, " k"], allowance: float) -> Int[np.ndarray, " rises"]:
    return np.flatnonzero(np.diff(values) > allowance) + 1
