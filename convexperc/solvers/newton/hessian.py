"""Factors of S(t) and the Hessian of the reduced objective.

The O(n^3) operations are the factorisation of S(t), its inversion and the Hessian in w, 2 (G + S(t)^-1); they
depend on t alone. This is used twice:

All templates of a set of views start at the same t, the base, and share its Hessian.

At any other t the Hessian is formed only on the working set R: the views with w_j != 0, and those whose
gradient is close to lambda2. With the remaining views N ordered first, S = LL' with L = [[L_N, 0], [., L_R]],
and the block R of S^-1 is (L_R L_R')^-1, the inverse of a trailing block of the factor already available.

`which` is 0 for the factor of S at the most recent t other than the base, 1 for that at the base.
"""

from typing import no_type_check

import numpy as np

from convexperc.solvers.newton.lapack import (
    NUMBER,
    cholesky,
    cholesky_inverse,
    cholesky_solve,
    inner,
    symmetric_times,
)
from convexperc.solvers.newton.subproblem import forget, minimise, sweep
from convexperc.solvers.newton.workspace import (
    BASE_FACTOR,
    BASE_H,
    BASE_HESSIAN,
    BASE_T,
    END,
    FIRST,
    GRADIENT,
    GW,
    INSIDE,
    KQ,
    LATEST,
    LATEST_HESSIAN,
    LATEST_T,
    MODEL_VIEWS,
    NEAR,
    NO_HESSIAN,
    OWNER,
    ROW,
    SIZE,
    SLOPE,
    SPARE,
    START,
    VIEWS,
    H,
    Q,
    Z,
)

WORKING_SET_THRESHOLD = 0.97
"""A view with w_j = 0 joins the working set if |gradient_j| exceeds this fraction of lambda2. A lower value
enlarges every Hessian; with a higher one, S(t) is factored again more often because a view enters the set."""
START_SWEEPS = 2
"""Coordinate descent sweeps from the minimiser without ||w||_1: they give the active sets their support."""


@no_type_check
def at_t(room, p, row):
    """Whether a point's t is that of a row of `vectors`; NaN never is."""
    n, N = room.vectors.shape[1] - (room.points.shape[1] - KQ), room.vectors.shape[1]
    for k in range(n, N):  # noqa: SIM110 - Numba compiles no generator
        if room.points[p, Z, k] != room.vectors[row, k - n]:
            return False
    return True


@no_type_check
def choose_views(room, p):
    """Order the views: first those outside the working set, then the working set."""
    sets, points, n, first = room.sets, room.points, room.vectors.shape[1] - (room.points.shape[1] - KQ), 0
    for k in range(n):
        if sets[NEAR, k] == 0 and points[p, Z, k] == 0.0:
            sets[VIEWS, first] = k
            first += 1
    room.counts[FIRST] = first
    for k in range(n):
        if sets[NEAR, k] != 0 or points[p, Z, k] != 0.0:
            sets[VIEWS, first] = k
            first += 1


@no_type_check
def factor(data, t, room, which):
    """Factor S(t) = I / lambda1 + sum of t_i K_i in the order of the views; false if Cholesky fails."""
    n, N, L, K = data.c.size, room.vectors.shape[1], LATEST + which, data.K
    row, views, matrices = room.vectors[ROW], room.sets[VIEWS + which], room.matrices
    for x in range(n):
        a = views[x]
        for b in range(n):
            row[b] = 0.0
        row[a] = 1.0 / data.lambda1
        for i in range(K.shape[0]):
            weight = t[i]
            if weight > 0.0:
                for b in range(n):
                    row[b] += weight * K[i, a, b]
        for y in range(x, n):
            matrices[L, x, y] = row[views[y]]
    if cholesky(matrices[L], room.matrices_at + NUMBER * L * N * N, n, room.arguments) != 0:
        room.vectors[LATEST_T + which, 0] = np.nan
        return False
    for i in range(K.shape[0]):
        room.vectors[LATEST_T + which, i] = t[i]
    return True


@no_type_check
def solve_coupling(room, which, x, n):
    """Overwrite x (n,) by S(t)^-1 x."""
    N, row, views = room.vectors.shape[1], room.vectors[ROW], room.sets[VIEWS + which]
    for a in range(n):
        row[a] = x[views[a]]
    L, L_at = room.matrices[LATEST + which], room.matrices_at + NUMBER * (LATEST + which) * N * N
    cholesky_solve(L, L_at, n, row, room.vectors_at + NUMBER * ROW * N, room.arguments)
    for a in range(n):
        x[views[a]] = row[a]


@no_type_check
def evaluate(data, room, p):
    """Compute q, Kq, r and Gw at the (w, t) of a point; false if S(t) is not positive definite."""
    n, m, N, arguments = data.c.size, data.K.shape[0], room.vectors.shape[1], room.arguments
    point, which = room.points[p], 1 if at_t(room, p, BASE_T) else 0
    if which == 0 and not at_t(room, p, LATEST_T):
        choose_views(room, p)
        if room.counts[OWNER] == LATEST_HESSIAN:
            room.counts[OWNER] = NO_HESSIAN
        if not factor(data, point[Z, n:], room, 0):
            return False
    for a in range(n):
        point[Q, a] = point[Z, a]
    solve_coupling(room, which, point[Q], n)
    point_at = room.points_at + NUMBER * p * (KQ + m) * N
    q_at = point_at + NUMBER * Q * N
    for i in range(m):
        Kq_at = point_at + NUMBER * (KQ + i) * N
        K, K_at = data.K[i], data.K_at + NUMBER * i * n * n
        symmetric_times(K, K_at, n, point[Q], q_at, point[KQ + i], Kq_at, arguments)
        point[Q, n + i] = np.sqrt(max(0.0, inner(point[Q], point[KQ + i], q_at, Kq_at, n, arguments)))
    Gw_at = point_at + NUMBER * GW * N
    symmetric_times(data.G, data.G_at, n, point[Z], point_at, point[GW], Gw_at, arguments)
    return True


@no_type_check
def curve(data, room, which, target):
    """Set the leading block of a matrix to the block R of 2 (G + S(t)^-1), with a ridge at rounding level."""
    n, N, matrices, views = data.c.size, room.vectors.shape[1], room.matrices, room.sets[VIEWS + which]
    first = room.counts[FIRST + which]
    size = n - first
    for x in range(size):
        for y in range(x, size):
            matrices[SPARE, x, y] = matrices[LATEST + which, first + x, first + y]
    cholesky_inverse(matrices[SPARE], room.matrices_at + NUMBER * SPARE * N * N, size, room.arguments)
    for x in range(size):
        a = views[first + x]
        for y in range(x, size):
            value = 2.0 * (data.G[a, views[first + y]] + matrices[SPARE, x, y])
            matrices[target, x, y] = value
            matrices[target, y, x] = value
        matrices[target, x, x] *= 1.0 + 1e-15


@no_type_check
def set_base(data, t, room):
    """Make t the base; false if S(t) or the Hessian there is not positive definite."""
    n, N, matrices = data.c.size, room.vectors.shape[1], room.matrices
    if not factor(data, t, room, 1):
        return False
    curve(data, room, 1, BASE_H)
    if room.counts[OWNER] == BASE_HESSIAN:
        room.counts[OWNER] = NO_HESSIAN
    for a in range(n):
        for b in range(n):
            matrices[BASE_FACTOR, a, b] = matrices[BASE_H, a, b]
    factor_at = room.matrices_at + NUMBER * BASE_FACTOR * N * N
    if cholesky(matrices[BASE_FACTOR], factor_at, n, room.arguments) != 0:
        room.vectors[BASE_T, 0] = np.nan
        return False
    return True


@no_type_check
def use_base(room, n):
    """Copy the base's Hessian in w into the model."""
    if room.counts[OWNER] == BASE_HESSIAN:
        return
    for a in range(n):
        for b in range(n):
            room.matrices[H, a, b] = room.matrices[BASE_H, a, b]
        room.sets[MODEL_VIEWS, a] = a
    room.counts[SIZE], room.counts[OWNER] = n, BASE_HESSIAN
    forget(room, 0)


@no_type_check
def start_at_base(data, room, p):
    """Set t to the base and w to the minimiser there, found from the smooth minimiser without ||w||_1."""
    n, N, vectors = data.c.size, room.vectors.shape[1], room.vectors
    use_base(room, n)
    for a in range(n):
        vectors[START, a], vectors[GRADIENT, a] = 2.0 * data.c[a], -2.0 * data.c[a]
    factor_at = room.matrices_at + NUMBER * BASE_FACTOR * N * N
    start_at = room.vectors_at + NUMBER * START * N
    cholesky_solve(room.matrices[BASE_FACTOR], factor_at, n, vectors[START], start_at, room.arguments)
    for _ in range(START_SWEEPS):
        sweep(room, data.lambda2, n, n)
    minimise(room, data.lambda2, 0.0, n, n)
    for a in range(n):
        room.points[p, Z, a] = vectors[END, a]
    for k in range(n, N):
        room.points[p, Z, k] = vectors[BASE_T, k - n]


@no_type_check
def slope(data, point, a):
    """The gradient of the smooth part in w_a."""
    return 2.0 * (point[GW, a] - data.c[a] + point[Q, a])


@no_type_check
def covers(data, room, p, views, first, last):
    """Whether entries first .. last - 1 of a set hold every view with w_j != 0 or |gradient_j| > lambda2."""
    point, inside, n = room.points[p], room.sets[INSIDE], data.c.size
    for a in range(n):
        inside[a] = 0
    for x in range(first, last):
        inside[room.sets[views, x]] = 1
    for a in range(n):
        if inside[a] == 0 and (point[Z, a] != 0.0 or abs(slope(data, point, a)) > data.lambda2):
            return False
    return True


@no_type_check
def factor_again(data, room, p):
    """Factor S(t) with the working set chosen from the gradient at the point."""
    n, point = data.c.size, room.points[p]
    for a in range(n):
        near = abs(slope(data, point, a)) > WORKING_SET_THRESHOLD * data.lambda2
        room.sets[NEAR, a] = 1 if near else 0
    choose_views(room, p)
    factor(data, point[Z, n:], room, 0)
    room.counts[OWNER] = NO_HESSIAN


@no_type_check
def curve_model(data, room, p, old):
    """Give the model the Hessian in w at the point's t, or keep the `old` one; returns `which` of t."""
    n, counts, sets = data.c.size, room.counts, room.sets
    if at_t(room, p, BASE_T):
        use_base(room, n)
        return 1
    if old and covers(data, room, p, MODEL_VIEWS, 0, counts[SIZE]):
        return 0
    if not at_t(room, p, LATEST_T) or not covers(data, room, p, VIEWS, counts[FIRST], n):
        factor_again(data, room, p)
    if counts[OWNER] != LATEST_HESSIAN:
        curve(data, room, 0, H)
        size = n - counts[FIRST]
        for x in range(size):
            sets[MODEL_VIEWS, x] = sets[VIEWS, counts[FIRST] + x]
        counts[SIZE], counts[OWNER] = size, LATEST_HESSIAN
        forget(room, 0)
    return 0


@no_type_check
def hessian(data, room, p, old):
    """Form the Hessian of the smooth part in (w_R, t) at an evaluated point; `old` keeps the block in w."""
    n, m, N, matrices, largest = data.c.size, data.K.shape[0], room.vectors.shape[1], room.matrices, 0.0
    which = curve_model(data, room, p, old)
    size, column, point = room.counts[SIZE], room.vectors[SLOPE], room.points[p]
    column_at = room.vectors_at + NUMBER * SLOPE * N
    point_at = room.points_at + NUMBER * p * (KQ + m) * N
    forget(room, size)
    for i in range(m):
        for a in range(n):
            column[a] = point[KQ + i, a]
        solve_coupling(room, which, column, n)
        for k in range(m):
            Kq_at = point_at + NUMBER * (KQ + k) * N
            value = 2.0 * inner(column, point[KQ + k], column_at, Kq_at, n, room.arguments)
            matrices[H, size + i, size + k] = value
        for x in range(size):
            value = -2.0 * column[room.sets[MODEL_VIEWS, x]]
            matrices[H, size + i, x] = value
            matrices[H, x, size + i] = value
        largest = max(largest, matrices[H, size + i, size + i])
    for i in range(m):
        matrices[H, size + i, size + i] += 1e-14 * largest + 1e-300
