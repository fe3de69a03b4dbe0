"""Factors of S(t) and the Hessian of the reduced objective, compiled.

What costs O(n^3) is a factor of S(t), its inverse and the Hessian in w, 2 (G + S(t)^-1), and all depend on t
alone. Two savings follow.

The templates of a frame start at one t, the base, whose Hessian they share.

Anywhere else the Hessian is formed on the working set R only: where w is not 0, or is pulled nearly enough to
leave it. With the rest N ordered first, S = LL' with L = [[L_N, 0], [., L_R]], and the block R of S^-1 is
(L_R L_R')^-1: the inverse of a small factor that is there already.
"""

from typing import NamedTuple, no_type_check

import numpy as np
from numba import njit
from numpy.typing import NDArray

from convexperc.solvers.newton.lapack import (
    cholesky,
    cholesky_inverse,
    cholesky_solve,
    copy,
    inner,
    symmetric_times,
)
from convexperc.solvers.newton.subproblem import forget, minimise, sweep

NEAR = 0.97
"""A zero of w belongs to the working set where its pull is above this share of lambda2."""
SWEEPS = 2
"""Rounds of coordinate descent from the minimiser without ||w||_1, before active sets take over."""
NONE, LATEST, BASE = 0, 1, 2
"""Whose Hessian in w the model holds: nobody's, that of the t met last, that of the base."""

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


class Data(NamedTuple):
    """One template's reduced problem: G (n, n), K (m, n, n), c (n,), ||o||^2 and the lambdas."""

    G: Floats
    K: Floats
    c: Floats
    target: float
    lambda1: float
    lambda2: float
    lambda3: float


class Point(NamedTuple):
    """A point and what follows from it: q = S(t)^-1 w, K_i q, ||X_i'q||, G w."""

    w: Floats
    t: Floats
    q: Floats
    Kq: Floats
    r: Floats
    Gw: Floats


class Coupling(NamedTuple):
    """S(t) factored: t (NaN: none yet), L (n n,) in the order of `views`, in which R begins at `first`."""

    t: Floats
    L: Floats
    views: Integers
    first: Integers


class Curvature(NamedTuple):
    """The two couplings and the Hessians.

    `H` (n, n) and its factor `L` (n n,) are the base's. The model is about the first `size` of `model_views`,
    and `owner` says whose Hessian in w it has. `near` marks what the next working set must hold; `room` and
    `row` are to be spoilt, and so is `inside`.
    """

    latest: Coupling
    base: Coupling
    H: Floats
    L: Floats
    room: Floats
    row: Floats
    near: Integers
    inside: Integers
    model_views: Integers
    size: Integers
    owner: Integers


@no_type_check
@njit(cache=True, error_model="numpy")
def new_coupling(n, m):
    """Room for a factor of S(t)."""
    return Coupling(np.full(m, np.nan), np.empty(n * n), np.arange(n), np.zeros(1, np.int64))


@no_type_check
@njit(cache=True, error_model="numpy")
def new_curvature(n, m):
    """Room for everything; nothing is made yet."""
    return Curvature(
        new_coupling(n, m), new_coupling(n, m), np.empty((n, n)), np.empty(n * n), np.empty(n * n),
        np.empty(n), np.ones(n, np.int64), np.zeros(n, np.int64), np.arange(n), np.zeros(1, np.int64),
        np.zeros(1, np.int64),
    )  # fmt: skip


@no_type_check
@njit(cache=True, error_model="numpy")
def equal(x, y):
    """Whether every entry is equal; NaN never is."""
    count = 0
    for k in range(x.size):
        count += x[k] == y[k]
    return count == x.size


@no_type_check
@njit(cache=True, error_model="numpy")
def choose_views(coupling, near, w):
    """Order the views: first those that may be left out, then the working set."""
    n, first = w.size, 0
    for k in range(n):
        if near[k] == 0 and w[k] == 0.0:
            coupling.views[first] = k
            first += 1
    coupling.first[0] = first
    for k in range(n):
        if near[k] != 0 or w[k] != 0.0:
            coupling.views[first] = k
            first += 1


@no_type_check
@njit(cache=True, error_model="numpy")
def factor(data, t, coupling, row, work):
    """Factor S(t) = I / lambda1 + sum of t_i K_i in the order of the views; false where it cannot be done."""
    n, L, views = data.c.size, coupling.L, coupling.views
    for x in range(n):
        a = views[x]
        for b in range(n):
            row[b] = 0.0
        row[a] = 1.0 / data.lambda1
        for i in range(t.size):
            if t[i] > 0.0:
                weight, K = t[i], data.K[i, a]
                for b in range(n):
                    row[b] += weight * K[b]
        for y in range(x, n):
            L[x * n + y] = row[views[y]]
    if cholesky(L, n, n, work) != 0:
        coupling.t[0] = np.nan
        return False
    copy(t, coupling.t)
    return True


@no_type_check
@njit(cache=True, error_model="numpy")
def solve_coupling(coupling, x, row, work):
    """Overwrite x by S(t)^-1 x."""
    n, views = x.size, coupling.views
    for a in range(n):
        row[a] = x[views[a]]
    cholesky_solve(coupling.L, n, n, row, work)
    for a in range(n):
        x[views[a]] = row[a]


@no_type_check
@njit(cache=True, error_model="numpy")
def evaluate(data, point, curvature, work):
    """Fill in what follows from (w, t); false where S(t) is not positive definite."""
    n, latest = point.w.size, curvature.latest
    shared = equal(point.t, curvature.base.t)
    if not shared and not equal(point.t, latest.t):
        choose_views(latest, curvature.near, point.w)
        if curvature.owner[0] == LATEST:
            curvature.owner[0] = NONE
        if not factor(data, point.t, latest, curvature.row, work):
            return False
    copy(point.w, point.q)
    solve_coupling(curvature.base if shared else latest, point.q, curvature.row, work)
    for i in range(point.t.size):
        symmetric_times(data.K[i], n, n, point.q, point.Kq[i], work)
        point.r[i] = np.sqrt(max(0.0, inner(point.q, point.Kq[i])))
    symmetric_times(data.G, n, n, point.w, point.Gw, work)
    return True


@no_type_check
@njit(cache=True, error_model="numpy")
def curve(data, coupling, room, H, work):
    """Set the block R of H to 2 (G + S(t)^-1), with a ridge of the size of rounding."""
    n, views, first = data.c.size, coupling.views, coupling.first[0]
    size = n - first
    for x in range(size):
        for y in range(x, size):
            room[x * size + y] = coupling.L[(first + x) * n + first + y]
    cholesky_inverse(room, size, size, work)
    for x in range(size):
        row = data.G[views[first + x]]
        for y in range(x, size):
            H[x, y] = 2.0 * (row[views[first + y]] + room[x * size + y])
            H[y, x] = H[x, y]
        H[x, x] *= 1.0 + 1e-15


@no_type_check
@njit(cache=True, error_model="numpy")
def set_base(data, t, curvature, work):
    """Make t the base; false where one of its factors cannot be made."""
    n, base = data.c.size, curvature.base
    if not factor(data, t, base, curvature.row, work):
        return False
    curve(data, base, curvature.room, curvature.H, work)
    for a in range(n):
        copy(curvature.H[a], curvature.L[a * n :])
    if cholesky(curvature.L, n, n, work) != 0:
        base.t[0] = np.nan
        return False
    return True


@no_type_check
@njit(cache=True, error_model="numpy")
def use_base(curvature, model):
    """Give the model the base's Hessian in w."""
    n = curvature.row.size
    for a in range(n):
        copy(curvature.H[a], model.H[a])
        curvature.model_views[a] = a
    curvature.size[0], curvature.owner[0] = n, BASE
    forget(model, 0)


@no_type_check
@njit(cache=True, error_model="numpy")
def start_at_base(data, point, curvature, model):
    """Set t to the base and w to the minimiser there, found from the smooth minimiser without ||w||_1."""
    n = point.w.size
    use_base(curvature, model)
    for a in range(n):
        model.start[a], model.h[a] = 2.0 * data.c[a], -2.0 * data.c[a]
    cholesky_solve(curvature.L, n, n, model.start, model.work)
    for _ in range(SWEEPS):
        sweep(model, data.lambda2, n, n)
    minimise(model, data.lambda2, 0.0, n, n)
    copy(model.z[:n], point.w)
    copy(curvature.base.t, point.t)


@no_type_check
@njit(cache=True, error_model="numpy")
def covers(data, point, views, inside):
    """Whether the views hold all that are used, or pulled over lambda2."""
    inside[:] = 0
    for x in range(views.size):
        inside[views[x]] = 1
    for a in range(inside.size):
        pull = 2.0 * (point.Gw[a] - data.c[a] + point.q[a])
        if inside[a] == 0 and (point.w[a] != 0.0 or abs(pull) > data.lambda2):
            return False
    return True


@no_type_check
@njit(cache=True, error_model="numpy")
def factor_again(data, point, curvature, work):
    """Factor S(t) with the working set that the point itself asks for."""
    for a in range(point.w.size):
        pull = 2.0 * (point.Gw[a] - data.c[a] + point.q[a])
        curvature.near[a] = abs(pull) > NEAR * data.lambda2
    choose_views(curvature.latest, curvature.near, point.w)
    factor(data, point.t, curvature.latest, curvature.row, work)
    curvature.owner[0] = NONE


@no_type_check
@njit(cache=True, error_model="numpy")
def curve_model(data, point, curvature, model, old):
    """Give the model the Hessian in w at the point's t, or leave the `old` one; returns the coupling at t."""
    latest = curvature.latest
    if equal(point.t, curvature.base.t):
        if curvature.owner[0] != BASE:
            use_base(curvature, model)
        return curvature.base
    if old and covers(data, point, curvature.model_views[: curvature.size[0]], curvature.inside):
        return latest
    known = equal(point.t, latest.t)
    if not known or not covers(data, point, latest.views[latest.first[0] :], curvature.inside):
        factor_again(data, point, curvature, model.work)
    if curvature.owner[0] != LATEST:
        curve(data, latest, curvature.room, model.H, model.work)
        working = latest.views[latest.first[0] :]
        copy(working, curvature.model_views)
        curvature.size[0], curvature.owner[0] = working.size, LATEST
        forget(model, 0)
    return latest


@no_type_check
@njit(cache=True, error_model="numpy")
def hessian(data, point, curvature, model, old):
    """The Hessian of the smooth part in (w_R, t) at a point that was evaluated, or the `old` one in w."""
    n, m, H = point.w.size, point.t.size, model.H
    coupling = curve_model(data, point, curvature, model, old)
    size, slope, largest = curvature.size[0], curvature.room[:n], 0.0
    forget(model, size)
    for i in range(m):
        copy(point.Kq[i], slope)
        solve_coupling(coupling, slope, curvature.row, model.work)
        for k in range(m):
            H[size + i, size + k] = 2.0 * inner(slope, point.Kq[k])
        for x in range(size):
            H[size + i, x] = H[x, size + i] = -2.0 * slope[curvature.model_views[x]]
        largest = max(largest, H[size + i, size + i])
    for i in range(m):
        H[size + i, size + i] += 1e-14 * largest + 1e-300
