"""What a user gets without this library: Eq. (full) posed directly in CVXPY, Clarabel at default settings."""

import math
import warnings
from dataclasses import dataclass

import cvxpy as cp

from convexperc.problem.problem import Problem


@dataclass(frozen=True)
class Raw:
    """What came back.

    Attributes
    ----------
    status : str
        CVXPY's status, or the exception's name.
    value : float or None
        CVXPY's optimal value, if it is a finite number.
    """

    status: str
    value: float | None

    @property
    def optimal(self) -> bool:
        """Whether CVXPY claims an optimum without reservation."""
        return self.status == cp.OPTIMAL and self.value is not None

    @property
    def inaccurate(self) -> bool:
        """Whether CVXPY claims an optimum that may be inaccurate."""
        return self.status == cp.OPTIMAL_INACCURATE and self.value is not None

    def distance(self, lower: float, upper: float) -> float:
        """How far the value lies outside [lower, upper], relative to F*; 0 inside, infinite from F* = 0."""
        if self.value is None or lower <= self.value <= upper:
            return 0.0
        bound = upper if self.value > upper else lower
        away = abs(self.value - bound)
        return away / bound if bound > 0.0 else math.inf


def raw(problem: Problem) -> Raw:
    """Solve without normalisation; every failure is a status."""
    w, u = cp.Variable(problem.n), cp.Variable(problem.d)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            objective = (
                cp.sum_squares(problem.X.T @ w - problem.o)
                + problem.lambda1 * cp.sum_squares(problem.X @ u - w)
                + problem.lambda2 * cp.norm1(w)
                + problem.lambda3 * sum(cp.norm2(u[columns]) for columns in problem.modalities)
            )
            posed = cp.Problem(cp.Minimize(objective))
            posed.solve(solver=cp.CLARABEL)
    except Exception as failure:
        return Raw(type(failure).__name__, None)
    value = None if posed.value is None else float(posed.value)
    return Raw(str(posed.status), value if value is not None and math.isfinite(value) else None)
