"""The step of the Newton method, compiled.

minimise z'Hz/2 + h'z + weight ||z_1..n||_1 subject to z_n+1 .. z_N >= 0.

Source: Hintermueller, Ito and Kunisch, The primal-dual active set strategy, SIAM J. Optim. 13 (2002).
"""

from typing import NamedTuple, no_type_check

import numpy as np
from numba import njit
from numpy.typing import NDArray

from convexperc.solvers.lapack import cholesky, cholesky_solve

ACTIVE_SET_STEPS = 8
SWEEPS = 40
ROUNDS = 6

Floats = NDArray[np.float64]


class Model(NamedTuple):
    """The model, its start and its minimiser, and room to work: N unknowns."""

    H: Floats
    h: Floats
    z: Floats
    start: Floats
    values: Floats
    block: Floats
    sign: NDArray[np.int64]
    order: NDArray[np.int64]
    work: NDArray[np.int32]
    scalars: Floats


@no_type_check
@njit(cache=True)
def solve_active(model, weight, n, N):
    """Solve on the active set (sign != 0; sign 2 marks z >= 0); returns its size, or -1 if singular."""
    count = 0
    for k in range(N):
        model.z[k] = 0.0
        if model.sign[k] != 0:
            model.order[count] = k
            count += 1
    for x in range(count):
        k = model.order[x]
        model.values[x] = -model.h[k] - (weight * model.sign[k] if k < n else 0.0)
        for y in range(count):
            model.block[x * count + y] = model.H[k, model.order[y]]
    if count > 0:
        if cholesky(model.block, count, count, model.work) != 0:
            return -1
        cholesky_solve(model.block, count, count, model.values, 1, count, model.work)
    for x in range(count):
        model.z[model.order[x]] = model.values[x]
    return count


@no_type_check
@njit(cache=True)
def update_active(model, weight, slack, n, N, count):
    """Drop what has the wrong sign, add what is pulled over its bound; true where nothing changed."""
    settled = True
    for k in range(N):
        if model.sign[k] != 0:
            if model.z[k] * model.sign[k] <= 0:
                model.sign[k], model.z[k], settled = 0, 0.0, False
            continue
        pull = model.h[k]
        for x in range(count):
            pull += model.H[k, model.order[x]] * model.values[x]
        if k < n and abs(pull) > weight * (1 + 1e-12):
            model.sign[k], settled = (-1 if pull > 0 else 1), False
        elif k >= n and pull < -slack:
            model.sign[k], settled = 2, False
    return settled


@no_type_check
@njit(cache=True)
def active_set(model, weight, slack, n, N):
    """Primal-dual active sets from the support of z; true where they settled on a solution."""
    for k in range(N):
        z = model.z[k]
        model.sign[k] = 0 if z == 0 else (2 if k >= n else (1 if z > 0 else -1))
    for _ in range(ACTIVE_SET_STEPS):
        count = solve_active(model, weight, n, N)
        if count < 0:
            return False
        if update_active(model, weight, slack, n, N, count):
            return True
    return False


@no_type_check
@njit(cache=True)
def sweep(model, weight, n, N):
    """One round of coordinate descent on `start`."""
    z = model.start
    for k in range(N):
        curvature = model.H[k, k]
        if curvature <= 0.0:
            z[k] = 0.0
            continue
        pull = model.h[k]
        for y in range(N):
            pull += model.H[k, y] * z[y]
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
@njit(cache=True)
def minimise(model, weight, slack, n, N):
    """Minimise over the first N unknowns, from `start`; coordinate descent where active sets cycle."""
    for k in range(N):
        model.z[k] = model.start[k]
    if active_set(model, weight, slack, n, N):
        return
    for _ in range(ROUNDS):
        for _ in range(SWEEPS):
            sweep(model, weight, n, N)
        for k in range(N):
            model.z[k] = model.start[k]
        if active_set(model, weight, slack, n, N):
            return
    for k in range(N):
        model.z[k] = model.start[k]
