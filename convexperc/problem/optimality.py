"""How far a point is from stationarity, block by block (KKT residual)."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from convexperc.errors import ProblemError, check_type
from convexperc.problem.arrays import FeatureVector, Vector, point_entries
from convexperc.problem.formulation import residuals
from convexperc.problem.problem import Problem


@dataclass(frozen=True, eq=False)
class OptimalityResidual:
    """Distance of 0 from the subdifferential of F, by block, in the units of F / w and F / u.

    Attributes
    ----------
    views : float64 (n,)
        |g_j + lambda2 sign(w_j)| where w_j is not 0, else (|g_j| - lambda2)+, with g = X a - b.
    modalities : float64 (m,)
        ||X_i'b + lambda3 u^i / ||u^i|| || where u^i is not 0, else (||X_i'b|| - lambda3)+.
    """

    views: Vector
    modalities: NDArray[np.float64]

    @property
    def worst(self) -> float:
        """The largest residual of all blocks."""
        return float(max(self.views.max(), self.modalities.max()))


def optimality_residual(problem: Problem, w: Any, u: Any) -> OptimalityResidual:
    """Evaluate the KKT residual of (w, u).

    Parameters
    ----------
    problem : Problem
    w : array_like (n,)
    u : array_like (d,)

    Returns
    -------
    OptimalityResidual
        All zero exactly at the optima of F.

    Raises
    ------
    PointError
        Entries that are not finite real numbers, or a wrong shape.

    Notes
    -----
    With a = 2(X'w - o) and b = 2 lambda1 (Xu - w). This is the condition that the paper's derivative
    equations miss by the absolute value and by a factor of 2. A small residual is no proof: `certify` is.
    """
    check_type(problem, Problem, "problem", ProblemError)
    weights = point_entries(w, problem.n, "w", finite=True)
    features = point_entries(u, problem.d, "u", finite=True)
    p, q = residuals(problem, weights, features)
    b = 2.0 * problem.lambda1 * q
    pull = problem.X @ (2.0 * p) - b
    at_zero = np.maximum(np.abs(pull) - problem.lambda2, 0.0)
    views = np.where(weights == 0.0, at_zero, np.abs(pull + problem.lambda2 * np.sign(weights)))
    return OptimalityResidual(views, _modalities(problem, features, problem.X.T @ b))


def _modalities(problem: Problem, u: FeatureVector, Xb: FeatureVector) -> NDArray[np.float64]:
    """The residual of each modality."""
    lengths = problem.modalities.norms(u)
    found = np.empty(problem.m)
    for i, (columns, length) in enumerate(zip(problem.modalities, lengths, strict=True)):
        if length == 0.0:
            found[i] = max(0.0, float(np.linalg.norm(Xb[columns])) - problem.lambda3)
        else:
            found[i] = np.linalg.norm(Xb[columns] + problem.lambda3 * (u[columns] / length))
    return found
