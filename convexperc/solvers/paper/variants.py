"""The variants of the paper's two updates: D^w and D^u, the factor, and the objective that each descends."""

from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np
from jaxtyping import Float

from convexperc.errors import InputError
from convexperc.problem.arrays import FeatureVector, Vector, nonnegative_number
from convexperc.problem.formulation import terms
from convexperc.problem.modalities import Modalities
from convexperc.problem.problem import Problem

SMOOTHING_LOSS = 1e-6
"""Sets the default eps: F at the smoothed limit exceeds F* by at most this times ||o||^2 = F(0, 0)."""

SMALLEST_EPS = 1e-150
"""The default eps stays between this and its inverse, where its square neither under- nor overflows."""


class Size(StrEnum):
    """What takes the place of |w_i| in D^w = diag(1/(2 |w_i|))."""

    SIGNED = "w_i"
    ABSOLUTE = "|w_i|"
    L1_NORM = "||w||_1"
    SMOOTHED = "sqrt(w_i^2 + eps^2)"


class Order(StrEnum):
    """Which w the update of u uses: w(i+1), as in lines 6 and 7, or w(i), which the text allows too."""

    GAUSS_SEIDEL = "gauss_seidel"
    JACOBI = "jacobi"


@dataclass(frozen=True, eq=False)
class Diagonal:
    """diag(1/(2 s_i)), stored as its sizes s, so that s_i = 0 causes no division by 0.

    Attributes
    ----------
    sizes : float64 (k,)
        s_i; negative only in the printed variant.
    """

    sizes: Float[np.ndarray, " k"]

    def times(self, weight: float) -> Float[np.ndarray, " k"]:
        """Return weight / (2 s_i), shape (k,): infinite where s_i = 0; 0 if `weight` is 0."""
        if weight == 0.0:
            return np.zeros_like(self.sizes)
        with np.errstate(divide="ignore", over="ignore"):
            return np.asarray(weight / 2.0 / self.sizes)

    def inverse(self, weight: float) -> Float[np.ndarray, " k"]:
        """Return 2 s_i / weight, shape (k,), for `weight` > 0: 0 where s_i = 0."""
        return 2.0 * self.sizes / weight


@dataclass(frozen=True)
class UpdateVariant:
    """One variant of the update of Algorithm 1.

    Attributes
    ----------
    name : str
        By which `convexperc.solvers.paper.run` takes it.
    size : Size
        What takes the place of |w_i| in D^w. D^u has ||u^i||_2, smoothed likewise in the smoothed variant.
    factor : float
        Factor of lambda2 D^w and lambda3 D^u in the systems: 1/2 as printed, 1 in the derivative of F.
    own : str
        The objective that no iteration raises, in either order; empty when there is none.
    eps : float or None
        Smoothing, in units of w and of u; None means `SMOOTHING_LOSS` ||o||^2 / (n lambda2 + m lambda3).
        Used by the smoothed variant only.

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
            remedy = "The variant without smoothing is CORRECTED."
            raise InputError("eps", value=self.eps, must="must be > 0", remedy=remedy)

    def for_problem(self, problem: Problem) -> "UpdateVariant":
        """Return this variant with its eps made explicit for `problem`."""
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
        for `ABSOLUTE`, F_eps for `SMOOTHED`. NaN if the variant has no objective of its own.
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


PRINTED = UpdateVariant("printed", Size.SIGNED, factor=0.5, own="")
"""Algorithm 1 as printed: D^w = diag(1/(2 w_i)), with the sign of w_i."""
ABSOLUTE = UpdateVariant("absolute", Size.ABSOLUTE, factor=0.5, own="F with lambda2/2 and lambda3/2")
"""The printed factor with |w_i| in D^w."""
CORRECTED = UpdateVariant("corrected", Size.ABSOLUTE, factor=1.0, own="F")
"""|w_i| in D^w, and the factor that belongs to F."""
APPENDIX_HALF = UpdateVariant("appendix_half", Size.L1_NORM, factor=0.5, own="")
"""||w||_1 in D^w, as in the appendix, with the printed factor."""
APPENDIX_FULL = UpdateVariant("appendix_full", Size.L1_NORM, factor=1.0, own="")
"""||w||_1 in D^w, as in the appendix, with the factor that belongs to F."""
SMOOTHED = UpdateVariant("smoothed", Size.SMOOTHED, factor=1.0, own="F with sqrt(t^2 + eps^2) for |t|")
"""`CORRECTED` with smoothed sizes, which never hold a coordinate at 0."""
VARIANTS = (PRINTED, ABSOLUTE, CORRECTED, APPENDIX_HALF, APPENDIX_FULL, SMOOTHED)
"""All variants."""


def smoothed(eps: float | None = None) -> UpdateVariant:
    """Return the smoothed variant with an explicit `eps`.

    It descends F_eps, where |t| is replaced with sqrt(t^2 + eps^2). Since
    F <= F_eps <= F + eps (n lambda2 + m lambda3), its limit is within that distance of F*.

    Parameters
    ----------
    eps : float or None
        Finite and > 0, in units of w and of u; None for the default that `UpdateVariant` states.

    Raises
    ------
    InputError
        As `UpdateVariant` does.
    """
    return replace(SMOOTHED, eps=eps)
