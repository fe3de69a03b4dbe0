"""Factors of S(t) and the Hessian of the reduced objective, compiled.

The O(n^3) operations are the factorisation of S(t), its inversion and the Hessian in w, 2 (G + S(t)^-1); they
depend on t alone. This is used twice:

All templates of a set of views start at the same t, the base, and share its Hessian.

At any other t the Hessian is formed only on the working set R: the views with w_j != 0, and those whose
gradient is close to lambda2. With the remaining views N ordered first, S = LL' with L = [[L_N, 0], [., L_R]],
and the block R of S^-1 is (L_R L_R')^-1, the inverse of a trailing block of the factor already available.
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

WORKING_SET_THRESHOLD = 0.97
"""A view with w_j = 0 joins the working set if |gradient_j| exceeds this fraction of lambda2. A lower value
enlarges every Hessian; with a higher one, S(t) is factored again more often because a view enters the set."""
START_SWEEPS = 2
"""Coordinate descent sweeps from the minimiser without ||w||_1: they give the active sets their support."""
NONE, LATEST, BASE = 0, 1, 2
"""Which Hessian in w the model holds: none, that of the most recent t, or that of the base."""

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


class Data(NamedTuple):
    """The reduced problem of one template.

    Attributes
    ----------
    G : float64 (n, n)
        X X'.
    K : float64 (m, n, n)
        X_i X_i' of each modality.
    c : float64 (n,)
        X o.
    target : float
        ||o||^2.
    lambda1, lambda2, lambda3 : float
        The penalties; lambda1, lambda3 > 0.
    """

    G: Floats
    K: Floats
    c: Floats
    target: float
    lambda1: float
    lambda2: float
    lambda3: float


class Point(NamedTuple):
    """A point (w, t) and what follows from it.

    Attributes
    ----------
    w : float64 (n,)
    t : float64 (m,)
        t_i = 2 ||u^i|| / lambda3.
    q : float64 (n,)
        S(t)^-1 w.
    Kq : float64 (m, n)
        Row i is K_i q.
    r : float64 (m,)
        ||X_i'q||.
    Gw : float64 (n,)
        G w.
    """

    w: Floats
    t: Floats
    q: Floats
    Kq: Floats
    r: Floats
    Gw: Floats


class Coupling(NamedTuple):
    """A Cholesky factorisation of S(t), with the working set R ordered last.

    Attributes
    ----------
    t : float64 (m,)
        Where S was factored; t[0] is NaN if there is no valid factor.
    L : float64 (n n,)
        The factor, its rows and columns in the order of `views`; see `convexperc.solvers.newton.lapack`.
    views : int64 (n,)
        The permutation: views outside R first.
    first : int64 (1,)
        Position in `views` at which R begins.
    """

    t: Floats
    L: Floats
    views: Integers
    first: Integers


class Curvature(NamedTuple):
    """The two factorisations of S(t), the base's Hessian, and what the model of the step currently holds.

    Attributes
    ----------
    latest : Coupling
        At the most recent t other than the base.
    base : Coupling
        At the base, without any view left out.
    H : float64 (n, n)
        Hessian in w at the base, 2 (G + S(t)^-1).
    L : float64 (n n,)
        Cholesky factor of `H`.
    matrix_scratch : float64 (n n,)
    vector_scratch : float64 (n,)
    near : int64 (n,)
        1 for the views that the next working set has to contain besides the support of w.
    inside : int64 (n,)
        Scratch: 1 for the views of a set.
    model_views : int64 (n,)
        The first `size` entries are the views of the model's Hessian, in its order.
    size : int64 (1,)
        Number of views in the model.
    owner : int64 (1,)
        `NONE`, `LATEST` or `BASE`: which Hessian in w the model holds.
    """

    latest: Coupling
    base: Coupling
    H: Floats
    L: Floats
    matrix_scratch: Floats
    vector_scratch: Floats
    near: Integers
    inside: Integers
    model_views: Integers
    size: Integers
    owner: Integers


@no_type_check
@njit(cache=True, error_model="numpy")
def new_coupling(n, m):
    """Allocate a factorisation of S(t); none is computed yet."""
    return Coupling(np.full(m, np.nan), np.empty(n * n), np.arange(n), np.zeros(1, np.int64))


@no_type_check
@njit(cache=True, error_model="numpy")
def new_curvature(n, m):
    """Allocate the factorisations and the Hessian; none is computed yet."""
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
    """Order the views: first those outside the working set, then the working set."""
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
    """Factor S(t) = I / lambda1 + sum of t_i K_i in the order of the views; false if Cholesky fails."""
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
    """Overwrite x (n,) by S(t)^-1 x; `row` (n,) is scratch."""
    n, views = x.size, coupling.views
    for a in range(n):
        row[a] = x[views[a]]
    cholesky_solve(coupling.L, n, n, row, work)
    for a in range(n):
        x[views[a]] = row[a]


@no_type_check
@njit(cache=True, error_model="numpy")
def evaluate(data, point, curvature, work):
    """Compute q, Kq, r and Gw at (w, t); false if S(t) is not positive definite."""
    n, latest = point.w.size, curvature.latest
    shared = equal(point.t, curvature.base.t)
    if not shared and not equal(point.t, latest.t):
        choose_views(latest, curvature.near, point.w)
        if curvature.owner[0] == LATEST:
            curvature.owner[0] = NONE
        if not factor(data, point.t, latest, curvature.vector_scratch, work):
            return False
    copy(point.w, point.q)
    solve_coupling(curvature.base if shared else latest, point.q, curvature.vector_scratch, work)
    for i in range(point.t.size):
        symmetric_times(data.K[i], n, n, point.q, point.Kq[i], work)
        point.r[i] = np.sqrt(max(0.0, inner(point.q, point.Kq[i])))
    symmetric_times(data.G, n, n, point.w, point.Gw, work)
    return True


@no_type_check
@njit(cache=True, error_model="numpy")
def curve(data, coupling, matrix_scratch, H, work):
    """Set the block R of H to 2 (G + S(t)^-1), with a relative ridge at rounding level."""
    n, views, first = data.c.size, coupling.views, coupling.first[0]
    size = n - first
    for x in range(size):
        for y in range(x, size):
            matrix_scratch[x * size + y] = coupling.L[(first + x) * n + first + y]
    cholesky_inverse(matrix_scratch, size, size, work)
    for x in range(size):
        row = data.G[views[first + x]]
        for y in range(x, size):
            H[x, y] = 2.0 * (row[views[first + y]] + matrix_scratch[x * size + y])
            H[y, x] = H[x, y]
        H[x, x] *= 1.0 + 1e-15


@no_type_check
@njit(cache=True, error_model="numpy")
def set_base(data, t, curvature, work):
    """Make t the base; false if S(t) or the Hessian there is not positive definite."""
    n, base = data.c.size, curvature.base
    if not factor(data, t, base, curvature.vector_scratch, work):
        return False
    curve(data, base, curvature.matrix_scratch, curvature.H, work)
    for a in range(n):
        copy(curvature.H[a], curvature.L[a * n :])
    if cholesky(curvature.L, n, n, work) != 0:
        base.t[0] = np.nan
        return False
    return True


@no_type_check
@njit(cache=True, error_model="numpy")
def use_base(curvature, model):
    """Copy the base's Hessian in w into the model."""
    n = curvature.vector_scratch.size
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
    for _ in range(START_SWEEPS):
        sweep(model, data.lambda2, n, n)
    minimise(model, data.lambda2, 0.0, n, n)
    copy(model.z[:n], point.w)
    copy(curvature.base.t, point.t)


@no_type_check
@njit(cache=True, error_model="numpy")
def covers(data, point, views, inside):
    """Whether `views` contains every view with w_j != 0 or |gradient_j| > lambda2."""
    inside[:] = 0
    for x in range(views.size):
        inside[views[x]] = 1
    for a in range(inside.size):
        gradient = 2.0 * (point.Gw[a] - data.c[a] + point.q[a])
        if inside[a] == 0 and (point.w[a] != 0.0 or abs(gradient) > data.lambda2):
            return False
    return True


@no_type_check
@njit(cache=True, error_model="numpy")
def factor_again(data, point, curvature, work):
    """Factor S(t) with the working set chosen from the gradient at the point."""
    for a in range(point.w.size):
        gradient = 2.0 * (point.Gw[a] - data.c[a] + point.q[a])
        curvature.near[a] = abs(gradient) > WORKING_SET_THRESHOLD * data.lambda2
    choose_views(curvature.latest, curvature.near, point.w)
    factor(data, point.t, curvature.latest, curvature.vector_scratch, work)
    curvature.owner[0] = NONE


@no_type_check
@njit(cache=True, error_model="numpy")
def curve_model(data, point, curvature, model, old):
    """Give the model the Hessian in w at the point's t, or keep the `old` one; returns the coupling at t."""
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
        curve(data, latest, curvature.matrix_scratch, model.H, model.work)
        working = latest.views[latest.first[0] :]
        copy(working, curvature.model_views)
        curvature.size[0], curvature.owner[0] = working.size, LATEST
        forget(model, 0)
    return latest


@no_type_check
@njit(cache=True, error_model="numpy")
def hessian(data, point, curvature, model, old):
    """Form the Hessian of the smooth part in (w_R, t) at an evaluated point; `old` keeps the block in w."""
    n, m, H = point.w.size, point.t.size, model.H
    coupling = curve_model(data, point, curvature, model, old)
    size, slope, largest = curvature.size[0], curvature.matrix_scratch[:n], 0.0
    forget(model, size)
    for i in range(m):
        copy(point.Kq[i], slope)
        solve_coupling(coupling, slope, curvature.vector_scratch, model.work)
        for k in range(m):
            H[size + i, size + k] = 2.0 * inner(slope, point.Kq[k])
        for x in range(size):
            H[size + i, x] = H[x, size + i] = -2.0 * slope[curvature.model_views[x]]
        largest = max(largest, H[size + i, size + i])
    for i in range(m):
        H[size + i, size + i] += 1e-14 * largest + 1e-300
