"""The step of the Newton method: minimise z'Hz/2 + h'z + weight ||z_1..n||_1 subject to z_n+1 .. z_M >= 0.

M unknowns of the model are in use, the first n of them for views. A caller that changes rows of H has to call
`forget`.

Source: Hintermueller, Ito and Kunisch, The primal-dual active set strategy, SIAM J. Optim. 13 (2002).
"""

from typing import no_type_check

import numpy as np
from numpy.typing import NDArray

from convexperc.kernels.kernel import Kernel
from convexperc.solvers.newton.lapack import (
    NUMBER,
    cholesky_extend,
    cholesky_solve,
    inner,
    symmetric_times,
)
from convexperc.solvers.newton.workspace import (
    ACTIVE,
    END,
    FACTOR,
    FACTORED,
    GRADIENT,
    IMAGE,
    ORDER,
    SIGN,
    START,
    VALUES,
    H,
)

ACTIVE_SET_STEPS = 8
"""Steps of the active set method before coordinate descent takes over: it settles in a few, or cycles."""
SWEEPS = 40
"""Coordinate descent sweeps before the active set method is tried again from their support."""
ROUNDS = 6
"""Such rounds before the last iterate of coordinate descent is returned as it is."""


@no_type_check
def forget(room, first):
    """Invalidate the part of the factor that depends on the rows of H from `first` on, which have changed."""
    sets, counts = room.sets, room.counts
    for x in range(counts[FACTORED]):
        if sets[ORDER, x] >= first:
            counts[FACTORED] = x
            return


@no_type_check
def arrange(room, M):
    """List the active unknowns: those already listed in their order, then the new ones."""
    sets, counts, vectors = room.sets, room.counts, room.vectors
    count, kept = 0, counts[FACTORED]
    for k in range(M):
        vectors[IMAGE, k] = 0.0  # marks what is listed
    for x in range(counts[ACTIVE]):
        k = sets[ORDER, x]
        if k < M and sets[SIGN, k] != 0:
            sets[ORDER, count], vectors[IMAGE, k] = k, 1.0
            count += 1
        elif count < kept:
            kept = count
    for k in range(M):
        if sets[SIGN, k] != 0 and vectors[IMAGE, k] == 0.0:
            sets[ORDER, count] = k
            count += 1
    counts[ACTIVE], counts[FACTORED] = count, kept


@no_type_check
def factor_active(room):
    """Update the factor for the list of active unknowns; false if H is singular on them."""
    sets, counts, matrices = room.sets, room.counts, room.matrices
    count, kept, N = counts[ACTIVE], counts[FACTORED], room.vectors.shape[1]
    if kept == count:
        return True
    for y in range(count):
        k = sets[ORDER, y]
        for x in range(max(y, kept), count):
            matrices[FACTOR, y, x] = matrices[H, k, sets[ORDER, x]]
    factor_at = room.matrices_at + NUMBER * FACTOR * N * N
    if cholesky_extend(matrices[FACTOR], factor_at, kept, count, room.arguments) != 0:
        counts[FACTORED] = 0
        return False
    counts[FACTORED] = count
    return True


@no_type_check
def solve_active(room, weight, n, M):
    """Minimise over the active unknowns, with the others at 0; false if H is singular on them."""
    arrange(room, M)
    if not factor_active(room):
        return False
    sets, vectors = room.sets, room.vectors
    count, N = room.counts[ACTIVE], vectors.shape[1]
    for x in range(count):
        k = sets[ORDER, x]
        vectors[VALUES, x] = -vectors[GRADIENT, k] - (weight * sets[SIGN, k] if k < n else 0.0)
    factor_at, values_at = room.matrices_at + NUMBER * FACTOR * N * N, room.vectors_at + NUMBER * VALUES * N
    cholesky_solve(room.matrices[FACTOR], factor_at, count, vectors[VALUES], values_at, room.arguments)
    for k in range(M):
        vectors[END, k] = 0.0
    for x in range(count):
        vectors[END, sets[ORDER, x]] = vectors[VALUES, x]
    return True


@no_type_check
def update_active(room, weight, slack, n, M):
    """Drop unknowns of the wrong sign, add those whose gradient exceeds its bound; true if none changed."""
    sets, vectors, settled = room.sets, room.vectors, True
    N = vectors.shape[1]
    end_at, image_at = room.vectors_at + NUMBER * END * N, room.vectors_at + NUMBER * IMAGE * N
    H_at = room.matrices_at + NUMBER * H * N * N
    symmetric_times(room.matrices[H], H_at, M, vectors[END], end_at, vectors[IMAGE], image_at, room.arguments)
    for k in range(M):
        gradient = vectors[GRADIENT, k] + vectors[IMAGE, k]
        if sets[SIGN, k] != 0:
            if vectors[END, k] * sets[SIGN, k] <= 0:
                sets[SIGN, k], vectors[END, k], settled = 0, 0.0, False
        elif k < n and abs(gradient) > weight * (1 + 1e-12):
            sets[SIGN, k], settled = (-1 if gradient > 0 else 1), False
        elif k >= n and gradient < -slack:
            sets[SIGN, k], settled = 2, False
    return settled


@no_type_check
def active_set(room, weight, slack, n, M):
    """Primal-dual active set method from the support of `START`; true if it reached a solution."""
    for k in range(M):
        z = room.vectors[START, k]
        room.sets[SIGN, k] = 0 if z == 0 else (2 if k >= n else (1 if z > 0 else -1))
    for _ in range(ACTIVE_SET_STEPS):
        if not solve_active(room, weight, n, M):
            return False
        if update_active(room, weight, slack, n, M):
            return True
    return False


@no_type_check
def sweep(room, weight, n, M):
    """One sweep of coordinate descent over the first M unknowns of `START`."""
    vectors, matrices, N = room.vectors, room.matrices, room.vectors.shape[1]
    z, z_at = vectors[START], room.vectors_at + NUMBER * START * N
    for k in range(M):
        curvature = matrices[H, k, k]
        if curvature <= 0.0:
            z[k] = 0.0
            continue
        row_at = room.matrices_at + NUMBER * (H * N + k) * N
        gradient = vectors[GRADIENT, k] + inner(matrices[H, k], z, row_at, z_at, M, room.arguments)
        value, threshold = z[k] - gradient / curvature, weight / curvature
        if k >= n:
            z[k] = max(value, 0.0)
        elif value > threshold:
            z[k] = value - threshold
        elif value < -threshold:
            z[k] = value + threshold
        else:
            z[k] = 0.0


@no_type_check
def minimise(room, weight, slack, n, M):
    """Set `END` to the minimiser, from `START`; coordinate descent where active sets cycle.

    The list of active unknowns then starts empty: where H is singular, its factor depends on the order.
    """
    if active_set(room, weight, slack, n, M):
        return
    for _ in range(ROUNDS):
        for _ in range(SWEEPS):
            sweep(room, weight, n, M)
        room.counts[ACTIVE] = room.counts[FACTORED] = 0
        if active_set(room, weight, slack, n, M):
            return
    for k in range(M):
        room.vectors[END, k] = room.vectors[START, k]


@no_type_check
def lasso_batch(hs, weights, room, Z):
    """Set row j of Z (p, n) to the minimiser of z'Hz/2 + h_j'z + weight_j ||z||_1; H is the model's.

    hs (p, n), weights (p,).
    """
    n = hs.shape[1]
    for j in range(hs.shape[0]):
        for k in range(n):
            room.vectors[GRADIENT, k], room.vectors[START, k] = hs[j, k], 0.0
        room.counts[ACTIVE] = room.counts[FACTORED] = 0
        minimise(room, weights[j], 0.0, n, n)
        for k in range(n):
            Z[j, k] = room.vectors[END, k]


def _interpreted_seconds(hs: NDArray[np.float64], *rest: object) -> float:
    """About what `lasso_batch` takes interpreted: some active sets a template."""
    return float(hs.shape[0] * (2e-4 + 1e-6 * hs.shape[1] ** 2))


lasso_kernel = Kernel(lasso_batch, _interpreted_seconds, compile_seconds=3.0)
"""`lasso_batch`, interpreted or compiled."""
