"""The reference solver: Eq. (full) posed directly in CVXPY and solved by Clarabel."""

import threading
from collections import OrderedDict
from dataclasses import dataclass, field
from typing import Any

import cvxpy as cp
import numpy as np

from convexperc.errors import SolverError
from convexperc.problem.problem import Problem
from convexperc.solvers.interface import SolverResult


@dataclass(frozen=True, eq=False)
class Model:
    """Eq. (full) in CVXPY with o and the lambdas as parameters (DPP): one compiled model for every template.

    Attributes
    ----------
    problem : cvxpy.Problem
    w, u : cvxpy.Variable, (n,) and (d,)
    o : cvxpy.Parameter, (d,)
    lambda1, lambda2, lambda3 : cvxpy.Parameter
        Scalars >= 0.
    """

    problem: Any
    w: Any
    u: Any
    o: Any
    lambda1: Any
    lambda2: Any
    lambda3: Any

    @classmethod
    def of(cls, problem: Problem) -> "Model":
        """Pose the problem, term by term as `convexperc.problem.problem.Problem` states it."""
        X = problem.X
        w, u, o = cp.Variable(problem.n), cp.Variable(problem.d), cp.Parameter(problem.d)
        lambda1, lambda2, lambda3 = (cp.Parameter(nonneg=True) for _ in range(3))
        objective = (
            cp.sum_squares(X.T @ w - o)
            + lambda1 * cp.sum_squares(X @ u - w)
            + lambda2 * cp.norm1(w)
            + lambda3 * sum(cp.norm2(u[columns]) for columns in problem.modalities)
        )
        return cls(cp.Problem(cp.Minimize(objective)), w, u, o, lambda1, lambda2, lambda3)

    def assign(self, problem: Problem) -> None:
        """Set the parameters to the data of one template."""
        self.o.value = problem.o
        self.lambda1.value, self.lambda2.value, self.lambda3.value = problem.lambdas


class ModelCache:
    """The most recently used compiled models, by X and partition."""

    def __init__(self, size: int = 4) -> None:
        self._size = size
        self._models: OrderedDict[tuple[Any, ...], Model] = OrderedDict()
        self.lock = threading.Lock()

    def __reduce__(self) -> tuple[type["ModelCache"], tuple[int]]:
        """Pickle without the models: compiled CVXPY problems cannot be pickled."""
        return ModelCache, (self._size,)

    def model(self, problem: Problem) -> Model:
        """Return the model compiled for this X and partition, compiling it if necessary."""
        columns = tuple(np.r_[c].tobytes() for c in problem.modalities)
        key = problem.X.shape, problem.X.tobytes(), columns
        if key not in self._models:
            self._models[key] = Model.of(problem)
        self._models.move_to_end(key)
        while len(self._models) > self._size:
            self._models.popitem(last=False)
        return self._models[key]


@dataclass(frozen=True)
class Conic:
    """CVXPY + Clarabel, with tolerances near the limit of float64.

    Attributes
    ----------
    tolerance : float
        Clarabel's tol_gap_abs, tol_gap_rel and tol_feas. Much below the default it stops for insufficient
        progress, at a worse point.
    regularisation : float
        Clarabel's static regularisation; with its default, 1e-8, one answer in ten stays above a relative
        gap of 1e-8.
    refinements : int
        Largest number of steps of iterative refinement for each linear system.
    max_iterations : int
        Of the interior point method.
    time_limit : float
        Seconds after which Clarabel returns the point that it has; the status says so.
    """

    tolerance: float = 1e-12
    regularisation: float = 1e-12
    refinements: int = 50
    max_iterations: int = 400
    time_limit: float = 600.0
    _cache: ModelCache = field(default_factory=ModelCache, compare=False, repr=False)

    @property
    def name(self) -> str:
        """Short name, for reports."""
        return "cvxpy+clarabel"

    def solve(self, problem: Problem) -> SolverResult:
        """Answer one normalised problem.

        Raises
        ------
        SolverError
            CVXPY or Clarabel raised, or returned no point.
        """
        with self._cache.lock:
            model = self._cache.model(problem)
            model.assign(problem)
            found, late = self._solve(model)
        w, u = (found.primal_vars.get(variable.id) for variable in (model.w, model.u))
        if w is None or u is None:
            remedy = "Normalise the problem (convexperc.solve does) or choose another solver."
            raise SolverError("Clarabel", value=found.status, must="must return a point", remedy=remedy)
        status, iterations = str(found.status), int(found.attr.get("num_iters") or 0)
        if late:
            status = f"{status}; the time limit of {self.time_limit:g} s is reached"
        return SolverResult(np.array(w, dtype=np.float64), np.array(u, dtype=np.float64), status, iterations)

    def _solve(self, model: Model) -> tuple[Any, bool]:
        """CVXPY's solution, and whether the time ended the search for it.

        Step by step, since `cvxpy.Problem.solve` warns, and would start where it was before. A warning can be
        silenced for the whole process only, whatever its other threads ask.
        """
        options = {
            "tol_gap_abs": self.tolerance,
            "tol_gap_rel": self.tolerance,
            "tol_feas": self.tolerance,
            "max_iter": self.max_iterations,
            "time_limit": self.time_limit,
            "static_regularization_constant": self.regularisation,
            "iterative_refinement_max_iter": self.refinements,
            "iterative_refinement_reltol": 1e-15,
            "iterative_refinement_abstol": 1e-15,
        }
        try:
            data, chain, inverse = model.problem.get_problem_data(cp.CLARABEL, solver_opts=dict(options))
            raw = chain.solve_via_data(model.problem, data, warm_start=False, solver_opts=dict(options))
            found = chain.invert(raw, inverse)
        except (cp.error.SolverError, ValueError, ArithmeticError) as problem:
            raise _failed(str(problem)) from problem
        if found.status in cp.settings.ERROR:
            raise _failed(str(found.status))
        return found, str(raw.status) == "MaxTime"


def _failed(reason: str) -> SolverError:
    remedy = "Choose another solver; the problem itself is convex and has an optimum."
    return SolverError("Clarabel", value=reason, must="must not fail", remedy=remedy)
