"""Solvers as the kit asks them: ``conform --module verification.conformance.adapters:NAME``.

`library` and `exact` are the kit's own controls; the others are solvers that people use, at their default
settings unless their name says otherwise, and the paper's algorithm by each interpretation of its update.
"""

from collections.abc import Callable, Sequence
from importlib import import_module
from typing import Any

import numpy as np

from convexperc.enclosure.enclosure import enclose
from convexperc.problem.problem import Problem
from convexperc.solution.single import solve as certified
from convexperc.solvers.paper.loop import run
from verification.exact.formulation import objective

ITERATIONS = 500
"""Most iterations of the paper's algorithm."""

Point = dict[str, Any]
Solve = Callable[..., Any]


def library(X: Any, o: Any, modalities: Sequence[int], **weights: float) -> Point:
    """`convexperc.solve`, as it answers by default."""
    found = certified(Problem(X, o, modalities=list(modalities), **weights))
    return {"w": found.w, "u": found.u, "objective": found.value}


def exact(X: Any, o: Any, modalities: Sequence[int], **weights: float) -> Point:
    """Newton's method in ball arithmetic of 128 bits or more.

    Its point is rounded to float64; where that makes F larger than at the point of `convexperc.solve`, as
    it does where views are almost equal and no weight holds them, the latter is the answer.
    """
    problem = Problem(X, o, modalities=list(modalities), **weights)
    found, other = enclose(problem), certified(problem)
    points = (found.w, found.u), (other.w, other.u)
    w, u = min(points, key=lambda point: objective(problem, *point).upper)
    return {"w": w, "u": u, "objective": found.upper}


def _cvxpy(solver: str, **settings: Any) -> Solve:
    def solve(X: Any, o: Any, modalities: Sequence[int], **weights: float) -> Point:
        import cvxpy as cp  # noqa: PLC0415

        problem = Problem(X, o, modalities=list(modalities), **weights)
        w, u = cp.Variable(problem.n), cp.Variable(problem.d)
        norms = cp.norm1 if solver == "OSQP" else cp.norm2
        if solver == "OSQP" and problem.lambda3 and any(size > 1 for size in problem.modalities.sizes):
            raise NotImplementedError(
                "OSQP solves quadratic programs: modalities of one column, or lambda3 = 0"
            )
        F = (
            cp.sum_squares(problem.X.T @ w - problem.o)
            + problem.lambda1 * cp.sum_squares(problem.X @ u - w)
            + problem.lambda2 * cp.norm1(w)
            + problem.lambda3 * sum(norms(u[columns]) for columns in problem.modalities)
        )
        posed = cp.Problem(cp.Minimize(F))
        posed.solve(solver=solver, **settings)
        if w.value is None or u.value is None:
            raise ArithmeticError(f"status {posed.status}")
        return {"w": w.value, "u": u.value, "objective": posed.value}

    return solve


cvxpy_clarabel = _cvxpy("CLARABEL")
cvxpy_scs = _cvxpy("SCS")
cvxpy_scs_tight = _cvxpy("SCS", eps_abs=1e-10, eps_rel=1e-10, max_iters=200_000)
cvxpy_osqp = _cvxpy("OSQP")
cvxpy_osqp_tight = _cvxpy("OSQP", eps_abs=1e-10, eps_rel=1e-10, max_iter=200_000)
cvxpy_qoco = _cvxpy("QOCO")


def _paper(reading: str) -> Solve:
    def solve(X: Any, o: Any, modalities: Sequence[int], **weights: float) -> Point:
        problem = Problem(X, o, modalities=list(modalities), **weights)
        found = run(problem, variant=reading, max_iterations=ITERATIONS)
        return {"w": found.w, "u": found.u, "objective": found.F[-1], "trace": found.F}

    return solve


paper_printed = _paper("printed")
paper_absolute = _paper("absolute")
paper_corrected = _paper("corrected")
paper_smoothed = _paper("smoothed")


def _lasso(package: str, **settings: Any) -> Solve:
    """A lasso solver: for lambda1 = 0 u = 0 is optimal, and w minimises ||X'w - o||^2 + lambda2 ||w||_1."""

    def solve(X: Any, o: Any, modalities: Sequence[int], **weights: float) -> Point:
        problem = Problem(X, o, modalities=list(modalities), **weights)
        if problem.lambda1 or not problem.lambda2:
            raise NotImplementedError("a lasso: lambda1 = 0 and lambda2 > 0")
        kind = import_module(package).Lasso
        lasso = kind(alpha=problem.lambda2 / (2.0 * problem.d), fit_intercept=False, **settings)
        w = lasso.fit(np.asfortranarray(problem.X.T), problem.o).coef_
        return {"w": w, "u": np.zeros(problem.d)}

    return solve


sklearn_lasso = _lasso("sklearn.linear_model")
sklearn_lasso_tight = _lasso("sklearn.linear_model", tol=1e-14, max_iter=1_000_000)
celer_lasso = _lasso("celer")
celer_lasso_tight = _lasso("celer", tol=1e-14, max_iter=1000, max_epochs=1_000_000)
skglm_lasso = _lasso("skglm")
skglm_lasso_tight = _lasso("skglm", tol=1e-10)
"""Not 1e-12: on near-duplicates-without-lambdas-11 rounding keeps its criterion at 1.3e-12."""
