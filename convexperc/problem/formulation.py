"""F and each of its terms, in plain float64."""

from dataclasses import dataclass

import numpy as np

from convexperc.errors import PointError, ProblemError, check_type
from convexperc.problem.arrays import FeatureVector, Vector
from convexperc.problem.problem import Problem


@dataclass(frozen=True)
class Terms:
    """The four terms of F at one point, each already multiplied by its lambda.

    Attributes
    ----------
    loss : float
        ||X'w - o||^2, Paper: Eq. (loss).
    coupling : float
        lambda1 ||Xu - w||^2, Paper: Eq. (modal_loss).
    view_norm : float
        lambda2 ||w||_1, Paper: Eq. (loss_with_l1).
    modality_norm : float
        lambda3 ||u||_M = lambda3 sum_i ||u^i||_2.
    """

    loss: float
    coupling: float
    view_norm: float
    modality_norm: float

    @property
    def total(self) -> float:
        """F(w, u)."""
        return self.loss + self.coupling + self.view_norm + self.modality_norm


def residuals(problem: Problem, w: Vector, u: FeatureVector) -> tuple[FeatureVector, Vector]:
    """p = X'w - o, shape (d,), and q = Xu - w, shape (n,)."""
    check_type(problem, Problem, "problem", ProblemError)
    for name, part, length in (("w", w, problem.n), ("u", u, problem.d)):
        check_type(part, np.ndarray, name, PointError)
        if isinstance(part, np.ma.MaskedArray) or part.shape != (length,) or part.dtype != np.float64:
            must = f"must have shape ({length},) and type float64, without a mask, to fit the problem"
            raise PointError(name, value=f"{part.dtype.name} {part.shape}", must=must)
    return problem.X.T @ w - problem.o, problem.X @ u - w


def terms(problem: Problem, w: Vector, u: FeatureVector) -> Terms:
    """Evaluate the terms of F at (w, u).

    Parameters
    ----------
    problem : Problem
    w : float64 (n,)
        View weights.
    u : float64 (d,)
        Feature weights.

    Returns
    -------
    Terms
    """
    p, q = residuals(problem, w, u)
    return Terms(
        loss=float(p @ p),
        coupling=_weighted(problem.lambda1, float(q @ q)),
        view_norm=_weighted(problem.lambda2, float(np.abs(w).sum())),
        modality_norm=_weighted(problem.lambda3, float(problem.modalities.norms(u).sum())),
    )


def objective(problem: Problem, w: Vector, u: FeatureVector) -> float:
    """F(w, u) = ||X'w - o||^2 + lambda1 ||Xu - w||^2 + lambda2 ||w||_1 + lambda3 sum_i ||u^i||_2."""
    return terms(problem, w, u).total


def _weighted(weight: float, value: float) -> float:
    """A term whose lambda is 0 is absent, even where its norm overflows."""
    return 0.0 if weight == 0.0 else weight * value
