"""The step of the Newton method, compiled.

minimise z'Hz/2 + h'z + weight ||z_1..n||_1 subject to z_n+1 .. z_N >= 0.

Source: Hintermueller, Ito and Kunisch, The primal-dual active set strategy, SIAM J. Optim. 13 (2002).
"""

from typing import NamedTuple, no_type_check

import numpy as np
from numba import njit
from numpy.typing import NDArray

from convexperc.solvers.newton.lapack import cholesky_extend, cholesky_solve, copy, inner, symmetric_times

ACTIVE_SET_STEPS = 8
SWEEPS = 40
ROUNDS = 6

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


class Model(NamedTuple):
    """The model, its start and its minimiser, and room to work: all sizes are those of N unknowns.

    `order` lists the active unknowns, `counts` holds how many they are and for how many of them, from the
    first on, `factor` still is the Cholesky factor of H: the caller forgets those whose rows of H it changes.
    """

    H: Floats
    h: Floats
    z: Floats
    start: Floats
    pull: Floats
    values: Floats
    factor: Floats
    sign: Integers
    order: Integers
    counts: Integers
    work: NDArray[np.int32]


@no_type_check
@njit(cache=True, error_model="numpy")
def new_model(N):
    """A model with room for N unknowns."""
    return Model(
        np.zeros((N, N)), np.zeros(N), np.zeros(N), np.zeros(N), np.zeros(N), np.zeros(N),
        np.zeros(N * N + 1), np.zeros(N, np.int64), np.zeros(N, np.int64), np.zeros(2, np.int64),
        np.zeros(8, np.int32),
    )  # fmt: skip


@no_type_check
@njit(cache=True, error_model="numpy")
def forget(model, first):
    """The rows of H from `first` on have changed: keep of the factor what comes before them."""
    for x in range(model.counts[1]):
        if model.order[x] >= first:
            model.counts[1] = x
            return


@no_type_check
@njit(cache=True, error_model="numpy")
def arrange(model, N):
    """List the unknowns of sign != 0: the old ones in their old order, then the new ones."""
    count, kept = 0, model.counts[1]
    order, listed = model.order, model.pull
    for k in range(N):
        listed[k] = 0.0
    for x in range(model.counts[0]):
        k = order[x]
        if k < N and model.sign[k] != 0:
            order[count], listed[k] = k, 1.0
            count += 1
        else:
            kept = min(kept, count)
    for k in range(N):
        if model.sign[k] != 0 and listed[k] == 0.0:
            order[count] = k
            count += 1
    model.counts[0], model.counts[1] = count, kept


@no_type_check
@njit(cache=True, error_model="numpy")
def factor_active(model):
    """Bring the factor up to date with the list; false where H is singular there."""
    count, kept = model.counts
    stride, order, factor = model.h.size, model.order, model.factor
    if kept == count:
        return True
    for y in range(count):
        row = model.H[order[y]]
        for x in range(max(y, kept), count):
            factor[y * stride + x] = row[order[x]]
    if cholesky_extend(factor, kept, count, stride, model.work) != 0:
        model.counts[1] = 0
        return False
    model.counts[1] = count
    return True


@no_type_check
@njit(cache=True, error_model="numpy")
def solve_active(model, weight, n, N):
    """Solve on the active set (sign != 0; sign 2 marks z >= 0); false where H is singular there."""
    arrange(model, N)
    if not factor_active(model):
        return False
    count = model.counts[0]
    for x in range(count):
        k = model.order[x]
        model.values[x] = -model.h[k] - (weight * model.sign[k] if k < n else 0.0)
    cholesky_solve(model.factor, count, model.h.size, model.values, model.work)
    for k in range(N):
        model.z[k] = 0.0
    for x in range(count):
        model.z[model.order[x]] = model.values[x]
    return True


@no_type_check
@njit(cache=True, error_model="numpy")
def update_active(model, weight, slack, n, N):
    """Drop what has the wrong sign, add what is pulled over its bound; true where nothing changed."""
    settled = True
    symmetric_times(model.H, N, model.h.size, model.z, model.pull, model.work)
    for k in range(N):
        pull = model.h[k] + model.pull[k]
        if model.sign[k] != 0:
            if model.z[k] * model.sign[k] <= 0:
                model.sign[k], model.z[k], settled = 0, 0.0, False
        elif k < n and abs(pull) > weight * (1 + 1e-12):
            model.sign[k], settled = (-1 if pull > 0 else 1), False
        elif k >= n and pull < -slack:
            model.sign[k], settled = 2, False
    return settled


@no_type_check
@njit(cache=True, error_model="numpy")
def active_set(model, weight, slack, n, N):
    """Primal-dual active sets from the support of z; true where they settled on a solution."""
    for k in range(N):
        z = model.z[k]
        model.sign[k] = 0 if z == 0 else (2 if k >= n else (1 if z > 0 else -1))
    for _ in range(ACTIVE_SET_STEPS):
        if not solve_active(model, weight, n, N):
            return False
        if update_active(model, weight, slack, n, N):
            return True
    return False


@no_type_check
@njit(cache=True, error_model="numpy")
def sweep(model, weight, n, N):
    """One round of coordinate descent on `start`."""
    z = model.start
    for k in range(N):
        curvature = model.H[k, k]
        if curvature <= 0.0:
            z[k] = 0.0
            continue
        pull = model.h[k] + inner(model.H[k, :N], z[:N])
        value, threshold = z[k] - pull / curvature, weight / curvature
        if k >= n:
            z[k] = max(value, 0.0)
        elif value > threshold:
            z[k] = value - threshold
        elif value < -threshold:
            z[k] = value + threshold
        else:
            z[k] = 0.0


@no_type_check
@njit(cache=True, error_model="numpy")
def minimise(model, weight, slack, n, N):
    """Minimise over the first N unknowns, from `start`; coordinate descent where active sets cycle.

    The list of the active is then begun anew: where H is singular, its factor depends on the order.
    """
    copy(model.start[:N], model.z)
    if active_set(model, weight, slack, n, N):
        return
    for _ in range(ROUNDS):
        for _ in range(SWEEPS):
            sweep(model, weight, n, N)
        copy(model.start[:N], model.z)
        model.counts[:] = 0
        if active_set(model, weight, slack, n, N):
            return
    copy(model.start[:N], model.z)


@no_type_check
@njit(cache=True, error_model="numpy")
def lasso(H, h, weight, z):
    """Set z to the minimiser of z'Hz/2 + h'z + weight ||z||_1; for callers that are not compiled.

    A compiled function that compiled ones call must not hand arrays to Python: what it needs for that can be
    lost where the two come from the disk, cached by different processes.
    """
    model = new_model(h.size)
    model.H[:] = H
    model.h[:] = h
    minimise(model, weight, 0.0, h.size, h.size)
    copy(model.z, z)


@no_type_check
@njit(cache=True, error_model="numpy")
def lasso_batch(H, hs, weights, Z):
    """`lasso` for every row of hs (p, n) and Z (p, n), with weights (p,); H is shared."""
    model = new_model(H.shape[0])
    model.H[:] = H
    for j in range(hs.shape[0]):
        model.h[:] = hs[j]
        model.start[:] = 0.0
        model.counts[:] = 0
        minimise(model, weights[j], 0.0, H.shape[0], H.shape[0])
        copy(model.z, Z[j])
