"""The readings of the paper's two updates: their D^w and D^u, their factor, and what each one descends."""

from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np
from jaxtyping import Float
from scipy.linalg import eigh, lapack

from convexperc.arrays import FeatureVector, Vector, nonnegative_number
from convexperc.errors import InputError, SolverError
from convexperc.modalities import Modalities
from convexperc.objective import residuals, terms
from convexperc.problem import Problem

SMOOTHING_LOSS = 1e-6
"""Default eps: the smoothed limit is then proved to lie within 1e-6 ||o||^2 = 1e-6 F(0, 0) of F*."""

SMALLEST_EPS = 1e-150
"""The default eps stays between this and its inverse, where its square neither under- nor overflows."""

MACHINE_EPSILON = float(np.finfo(np.float64).eps)
"""A k x k system counts as singular below a reciprocal condition of k times this: what rounding can blur."""


class Size(StrEnum):
    """What stands for |w_i| in D^w = diag(1/(2 |w_i|))."""

    SIGNED = "w_i"
    ABSOLUTE = "|w_i|"
    L1_NORM = "||w||_1"
    SMOOTHED = "sqrt(w_i^2 + eps^2)"


class LinearSolver(StrEnum):
    """How u is solved for: the d x d system as printed, or the n x n one that Woodbury's identity gives."""

    DIRECT = "direct"
    WOODBURY = "woodbury"


class OnSingular(StrEnum):
    """What to do with a singular system: stop, or take the least-squares solution of least norm."""

    STOP = "stop"
    MINIMUM_NORM = "minimum_norm"


class SingularSystemError(SolverError):
    """The matrix of an update is singular, exactly or to within rounding."""


@dataclass(frozen=True, eq=False)
class Diagonal:
    """diag(1/(2 s_i)), kept as its sizes s, so that s_i = 0 costs no division.

    Attributes
    ----------
    sizes : float64 (k,)
        s_i; negative only in the printed reading.
    """

    sizes: Float[np.ndarray, " k"]

    def times(self, weight: float) -> Float[np.ndarray, " k"]:
        """Return weight / (2 s_i), shape (k,): infinite where s_i = 0, and absent (0) if `weight` is 0."""
        if weight == 0.0:
            return np.zeros_like(self.sizes)
        with np.errstate(divide="ignore", over="ignore"):
            return np.asarray(weight / 2.0 / self.sizes)

    def inverse(self, weight: float) -> Float[np.ndarray, " k"]:
        """Return 2 s_i / weight, shape (k,), for `weight` > 0: 0 where s_i = 0."""
        return 2.0 * self.sizes / weight


@dataclass(frozen=True)
class Reading:
    """One way to read the update of Algorithm 1.

    Attributes
    ----------
    name : str
    size : Size
        What stands for |w_i| in D^w. D^u has ||u^i||_2, smoothed alike in the smoothed reading.
    factor : float
        What multiplies lambda2 D^w and lambda3 D^u in the systems: 1/2 as printed, 1 as F asks for.
    own : str
        The objective that no iteration raises, in either order; empty when there is none.
    eps : float or None
        Smoothing, in units of w and of u; None means `SMOOTHING_LOSS` ||o||^2 / (n lambda2 + m lambda3).
        Used by the smoothed reading only.

    Raises
    ------
    InputError
        eps is not a finite number > 0.
    """

    name: str
    size: Size
    factor: float
    own: str
    eps: float | None = None

    def __post_init__(self) -> None:
        if self.eps is not None and nonnegative_number(self.eps, "eps", error=InputError) == 0.0:
            remedy = "The reading without smoothing is CORRECTED."
            raise InputError("eps", value=self.eps, must="must be > 0", remedy=remedy)

    def for_problem(self, problem: Problem) -> "Reading":
        """Return this reading with its eps made explicit for `problem`."""
        if self.size is not Size.SMOOTHED or self.eps is not None:
            return self
        budget = problem.n * problem.lambda2 + problem.m * problem.lambda3
        allowed = SMOOTHING_LOSS * float(problem.o @ problem.o)
        if allowed == 0.0 or budget == 0.0:
            return replace(self, eps=SMOOTHING_LOSS)
        return replace(self, eps=min(max(allowed / budget, SMALLEST_EPS), 1.0 / SMALLEST_EPS))

    def view_diagonal(self, w: Vector) -> Diagonal:
        """D^w at w, shape (n,): line 4 of Algorithm 1."""
        return Diagonal(self._view_sizes(w))

    def modality_diagonal(self, u: FeatureVector, modalities: Modalities) -> Diagonal:
        """D^u at u, shape (d,), line 5 of Algorithm 1: the j-th block is I_j / (2 ||u^j||_2)."""
        sizes = np.empty_like(u)
        for columns, size in zip(modalities, self._modality_sizes(u, modalities), strict=True):
            sizes[columns] = size
        return Diagonal(sizes)

    def own_objective(self, problem: Problem, w: Vector, u: FeatureVector) -> float:
        """Return ||X'w - o||^2 + lambda1 ||Xu - w||^2 + factor (lambda2 sum_i s_i + lambda3 sum_j t_j).

        s_i and t_j are the sizes in D^w and D^u: F itself for `CORRECTED`, F with lambda2/2 and lambda3/2
        for `ABSOLUTE`, F_eps for `SMOOTHED`. NaN if the reading has no objective of its own.
        """
        if not self.own:
            return float("nan")
        parts = terms(problem, w, u)
        views = problem.lambda2 * float(self._view_sizes(w).sum()) if problem.lambda2 else 0.0
        groups = self._modality_sizes(u, problem.modalities)
        modalities = problem.lambda3 * float(groups.sum()) if problem.lambda3 else 0.0
        return parts.loss + parts.coupling + self.factor * (views + modalities)

    def _view_sizes(self, w: Vector) -> Vector:
        match self.size:
            case Size.SIGNED:
                return w
            case Size.ABSOLUTE:
                return np.asarray(np.abs(w))
            case Size.L1_NORM:
                return np.full_like(w, np.abs(w).sum())
            case Size.SMOOTHED:
                return np.asarray(np.hypot(w, self.eps or 0.0))

    def _modality_sizes(self, u: FeatureVector, modalities: Modalities) -> Float[np.ndarray, " m"]:
        norms = modalities.norms(u)
        return np.asarray(np.hypot(norms, self.eps or 0.0)) if self.size is Size.SMOOTHED else norms


PRINTED = Reading("printed", Size.SIGNED, factor=0.5, own="")
ABSOLUTE = Reading("absolute", Size.ABSOLUTE, factor=0.5, own="F with lambda2/2 and lambda3/2")
CORRECTED = Reading("corrected", Size.ABSOLUTE, factor=1.0, own="F")
APPENDIX_HALF = Reading("appendix_half", Size.L1_NORM, factor=0.5, own="")
APPENDIX_FULL = Reading("appendix_full", Size.L1_NORM, factor=1.0, own="")
SMOOTHED = Reading("smoothed", Size.SMOOTHED, factor=1.0, own="F with sqrt(t^2 + eps^2) for |t|")
READINGS = (PRINTED, ABSOLUTE, CORRECTED, APPENDIX_HALF, APPENDIX_FULL, SMOOTHED)


def smoothed(eps: float | None = None) -> Reading:
    """Return the smoothed reading with an explicit `eps`.

    It descends F_eps, where |t| is replaced with sqrt(t^2 + eps^2). Since
    F <= F_eps <= F + eps (n lambda2 + m lambda3), its limit is within that distance of F*.

    Parameters
    ----------
    eps : float or None
        Finite and > 0, in units of w and of u; None for the default that `Reading` states.

    Raises
    ------
    InputError
        As `Reading` does.
    """
    return replace(SMOOTHED, eps=eps)


def derivative_w(problem: Problem, reading: Reading, w: Vector, u: FeatureVector) -> Vector:
    """Return 2 XX'w - 2 Xo - 2 lambda1 Xu + 2 lambda1 w + 2 factor lambda2 D^w w, shape (n,).

    With `PRINTED` (2 factor = 1, D^w = diag(1/(2 w_i))) it is what the paper takes for the derivative of F
    in w; with `CORRECTED` it is that derivative, wherever it exists. D^w w is taken as 0 where w_i = 0.

    Notes
    -----
    Paper: Derivative with respect to w
    """
    p, q = residuals(problem, w, u)
    penalty = _times_point(reading.view_diagonal(w), 2.0 * reading.factor * problem.lambda2, w)
    return np.asarray(2.0 * (problem.X @ p - problem.lambda1 * q) + penalty)


def derivative_u(problem: Problem, reading: Reading, w: Vector, u: FeatureVector) -> FeatureVector:
    """Return 2 lambda1 X'Xu - 2 lambda1 X'w + 2 factor lambda3 D^u u, shape (d,).

    With `PRINTED` (2 factor = 1) it is what the paper takes for the derivative of F in u; with `CORRECTED` it
    is that derivative, wherever it exists. D^u u is taken as 0 where u^i = 0.

    Notes
    -----
    Paper: Derivative with respect to u
    """
    diagonal = reading.modality_diagonal(u, problem.modalities)
    penalty = _times_point(diagonal, 2.0 * reading.factor * problem.lambda3, u)
    return np.asarray(2.0 * problem.lambda1 * (problem.X.T @ residuals(problem, w, u)[1]) + penalty)


def solve_w(
    problem: Problem, reading: Reading, Dw: Diagonal, u: FeatureVector, on_singular: OnSingular
) -> Vector:
    """Return (XX' + lambda1 I + factor lambda2 D^w)^-1 X (o + lambda1 u), shape (n,); printed, factor = 1/2.

    Where D^w is infinite the limit is taken: that w_i is 0 and leaves the system.

    Raises
    ------
    SingularSystemError
        The matrix is singular and `on_singular` is ``stop``.

    Notes
    -----
    Paper: Eq. (solve_w)
    """
    X, ridge = problem.X, Dw.times(reading.factor * problem.lambda2)
    if problem.lambda1 == 0.0 and problem.lambda2 == 0.0 and problem.n > problem.d:
        return _rank_short(problem.X.T, problem.o, on_singular)
    gram = X @ X.T + problem.lambda1 * np.eye(problem.n)
    return _solve_free(gram, ridge, X @ (problem.o + problem.lambda1 * u), on_singular)


def solve_u(
    problem: Problem,
    reading: Reading,
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
    Where D^u is infinite the limit is taken: that u^i is 0 and leaves the system.

    Raises
    ------
    SingularSystemError
        The matrix is singular and `on_singular` is ``stop``.

    Notes
    -----
    Paper: Eq. (solve_u)
    """
    X, lambda1, weight = problem.X, problem.lambda1, reading.factor * problem.lambda3
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
    """M'M x = M't where M has too few rows (or weighs 0): singular, whatever the numbers are."""
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
    """(gram + diag(ridge))^-1 rhs, equilibrated by the sizes of the diagonal terms, before they cancel."""
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
