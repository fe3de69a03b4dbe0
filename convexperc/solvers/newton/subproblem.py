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
"""Steps of the active set method before coordinate descent takes over: it settles in a few, or cycles."""
SWEEPS = 40
"""Coordinate descent sweeps before the active set method is tried again from their support."""
ROUNDS = 6
"""Such rounds before the last iterate of coordinate descent is returned as it is."""

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


class Model(NamedTuple):
    """The model z'Hz/2 + h'z in N unknowns, its start and minimiser, and the state of the active set method.

    Attributes
    ----------
    H : float64 (N, N)
        Positive semidefinite.
    h : float64 (N,)
    z : float64 (N,)
        The minimiser.
    start : float64 (N,)
        Where to begin; coordinate descent overwrites it.
    Hz : float64 (N,)
        H z; also scratch.
    values : float64 (N,)
        The active unknowns, in the order of `order`.
    factor : float64 (N N + 1,)
        Cholesky factor of the rows and columns of H of the active unknowns, in the order of `order`.
    sign : int64 (N,)
        0 where inactive, +1 or -1 for the sign of z_k, 2 for an active unknown that must be >= 0.
    order : int64 (N,)
        The first `counts[0]` entries are the active unknowns.
    counts : int64 (2,)
        How many unknowns are active, and for how many of them, from the first on, `factor` is up to date. A
        caller that changes rows of H has to call `forget`.
    work : int32 (8,)
        Scratch of the LAPACK calls.
    """

    H: Floats
    h: Floats
    z: Floats
    start: Floats
    Hz: Floats
    values: Floats
    factor: Floats
    sign: Integers
    order: Integers
    counts: Integers
    work: NDArray[np.int32]


@no_type_check
@njit(cache=True, error_model="numpy")
def new_model(N):
    """Allocate a model for N unknowns, all zero."""
    return Model(
        np.zeros((N, N)), np.zeros(N), np.zeros(N), np.zeros(N), np.zeros(N), np.zeros(N),
        np.zeros(N * N + 1), np.zeros(N, np.int64), np.zeros(N, np.int64), np.zeros(2, np.int64),
        np.zeros(8, np.int32),
    )  # fmt: skip


@no_type_check
@njit(cache=True, error_model="numpy")
def forget(model, first):
    """Invalidate the part of the factor that depends on the rows of H from `first` on, which have changed."""
    for x in range(model.counts[1]):
        if model.order[x] >= first:
            model.counts[1] = x
            return


@no_type_check
@njit(cache=True, error_model="numpy")
def arrange(model, N):
    """List the active unknowns: those already listed in their order, then the new ones."""
    count, kept = 0, model.counts[1]
    order, listed = model.order, model.Hz
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
    """Update the factor for the list of active unknowns; false if H is singular on them."""
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
    """Minimise over the active unknowns, with the others at 0; false if H is singular on them."""
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
    """Drop unknowns of the wrong sign, add those whose gradient exceeds its bound; true if none changed."""
    settled = True
    symmetric_times(model.H, N, model.h.size, model.z, model.Hz, model.work)
    for k in range(N):
        gradient = model.h[k] + model.Hz[k]
        if model.sign[k] != 0:
            if model.z[k] * model.sign[k] <= 0:
                model.sign[k], model.z[k], settled = 0, 0.0, False
        elif k < n and abs(gradient) > weight * (1 + 1e-12):
            model.sign[k], settled = (-1 if gradient > 0 else 1), False
        elif k >= n and gradient < -slack:
            model.sign[k], settled = 2, False
    return settled


@no_type_check
@njit(cache=True, error_model="numpy")
def active_set(model, weight, slack, n, N):
    """Primal-dual active set method from the support of z; true if it reached a solution."""
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
    """One sweep of coordinate descent over the first N unknowns of `start`."""
    z = model.start
    for k in range(N):
        curvature = model.H[k, k]
        if curvature <= 0.0:
            z[k] = 0.0
            continue
        gradient = model.h[k] + inner(model.H[k, :N], z[:N])
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
@njit(cache=True, error_model="numpy")
def minimise(model, weight, slack, n, N):
    """Minimise over the first N unknowns, from `start`; coordinate descent where active sets cycle.

    The list of active unknowns then starts empty: where H is singular, its factor depends on the order.
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
    """Set z (N,) to the minimiser of z'Hz/2 + h'z + weight ||z||_1; for callers that are not compiled.

    A compiled function called by other compiled functions must not return arrays to Python: the helpers for
    that can be missing when the two are loaded from caches written by different processes.
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
