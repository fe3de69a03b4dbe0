"""The linear systems of the paper's two updates, and the derivatives that the updates set to zero."""

from enum import StrEnum

import numpy as np
from jaxtyping import Float
from scipy.linalg import eigh, lapack

from convexperc.errors import SolverError
from convexperc.problem.arrays import FeatureVector, Vector
from convexperc.problem.formulation import residuals
from convexperc.problem.problem import Problem
from convexperc.solvers.paper.variants import Diagonal, UpdateVariant

MACHINE_EPSILON = float(np.finfo(np.float64).eps)
"""2^-52. A k x k system counts as singular if its reciprocal condition number is below k times this, the
level of the rounding errors of its factorisation."""


class LinearSolver(StrEnum):
    """How u is computed: from the d x d system as printed, or from the n x n one by Woodbury's identity."""

    DIRECT = "direct"
    WOODBURY = "woodbury"


class OnSingular(StrEnum):
    """What to do with a singular system: stop, or use the least-squares solution of least norm."""

    STOP = "stop"
    MINIMUM_NORM = "minimum_norm"


class SingularSystemError(SolverError):
    """The matrix of an update is singular, exactly or at rounding level."""


def derivative_w(problem: Problem, variant: UpdateVariant, w: Vector, u: FeatureVector) -> Vector:
    """Return 2 XX'w - 2 Xo - 2 lambda1 Xu + 2 lambda1 w + 2 factor lambda2 D^w w, shape (n,).

    With `PRINTED` (2 factor = 1, D^w = diag(1/(2 w_i))) it is what the paper states as the derivative of F
    in w; with `CORRECTED` it is that derivative, wherever it exists. D^w w is taken as 0 where w_i = 0.

    Notes
    -----
    Paper: Derivative with respect to w
    """
    p, q = residuals(problem, w, u)
    penalty = _times_point(variant.view_diagonal(w), 2.0 * variant.factor * problem.lambda2, w)
    return np.asarray(2.0 * (problem.X @ p - problem.lambda1 * q) + penalty)


def derivative_u(problem: Problem, variant: UpdateVariant, w: Vector, u: FeatureVector) -> FeatureVector:
    """Return 2 lambda1 X'Xu - 2 lambda1 X'w + 2 factor lambda3 D^u u, shape (d,).

    With `PRINTED` (2 factor = 1) it is what the paper states as the derivative of F in u; with `CORRECTED` it
    is that derivative, wherever it exists. D^u u is taken as 0 where u^i = 0.

    Notes
    -----
    Paper: Derivative with respect to u
    """
    diagonal = variant.modality_diagonal(u, problem.modalities)
    penalty = _times_point(diagonal, 2.0 * variant.factor * problem.lambda3, u)
    return np.asarray(2.0 * problem.lambda1 * (problem.X.T @ residuals(problem, w, u)[1]) + penalty)


def solve_w(
    problem: Problem, variant: UpdateVariant, Dw: Diagonal, u: FeatureVector, on_singular: OnSingular
) -> Vector:
    """Return (XX' + lambda1 I + factor lambda2 D^w)^-1 X (o + lambda1 u), shape (n,); printed, factor = 1/2.

    Where D^w is infinite, the limit is used: w_i = 0, and the system is solved for the other entries.

    Raises
    ------
    SingularSystemError
        The matrix is singular and `on_singular` is ``stop``.

    Notes
    -----
    Paper: Eq. (solve_w)
    """
    X, ridge = problem.X, Dw.times(variant.factor * problem.lambda2)
    if problem.lambda1 == 0.0 and problem.lambda2 == 0.0 and problem.n > problem.d:
        return _rank_short(problem.X.T, problem.o, on_singular)
    gram = X @ X.T + problem.lambda1 * np.eye(problem.n)
    return _solve_free(gram, ridge, X @ (problem.o + problem.lambda1 * u), on_singular)


def solve_u(
    problem: Problem,
    variant: UpdateVariant,
    Du: Diagonal,
    w: Vector,
    linear_solver: LinearSolver,
    on_singular: OnSingular,
) -> FeatureVector:
    """Return (lambda1 X'X + factor lambda3 D^u)^-1 lambda1 X'w, shape (d,); printed, factor = 1/2.

    ``direct`` solves this d x d system: O(n d^2 + d^3). ``woodbury`` gives the same vector as
    lambda1 Di X' (I + lambda1 X Di X')^-1 w with Di = (factor lambda3 D^u)^-1, 2 ||u^i|| / (factor lambda3):
    O(n^2 d + n^3), and no division by ||u^i||. It needs lambda3 > 0; with lambda3 = 0 both use the printed
    matrix, lambda1 X'X, whose rank is at most n: for n < d it is always singular.
    Where D^u is infinite, the limit is used: u^i = 0, and the system is solved for the other entries.

    Raises
    ------
    SingularSystemError
        The matrix is singular and `on_singular` is ``stop``.

    Notes
    -----
    Paper: Eq. (solve_u)
    """
    X, lambda1, weight = problem.X, problem.lambda1, variant.factor * problem.lambda3
    if weight > 0.0 and linear_solver is LinearSolver.WOODBURY:
        half = Du.inverse(weight)[:, None] * X.T
        return np.asarray(lambda1 * half @ _solve(lambda1 * (X @ half), np.ones(problem.n), w, on_singular))
    if weight == 0.0 and (problem.n < problem.d or lambda1 == 0.0):
        return _rank_short(X, w if lambda1 > 0.0 else np.zeros_like(w), on_singular)
    return _solve_free(lambda1 * (X.T @ X), Du.times(weight), lambda1 * (X.T @ w), on_singular)


def least_norm(M: Float[np.ndarray, "r c"], t: Float[np.ndarray, " r"]) -> Float[np.ndarray, " c"]:
    """Return the argmin of ||M x - t|| that has the least norm.

    Raises
    ------
    SolverError
        The singular value decomposition did not converge.
    """
    try:
        return np.asarray(np.linalg.lstsq(M, t, rcond=None)[0])
    except np.linalg.LinAlgError as problem:
        remedy = "Rescale the data."
        raise SolverError("least squares", value=M.shape, must=f"failed: {problem}", remedy=remedy) from None


def _times_point(
    diagonal: Diagonal, weight: float, point: Float[np.ndarray, " k"]
) -> Float[np.ndarray, " k"]:
    entries = diagonal.times(weight)
    return np.asarray(np.where(np.isfinite(entries), entries, 0.0) * point)


def _rank_short(
    M: Float[np.ndarray, "r c"], t: Float[np.ndarray, " r"], on_singular: OnSingular
) -> Float[np.ndarray, " c"]:
    """Solve M'M x = M't where M has fewer rows than columns, or factor 0: singular for any data."""
    if on_singular is OnSingular.STOP:
        raise _singular(M.shape[1], 0.0)
    return least_norm(M, t)


def _singular(order: int, rcond: float) -> SingularSystemError:
    remedy = "Pass on_singular='minimum_norm' for the least-squares solution of least norm."
    must = f"must have a reciprocal condition of at least {order * MACHINE_EPSILON:.1e}"
    return SingularSystemError(
        f"the {order} x {order} system of an update", value=rcond, must=must, remedy=remedy
    )


def _solve_free(
    gram: Float[np.ndarray, "k k"],
    ridge: Float[np.ndarray, " k"],
    rhs: Float[np.ndarray, " k"],
    on_singular: OnSingular,
) -> Float[np.ndarray, " k"]:
    """Solve with x_i = 0 wherever ridge_i is infinite."""
    free = np.isfinite(ridge)
    x = np.zeros_like(rhs)
    x[free] = _solve(gram[np.ix_(free, free)], ridge[free], rhs[free], on_singular)
    return x


def _solve(
    gram: Float[np.ndarray, "k k"],
    ridge: Float[np.ndarray, " k"],
    rhs: Float[np.ndarray, " k"],
    on_singular: OnSingular,
) -> Float[np.ndarray, " k"]:
    """Return (gram + diag(ridge))^-1 rhs, equilibrated by the sums of the absolute diagonal terms."""
    order = rhs.size
    size = np.sqrt(np.diagonal(gram) + np.abs(ridge))
    scale = 1.0 / np.where(size > 0.0, size, 1.0)
    B = (gram + np.diag(ridge)) * scale[:, None] * scale
    if order == 0 or not np.isfinite(B).all():
        return np.full_like(rhs, np.nan)
    lu, pivots, zero_pivot = lapack.dgetrf(B)
    rcond = 0.0 if zero_pivot else float(lapack.dgecon(lu, max(1.0, np.linalg.norm(B, 1)))[0])
    if rcond >= order * MACHINE_EPSILON:
        return np.asarray(scale * lapack.dgetrs(lu, pivots, scale * rhs)[0])
    if on_singular is OnSingular.STOP:
        raise _singular(order, rcond)
    values, vectors = eigh(B)
    kept = np.abs(values) > order * MACHINE_EPSILON * max(1.0, np.abs(values).max())
    x = scale * (vectors[:, kept] @ (vectors[:, kept].T @ (scale * rhs) / values[kept]))
    null_space = np.linalg.qr(scale[:, None] * vectors[:, ~kept])[0]
    return np.asarray(x - null_space @ (null_space.T @ x))
