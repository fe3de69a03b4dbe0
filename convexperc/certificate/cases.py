"""What the bounds from reduced data work on: what is given, what is proved, and the room in between."""

from typing import NamedTuple, no_type_check

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class GramBounds(NamedTuple):
    """What all templates share: Gram matrices, with bounds of lengths and rounding.

    Attributes
    ----------
    G : float64 (n, n)
    K : float64 (m, n, n)
    lengths : float64 (m, n)
        Upper bounds of the length of each modality's part of each row.
    rows : float64 (n,)
        Upper bounds of the length of each row.
    blocks : float64 (m,)
        Upper bounds of ||X_i||_F.
    gamma : float
        Relative error of an entry of G, K or c and of every sum that is formed of them.
    """

    G: Floats
    K: Floats
    lengths: Floats
    rows: Floats
    blocks: Floats
    gamma: float


class AnswerBounds(NamedTuple):
    """What is proved of each of p answers, in the units of the reduced data.

    Attributes
    ----------
    lower, upper, gap : float64 (p,)
        lower <= F* <= F(w, u) <= upper, also for u as float64 stores it, and F(w, u) - F* <= gap.
    modality_norms : float64 (p, m)
        ||u^i||_2, to rounding.
    zero_views : bool (p, n)
        True where w*_j = 0 is proved.
    zero_modalities : bool (p, m)
        True where u*^i = 0 is proved.
    """

    lower: Floats
    upper: Floats
    gap: Floats
    modality_norms: Floats
    zero_views: NDArray[np.bool_]
    zero_modalities: NDArray[np.bool_]

    @classmethod
    def unknown(cls, p: int, n: int, m: int) -> "AnswerBounds":
        """Room for p answers of which nothing is known."""
        upper = np.empty(p)
        upper.fill(np.inf)
        return cls(
            np.zeros(p), upper, upper.copy(), np.zeros((p, m)), np.zeros((p, n), dtype=np.bool_),
            np.zeros((p, m), dtype=np.bool_),
        )  # fmt: skip


class Room(NamedTuple):
    """Working memory.

    Attributes
    ----------
    y : float64 (n,)
        X(X'w - o).
    e, e_error : float64 (n,)
        Xu - w, and a bound of its error.
    b, b_error : float64 (n,)
        The dual point's b, and a bound of its error.
    v, v_error : float64 (n,)
        X a - b, and a bound of its error.
    z : float64 (m, n)
        K_i q.
    Kb : float64 (m, n)
        K_i b.
    tau : float64 (m,)
        sum_j |q_j| times the length of modality i's part of row j, which bounds ||X_i'q||.
    low, high : float64 (m,)
        Bounds of ||X_i'q||.
    reach : float64 (m,)
        Upper bounds of ||X_i'b||.
    pull : float64 (m,)
        Upper bounds of q'K_i b.
    """

    y: Floats
    e: Floats
    e_error: Floats
    b: Floats
    b_error: Floats
    v: Floats
    v_error: Floats
    z: Floats
    Kb: Floats
    tau: Floats
    low: Floats
    high: Floats
    reach: Floats
    pull: Floats


class Exclusion(NamedTuple):
    """What lower bounds settle the question which optimum is lowest.

    Attributes
    ----------
    units : float64 (p,) or (0,)
        Factor from each template's F to common units; empty where only a narrow gap will do.
    most : float
        In common units: an optimum above this is not the lowest.
    """

    units: Floats
    most: float


NO_EXCLUSION = Exclusion(np.empty(0), np.inf)


class Case(NamedTuple):
    """One template and its answer, normalised.

    Attributes
    ----------
    c : float64 (n,)
        X o.
    target : float
        ||o||^2.
    lambdas : float64 (3,)
    w : float64 (n,)
    t : float64 (m,)
    q : float64 (n,)
        u^i = t_i X_i' q.
    """

    c: Floats
    target: float
    lambdas: Floats
    w: Floats
    t: Floats
    q: Floats


class Cases(NamedTuple):
    """p templates and their answers, normalised; see `Case`.

    Attributes
    ----------
    C : float64 (p, n)
    targets : float64 (p,)
    lambdas : float64 (p, 3)
    W : float64 (p, n)
    T : float64 (p, m)
    Q : float64 (p, n)
    """

    C: Floats
    targets: Floats
    lambdas: Floats
    W: Floats
    T: Floats
    Q: Floats


class Value(NamedTuple):
    """What is known of F at the point.

    Attributes
    ----------
    loss : float
        Upper bound of ||X'w - o||^2.
    lower, upper : float
        Bounds of F(w, u).
    stored : float
        What rounding u to float64 adds to F at most.
    rho : float
        sum_j |w_j| ||x_j|| + ||o||, which bounds ||X'w - o||.
    linear : float
        c'w.
    """

    loss: float
    lower: float
    upper: float
    stored: float
    rho: float
    linear: float


def new_numbers(n: int, m: int) -> Floats:
    """Memory for the room of n views and m modalities."""
    return np.empty(7 * n + 2 * m * n + 5 * m)


@no_type_check
def room_in(numbers, n, m):
    """Lay out the room in these numbers."""
    by_view, by_both, by_modality = 7 * n, 2 * m * n, 5 * m
    A = numbers[:by_view].reshape((7, n))
    B = numbers[by_view : by_view + by_both].reshape((2, m, n))
    C = numbers[by_view + by_both : by_view + by_both + by_modality].reshape((5, m))
    return Room(A[0], A[1], A[2], A[3], A[4], A[5], A[6], B[0], B[1], C[0], C[1], C[2], C[3], C[4])


@no_type_check
def case_of(cases, j):
    """Template j and its answer."""
    return Case(cases.C[j], cases.targets[j], cases.lambdas[j], cases.W[j], cases.T[j], cases.Q[j])


@no_type_check
def forget(bounds, j):
    """Nothing is known of answer j."""
    bounds.lower[j], bounds.upper[j], bounds.gap[j] = 0.0, np.inf, np.inf
    for a in range(bounds.zero_views.shape[1]):
        bounds.zero_views[j, a] = False
    for i in range(bounds.zero_modalities.shape[1]):
        bounds.zero_modalities[j, i] = False
