"""Proximal Newton on (w, t): all templates of a set of views in one call.

The notation is that of `convexperc.problem.reduction`. Each iteration evaluates q and, at no extra cost, the
duality gap; it then minimises the quadratic model of the smooth part plus lambda2 ||w||_1 over t >= 0. The
equation of t_i is written as 1/||X_i'q|| = 2/lambda3, which is almost linear in t (the secular equation of
trust-region methods). If that step does not decrease the objective, a plain Newton step with backtracking is
taken. From a cold start or a given one, t is held fixed in the first step; the start shared by the templates
already has the minimiser w for its t.

The last step may be a chord step, which reuses the Hessian in w of the previous step. It reduces the gap by
about the same factor as that step.

Source: Lee, Sun and Saunders, Proximal Newton-type methods, SIAM J. Optim. 24 (2014); More and Sorensen,
Computing a trust region step, SIAM J. Sci. Stat. Comput. 4 (1983); Kelley, Solving Nonlinear Equations with
Newton's Method, SIAM (2003), chapter 2.
"""

from typing import NamedTuple, no_type_check

import numpy as np
from numpy.typing import NDArray

from convexperc.kernels.kernel import Kernel
from convexperc.solvers.newton.hessian import (
    WORKING_SET_THRESHOLD,
    evaluate,
    hessian,
    set_base,
    slope,
    start_at_base,
)
from convexperc.solvers.newton.lapack import NUMBER, cholesky, cholesky_solve, inner, symmetric_times
from convexperc.solvers.newton.subproblem import minimise
from convexperc.solvers.newton.workspace import (
    BASE_T,
    END,
    GRADIENT,
    GW,
    IMAGE,
    KQ,
    LAST_T,
    LATEST_T,
    MODEL_VIEWS,
    NEAR,
    SIZE,
    SPARE,
    START,
    Data,
    Grams,
    H,
    Q,
    Templates,
    Z,
    workspace,
)

ROUNDING_TOLERANCE = 4e-15
"""An increase of the objective below this fraction of ||o||^2, 18 units of 2^-52, counts as rounding."""
STAGNATION_ITERATIONS = 12
"""More iterations than this in a row without halving the best gap are stagnation at rounding level: Newton
steps converge quadratically, so that a run that still makes progress halves its gap in fewer."""
CHORD_GAP_FRACTION = 0.1
"""A chord step is taken if the gap predicted for it is below this fraction of the tolerance: a margin of 10
for the error of the prediction."""
HELD, SECULAR, PLAIN = 0, 1, 2
"""The steps tried in turn: t held fixed, the secular equation in t, the plain Newton step."""
CURRENT, TRIAL, BEST = 0, 1, 2
"""The points of a workspace."""


class Rules(NamedTuple):
    """Stopping rules, and the kind of start.

    Attributes
    ----------
    tolerance : float
        Relative duality gap at which a template is solved.
    limit : int
        Largest number of iterations for each template.
    warm : bool
        Whether W and T hold the starting points.
    """

    tolerance: float
    limit: int
    warm: bool


class Pruning(NamedTuple):
    """How the optima of different templates are compared: by F times the template's unit.

    Attributes
    ----------
    units : float64 (p,) or (0,)
        Factor from each template's F to common units; if empty, no template is pruned.
    ceiling : float
        Upper bound of the lowest F*, in common units.
    margin : float
        Relative excess over the ceiling that a lower bound of F* must exceed before its template is pruned.
    """

    units: NDArray[np.float64]
    ceiling: float
    margin: float


NO_PRUNING = Pruning(np.empty(0), np.inf, 0.0)
"""Without units no template is pruned; ceiling and margin have no effect."""


@no_type_check
def copy_point(room, source, target):
    """Copy a point."""
    points = room.points
    for row in range(points.shape[1]):
        for k in range(points.shape[2]):
            points[target, row, k] = points[source, row, k]


@no_type_check
def merit(data, room, p):
    """The reduced objective, w'(G w - 2c + q) + ||o||^2 + lambda2 ||w||_1 + lambda3^2/4 sum_i t_i."""
    total, n, point = data.target, data.c.size, room.points[p]
    for a in range(n):
        term = point[GW, a] - 2.0 * data.c[a] + point[Q, a]
        total += point[Z, a] * term + data.lambda2 * abs(point[Z, a])
    for k in range(n, point.shape[1]):
        total += 0.25 * data.lambda3 * data.lambda3 * point[Z, k]
    return total


@no_type_check
def gap(data, room, p):
    """Return (F, F - D) at u^i = t_i X_i'q and the dual point s (2(X'w - o), -2q), with s making it feasible.

    F - D is computed as a sum of nonnegative terms, without cancellation.
    """
    wGw = cw = qq = size = wv = worst = 0.0
    n, point = data.c.size, room.points[p]
    for a in range(n):
        w, v = point[Z, a], slope(data, point, a)
        wGw += w * point[GW, a]
        cw += w * data.c[a]
        qq += point[Q, a] * point[Q, a]
        size += abs(w)
        wv += w * v
        worst = max(worst, abs(v))
    quadratic = max(wGw - 2.0 * cw + data.target, 0.0) + qq / data.lambda1
    s = max(0.0, data.target - cw) / quadratic if quadratic > 0.0 else 1.0
    if s * worst > data.lambda2:
        s = data.lambda2 / worst
    length = 0.0
    for k in range(n, point.shape[1]):
        length = max(length, point[Q, k])
    if 2.0 * s * length > data.lambda3:
        s = data.lambda3 / (2.0 * length)
    F = quadratic + data.lambda2 * size
    total = (1.0 - s) * (1.0 - s) * quadratic + data.lambda2 * size + s * wv
    for k in range(n, point.shape[1]):
        t, r = point[Z, k], point[Q, k]
        F += data.lambda3 * t * r
        total += t * r * (data.lambda3 - 2.0 * s * r)
    return F, total


@no_type_check
def pose(data, room, step):
    """Set h of the model z'Hz/2 + h'z and its start (w_R, t) for a step; returns the number of unknowns."""
    size, n, N, vectors = room.counts[SIZE], data.c.size, room.vectors.shape[1], room.vectors
    point, views, half = room.points[CURRENT], room.sets[MODEL_VIEWS], 0.5 * data.lambda3
    M = size if step == HELD else size + N - n
    for x in range(size):
        vectors[START, x] = point[Z, views[x]]
    for k in range(n, N):
        vectors[START, size + k - n] = point[Z, k]
    start_at, h_at = room.vectors_at + NUMBER * START * N, room.vectors_at + NUMBER * GRADIENT * N
    H_at = room.matrices_at + NUMBER * H * N * N
    symmetric_times(
        room.matrices[H], H_at, M, vectors[START], start_at, vectors[GRADIENT], h_at, room.arguments
    )
    for x in range(size):
        vectors[GRADIENT, x] = slope(data, point, views[x]) - vectors[GRADIENT, x]
    for x in range(size, M):
        r = point[Q, n + x - size]
        if step == SECULAR:
            rho = r / half
            change = -2.0 * half * half * rho * rho * (rho - 1.0)
        else:
            change = half * half - r * r
        vectors[GRADIENT, x] = change - vectors[GRADIENT, x]
    return M


@no_type_check
def move(room, lambda2, share, n):
    """Set the trial to the point plus `share` times the step; at 1 to its end exactly, to keep zeros exact.

    Also marks, as `NEAR`, the views whose model gradient is close to lambda2, for the next working set.
    """
    size, vectors, points, sets = room.counts[SIZE], room.vectors, room.points, room.sets
    for a in range(n):
        points[TRIAL, Z, a], sets[NEAR, a] = 0.0, 0
    for x in range(size):
        a = sets[MODEL_VIEWS, x]
        if abs(vectors[GRADIENT, x] + vectors[IMAGE, x]) > WORKING_SET_THRESHOLD * lambda2:
            sets[NEAR, a] = 1
        old, z = points[CURRENT, Z, a], vectors[END, x]
        points[TRIAL, Z, a] = z if share == 1.0 else old + share * (z - old)
    for k in range(n, vectors.shape[1]):
        old, z = points[CURRENT, Z, k], vectors[END, size + k - n]
        points[TRIAL, Z, k] = z if share == 1.0 else old + share * (z - old)


@no_type_check
def descend_once(data, room, value, first):
    """Minimise the model and take the step; returns the new objective, or infinity if none decreases it."""
    n, N, size = data.c.size, room.vectors.shape[1], room.counts[SIZE]
    slack = 1e-10 * data.lambda3 * data.lambda3
    for step in range(HELD if first else SECULAR, PLAIN + 1):
        M = pose(data, room, step)
        minimise(room, data.lambda2, slack, size, M)
        if step == HELD:
            for k in range(n, N):
                room.vectors[END, size + k - n] = room.points[CURRENT, Z, k]
        share = 1.0
        for _ in range(12 if step == PLAIN else 1):
            move(room, data.lambda2, share, n)
            if evaluate(data, room, TRIAL):
                reached = merit(data, room, TRIAL)
                if reached <= value + ROUNDING_TOLERANCE * data.target:
                    return reached
            share *= 0.4
    return np.inf


@no_type_check
def solve_one(data, room, rules, hold, ceiling):
    """Solve one template from the current point; with `hold`, the first step keeps t. Fills in the best one.

    Stops early once F - gap, a lower bound of F*, exceeds `ceiling`. Returns the iterations, F and its gap.
    """
    best_F = best_gap = np.inf
    for a in range(data.c.size):
        room.sets[NEAR, a] = 1
    copy_point(room, CURRENT, BEST)
    if not evaluate(data, room, CURRENT):
        return 0, best_F, best_gap
    value, stalled, iteration, chord = merit(data, room, CURRENT), 0, 0, False
    while True:
        F, excess = gap(data, room, CURRENT)
        stalled = 0 if excess < 0.5 * best_gap else stalled + 1
        chord = (
            not chord
            and best_gap < np.inf
            and excess * excess <= CHORD_GAP_FRACTION * rules.tolerance * F * best_gap
        )
        if excess < best_gap:
            best_F, best_gap = F, excess
            copy_point(room, CURRENT, BEST)
        if best_gap <= rules.tolerance * best_F or best_gap <= 1e-15 * data.target:
            break
        if iteration == rules.limit or stalled > STAGNATION_ITERATIONS or best_F - best_gap > ceiling:
            break
        hessian(data, room, CURRENT, chord)
        reached = descend_once(data, room, value, hold and iteration == 0)
        iteration += 1
        if reached < np.inf:
            copy_point(room, TRIAL, CURRENT)
            value = reached
        elif not chord:
            break
    return iteration, best_F, best_gap


@no_type_check
def cold_start(data, room):
    """Set w to the ridge solution, and t_i to 1/m of the root of its equation without the others."""
    n, N, arguments = data.c.size, room.vectors.shape[1], room.arguments
    point, A, m = room.points[CURRENT], room.matrices[SPARE], N - data.c.size
    for a in range(n):
        for b in range(n):
            A[a, b] = data.G[a, b]
        A[a, a] = A[a, a] * (1.0 + 1e-12) + data.lambda1 + 1e-300
        point[Z, a] = data.c[a]
    A_at = room.matrices_at + NUMBER * SPARE * N * N
    w_at = room.points_at + NUMBER * CURRENT * (KQ + m) * N
    if cholesky(A, A_at, n, arguments) == 0:
        cholesky_solve(A, A_at, n, point[Z], w_at, arguments)
    ww = inner(point[Z], point[Z], w_at, w_at, n, arguments)
    q_at = w_at + NUMBER * Q * N
    for i in range(m):
        K, K_at = data.K[i], data.K_at + NUMBER * i * n * n
        symmetric_times(K, K_at, n, point[Z], w_at, point[Q], q_at, arguments)
        square = inner(point[Z], point[Q], w_at, q_at, n, arguments)
        point[Z, n + i] = 0.0
        if square > 0.0:
            alone = (2.0 * np.sqrt(square) / data.lambda3 - 1.0 / data.lambda1) * ww / square
            point[Z, n + i] = max(0.0, alone) / m


@no_type_check
def start(data, room):
    """Start from the base, formed at the t of an earlier answer, or cold; true if t is to be held."""
    if np.isnan(room.vectors[BASE_T, 0]):
        largest, last = 0.0, room.vectors[LAST_T]
        for i in range(data.K.shape[0]):
            largest = max(largest, last[i])
        if largest == 0.0 or not set_base(data, last, room):
            cold_start(data, room)
            return True
    start_at_base(data, room, CURRENT)
    return False


@no_type_check
def begin(data, room, rules, rows, j):
    """Set the current point to the start of template j; true if its t is to be held."""
    if not rules.warm:
        return start(data, room)
    n, points = data.c.size, room.points
    for a in range(n):
        points[CURRENT, Z, a] = rows.W[j, a]
    for k in range(n, room.vectors.shape[1]):
        points[CURRENT, Z, k] = rows.T[j, k - n]
    return True


@no_type_check
def keep(room, rows, j, n):
    """Copy the best point to row j, and its t for the next base, if it is not 0."""
    best, last, positive = room.points[BEST], room.vectors[LAST_T], False
    for a in range(n):
        rows.W[j, a], rows.Q[j, a] = best[Z, a], best[Q, a]
    for k in range(n, room.vectors.shape[1]):
        rows.T[j, k - n] = best[Z, k]
        positive = positive or best[Z, k] > 0.0
    if positive:
        for k in range(n, room.vectors.shape[1]):
            last[k - n] = best[Z, k]


@no_type_check
def solve_batch(grams, templates, order, rules, pruning, memory, rows):
    """Solve the templates of `order` in turn; those of equal lambda1 share a start, unless rows hold them.

    Fills in their rows. A template is pruned when its lower bound exceeds `pruning.ceiling` or the lowest F
    of the templates before it, by `pruning.margin`. Returns the lower one of the two.
    """
    n, lambdas, ceiling, pruned = grams.G.shape[0], templates.lambdas, pruning.ceiling, pruning.units.size > 0
    room = workspace(memory, n, grams.K.shape[0])
    for k in range(order.size):
        j = order[k]
        if k > 0 and lambdas[j, 0] != lambdas[order[k - 1], 0]:
            room.vectors[LATEST_T, 0] = room.vectors[BASE_T, 0] = np.nan
            for i in range(grams.K.shape[0]):
                room.vectors[LAST_T, i] = 0.0
        data = Data(
            grams.G, grams.K, grams.G_at, grams.K_at, templates.C[j], templates.targets[j], lambdas[j, 0],
            lambdas[j, 1], lambdas[j, 2],
        )  # fmt: skip
        hold = begin(data, room, rules, rows, j)
        top = ceiling * (1.0 + pruning.margin) / pruning.units[j] if pruned else np.inf
        iterations, F, excess = solve_one(data, room, rules, hold, top)
        rows.iterations[j], rows.gaps[j, 0], rows.gaps[j, 1] = iterations, F, excess
        if pruned:
            ceiling = min(ceiling, F * pruning.units[j])
        keep(room, rows, j, n)
    return ceiling


def _interpreted_seconds(
    grams: Grams, templates: Templates, order: NDArray[np.int64], *rest: object
) -> float:
    """About what `solve_batch` takes interpreted: some steps a template, each of O(m n^2) operations."""
    m, n = grams.K.shape[:2]
    return float(order.size * (1e-2 + 3e-7 * (m + 3) * n * n))


newton_kernel = Kernel(solve_batch, _interpreted_seconds, compile_seconds=5.0)
"""`solve_batch`, interpreted or compiled."""
