"""The data and the memory of the compiled method: few arrays, whose rows are named here.

A kernel with few arguments compiles several times as fast as one with many. With n views and m modalities
a vector of unknowns (w, t) has N = n + m entries; shorter ones use the leading entries of a row.
"""

from typing import NamedTuple, no_type_check

import numpy as np
from numpy.typing import NDArray

from convexperc.solvers.newton.lapack import ARGUMENTS, NUMBER, Arguments, address, arguments_in

Z, Q, GW, KQ = 0, 1, 2, 3
"""Rows of a point: (w, t), (q, r), G w, and from `KQ` on K_i q; t_i = 2 ||u^i|| / lambda3, q = S(t)^-1 w,
r_i = ||X_i'q||."""
H, FACTOR, LATEST, BASE, BASE_H, BASE_FACTOR, SPARE = range(7)
"""Matrices (N, N): of the model, the Hessian and the Cholesky factor of its active rows and columns; the
factors of S(t) at the most recent t and at the base; the base's Hessian in w and its factor; scratch."""
GRADIENT, END, START, IMAGE, VALUES, LATEST_T, BASE_T, LAST_T, SLOPE, ROW = range(10)
"""Vectors (N,): of the model, h, the minimiser z, where to begin, H z, and the active unknowns in their
order; t at the most recent factor of S(t) and at the base, NaN first where there is none; the t of the last
answer in which it is not 0; scratch."""
SIGN, ORDER, VIEWS, BASE_VIEWS, NEAR, INSIDE, MODEL_VIEWS = range(7)
"""Sets of unknowns (N,): the sign of each, 0 where inactive, 2 for an active one that must be >= 0; the
active ones in the order of the factor; the order of the views in the two factors of S(t), those outside the
working set first; 1 for the views that the next working set has to contain besides the support of w; scratch;
the views of the model's Hessian, in its order."""
ACTIVE, FACTORED, FIRST, BASE_FIRST, SIZE, OWNER = range(6)
"""Counts: active unknowns; those of them, from the first on, for which the factor is up to date; where the
working set begins in `VIEWS` and in `BASE_VIEWS`; views in the model; which Hessian in w it holds."""
NO_HESSIAN, LATEST_HESSIAN, BASE_HESSIAN = 0, 1, 2
"""What `OWNER` says."""

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


class Grams(NamedTuple):
    """What all templates of a set of views share.

    Attributes
    ----------
    G : float64 (n, n)
        X X'.
    K : float64 (m, n, n)
        X_i X_i' of each modality.
    G_at, K_at : int
        Their addresses.
    """

    G: Floats
    K: Floats
    G_at: int
    K_at: int

    @classmethod
    def of(cls, G: Floats, K: Floats) -> "Grams":
        """The matrices in the order of C, and where they lie."""
        G, K = np.ascontiguousarray(G), np.ascontiguousarray(K)
        return cls(G, K, address(G), address(K))


class Templates(NamedTuple):
    """p templates, and the penalties of each.

    Attributes
    ----------
    C : float64 (p, n)
        Row j is X o_j.
    targets : float64 (p,)
        ||o_j||^2.
    lambdas : float64 (p, 3)
    """

    C: Floats
    targets: Floats
    lambdas: Floats


class Rows(NamedTuple):
    """Room for the answers to p templates; see `convexperc.solvers.newton.method.Batch`."""

    W: Floats
    T: Floats
    Q: Floats
    iterations: Integers
    gaps: Floats


class Data(NamedTuple):
    """The reduced problem of one template.

    Attributes
    ----------
    G, K, G_at, K_at : see `Grams`
    c : float64 (n,)
        X o.
    target : float
        ||o||^2.
    lambda1, lambda2, lambda3 : float
        The penalties; lambda1, lambda3 > 0.
    """

    G: Floats
    K: Floats
    G_at: int
    K_at: int
    c: Floats
    target: float
    lambda1: float
    lambda2: float
    lambda3: float


class Workspace(NamedTuple):
    """Memory of the method for all templates of a set of views.

    Attributes
    ----------
    points : float64 (3, 3 + m, N)
        The current point, the trial and the best one.
    matrices : float64 (7, N, N)
    vectors : float64 (10, N)
    sets : int64 (7, N)
    counts : int64 (6,)
    points_at, matrices_at, vectors_at : int
        Addresses.
    arguments : Arguments
        Of the calls of BLAS and LAPACK.
    """

    points: Floats
    matrices: Floats
    vectors: Floats
    sets: Integers
    counts: Integers
    points_at: int
    matrices_at: int
    vectors_at: int
    arguments: Arguments


class Memory(NamedTuple):
    """What a workspace is laid out in, as an array of float64, and where it lies."""

    numbers: Floats
    at: int


def new_memory(n: int, m: int) -> Memory:
    """Memory for n views and m modalities."""
    N = n + m
    numbers = np.zeros(ARGUMENTS + (3 * (3 + m) + 7 * N + 10 + 7) * N + 6)
    return Memory(numbers, address(numbers))


@no_type_check
def workspace(memory, n, m):
    """Lay out a workspace in which nothing is known yet; what it held before has no effect."""
    N, numbers, at = n + m, memory.numbers, memory.at
    points_from = ARGUMENTS
    matrices_from = points_from + 3 * (3 + m) * N
    vectors_from = matrices_from + 7 * N * N
    sets_from = vectors_from + 10 * N
    counts_from = sets_from + 7 * N
    points = numbers[points_from:matrices_from].reshape((3, 3 + m, N))
    matrices = numbers[matrices_from:vectors_from].reshape((7, N, N))
    vectors = numbers[vectors_from:sets_from].reshape((10, N))
    sets = numbers[sets_from:counts_from].view(np.int64).reshape((7, N))
    counts = numbers[counts_from : counts_from + 6].view(np.int64)
    vectors[LATEST_T, 0] = vectors[BASE_T, 0] = np.nan
    for k in range(N):
        vectors[LAST_T, k] = 0.0
        for row in range(7):
            sets[row, k] = 0
        sets[VIEWS, k], sets[BASE_VIEWS, k], sets[MODEL_VIEWS, k] = k, k, k
    for k in range(6):
        counts[k] = 0
    return Workspace(
        points, matrices, vectors, sets, counts, at + NUMBER * points_from, at + NUMBER * matrices_from,
        at + NUMBER * vectors_from, arguments_in(numbers, at),
    )  # fmt: skip
