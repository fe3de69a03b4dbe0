"""Proximal Newton on (w, t), compiled: all templates of a set of views in one call.

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
from numba import njit
from numpy.typing import NDArray

from convexperc.solvers.newton.hessian import (
    WORKING_SET_THRESHOLD,
    Data,
    Point,
    evaluate,
    hessian,
    new_curvature,
    set_base,
    start_at_base,
)
from convexperc.solvers.newton.lapack import cholesky, cholesky_solve, copy, inner, symmetric_times
from convexperc.solvers.newton.subproblem import minimise, new_model

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


@no_type_check
@njit(cache=True, error_model="numpy")
def new_point(n, m):
    """Allocate a point for n views and m modalities."""
    return Point(np.zeros(n), np.zeros(m), np.zeros(n), np.zeros((m, n)), np.zeros(m), np.zeros(n))


@no_type_check
@njit(cache=True, error_model="numpy")
def copy_point(source, target):
    """Copy all fields of a point."""
    copy(source.w, target.w)
    copy(source.t, target.t)
    copy(source.q, target.q)
    copy(source.r, target.r)
    copy(source.Gw, target.Gw)
    for i in range(source.t.size):
        copy(source.Kq[i], target.Kq[i])


@no_type_check
@njit(cache=True, error_model="numpy")
def merit(data, point):
    """The reduced objective, w'(G w - 2c + q) + ||o||^2 + lambda2 ||w||_1 + lambda3^2/4 sum_i t_i."""
    total = data.target
    for a in range(point.w.size):
        term = point.Gw[a] - 2.0 * data.c[a] + point.q[a]
        total += point.w[a] * term + data.lambda2 * abs(point.w[a])
    for i in range(point.t.size):
        total += 0.25 * data.lambda3 * data.lambda3 * point.t[i]
    return total


@no_type_check
@njit(cache=True, error_model="numpy")
def gap(data, point):
    """Return (F, F - D) at u^i = t_i X_i'q and the dual point s (2(X'w - o), -2q), with s making it feasible.

    F - D is computed as a sum of nonnegative terms, without cancellation.
    """
    wGw = cw = qq = size = wv = worst = 0.0
    for a in range(point.w.size):
        v = 2.0 * (point.Gw[a] - data.c[a] + point.q[a])
        wGw += point.w[a] * point.Gw[a]
        cw += point.w[a] * data.c[a]
        qq += point.q[a] * point.q[a]
        size += abs(point.w[a])
        wv += point.w[a] * v
        worst = max(worst, abs(v))
    quadratic = max(wGw - 2.0 * cw + data.target, 0.0) + qq / data.lambda1
    s = max(0.0, data.target - cw) / quadratic if quadratic > 0.0 else 1.0
    if s * worst > data.lambda2:
        s = data.lambda2 / worst
    length = 0.0
    for i in range(point.t.size):
        length = max(length, point.r[i])
    if 2.0 * s * length > data.lambda3:
        s = data.lambda3 / (2.0 * length)
    F = quadratic + data.lambda2 * size
    total = (1.0 - s) * (1.0 - s) * quadratic + data.lambda2 * size + s * wv
    for i in range(point.t.size):
        F += data.lambda3 * point.t[i] * point.r[i]
        total += point.t[i] * point.r[i] * (data.lambda3 - 2.0 * s * point.r[i])
    return F, total


@no_type_check
@njit(cache=True, error_model="numpy")
def pose(data, point, curvature, model, step):
    """Set h of the model z'Hz/2 + h'z and its start (w_R, t) for a step; returns the number of unknowns."""
    n, m, views = curvature.size[0], point.t.size, curvature.model_views
    half = 0.5 * data.lambda3
    N = n if step == HELD else n + m
    for x in range(n):
        model.start[x] = point.w[views[x]]
    copy(point.t, model.start[n:])
    symmetric_times(model.H, N, model.h.size, model.start, model.h, model.work)
    for x in range(n):
        a = views[x]
        model.h[x] = 2.0 * (point.Gw[a] - data.c[a] + point.q[a]) - model.h[x]
    for i in range(N - n):
        if step == SECULAR:
            rho = point.r[i] / half
            slope = -2.0 * half * half * rho * rho * (rho - 1.0)
        else:
            slope = half * half - point.r[i] * point.r[i]
        model.h[n + i] = slope - model.h[n + i]
    return N


@no_type_check
@njit(cache=True, error_model="numpy")
def move(point, curvature, model, lambda2, share, trial):
    """Set `trial` to the point plus `share` times the step; at 1 to its end exactly, to keep zeros exact.

    Also marks, as `near`, the views whose model gradient is close to lambda2, for the next working set.
    """
    n, views, z = curvature.size[0], curvature.model_views, model.z
    trial.w[:] = 0.0
    curvature.near[:] = 0
    for x in range(n):
        curvature.near[views[x]] = abs(model.h[x] + model.Hz[x]) > WORKING_SET_THRESHOLD * lambda2
        old = point.w[views[x]]
        trial.w[views[x]] = z[x] if share == 1.0 else old + share * (z[x] - old)
    for i in range(trial.t.size):
        old = point.t[i]
        trial.t[i] = z[n + i] if share == 1.0 else old + share * (z[n + i] - old)


@no_type_check
@njit(cache=True, error_model="numpy")
def descend_once(data, point, trial, value, model, curvature, first):
    """Minimise the model and take the step; returns the new objective, or infinity if none decreases it."""
    n = curvature.size[0]
    slack = 1e-10 * data.lambda3 * data.lambda3
    for step in (HELD, SECULAR, PLAIN):
        if step == HELD and not first:
            continue
        N = pose(data, point, curvature, model, step)
        minimise(model, data.lambda2, slack, n, N)
        if step == HELD:
            copy(point.t, model.z[n:])
        share = 1.0
        for _ in range(12 if step == PLAIN else 1):
            move(point, curvature, model, data.lambda2, share, trial)
            if evaluate(data, trial, curvature, model.work):
                reached = merit(data, trial)
                if reached <= value + ROUNDING_TOLERANCE * data.target:
                    return reached
            share *= 0.4
    return np.inf


@no_type_check
@njit(cache=True, error_model="numpy")
def solve_one(data, point, trial, best, model, curvature, rules, hold, ceiling):
    """Solve one template from the start in `point`; with `hold`, the first step keeps t. Fills in `best`.

    Stops early once F - gap, a lower bound of F*, exceeds `ceiling`. Returns the iterations, F and its gap.
    """
    best_F = best_gap = np.inf
    curvature.near[:] = 1
    copy_point(point, best)
    if not evaluate(data, point, curvature, model.work):
        return 0, best_F, best_gap
    value, stalled, iteration, chord = merit(data, point), 0, 0, False
    while True:
        F, excess = gap(data, point)
        stalled = 0 if excess < 0.5 * best_gap else stalled + 1
        chord = (
            not chord
            and best_gap < np.inf
            and excess * excess <= CHORD_GAP_FRACTION * rules.tolerance * F * best_gap
        )
        if excess < best_gap:
            best_F, best_gap = F, excess
            copy_point(point, best)
        if best_gap <= rules.tolerance * best_F or best_gap <= 1e-15 * data.target:
            break
        if iteration == rules.limit or stalled > STAGNATION_ITERATIONS or best_F - best_gap > ceiling:
            break
        hessian(data, point, curvature, model, chord)
        reached = descend_once(data, point, trial, value, model, curvature, hold and iteration == 0)
        iteration += 1
        if reached < np.inf:
            copy_point(trial, point)
            value = reached
        elif not chord:
            break
    return iteration, best_F, best_gap


@no_type_check
@njit(cache=True, error_model="numpy")
def cold_start(data, point, A, work):
    """Set w to the ridge solution, and t_i to 1/m of the root of its equation without the others."""
    n, m = point.w.size, point.t.size
    for a in range(n):
        copy(data.G[a], A[a * n :])
        A[a * n + a] = A[a * n + a] * (1.0 + 1e-12) + data.lambda1 + 1e-300
    copy(data.c, point.w)
    if cholesky(A, n, n, work) == 0:
        cholesky_solve(A, n, n, point.w, work)
    ww = inner(point.w, point.w)
    for i in range(m):
        symmetric_times(data.K[i], n, n, point.w, point.q, work)
        square = inner(point.w, point.q)
        point.t[i] = 0.0
        if square > 0.0:
            alone = (2.0 * np.sqrt(square) / data.lambda3 - 1.0 / data.lambda1) * ww / square
            point.t[i] = max(0.0, alone) / m


@no_type_check
@njit(cache=True, error_model="numpy")
def start(data, point, last, curvature, model):
    """Start from the base, formed at the t of an earlier answer, `last`, or cold; true if t is to be held."""
    if np.isnan(curvature.base.t[0]) and (
        last.max() == 0.0 or not set_base(data, last, curvature, model.work)
    ):
        cold_start(data, point, curvature.matrix_scratch, model.work)
        return True
    start_at_base(data, point, curvature, model)
    return False


@no_type_check
@njit(cache=True, error_model="numpy")
def solve_batch(G, K, C, targets, lambdas, W, T, rules, pruning):
    """Solve the templates in turn; those of equal lambda1 share a start, unless W and T hold the starts.

    G (n, n), K (m, n, n), C (p, n) = X o_j, targets (p,) = ||o_j||^2, lambdas (p, 3). Fills in W (p, n) and
    T (p, m); returns Q (p, n), the iterations (p,), and F with its gap (p, 2). A template is pruned when its
    lower bound exceeds `pruning.ceiling` or the lowest F of the templates before it, by `pruning.margin`.
    """
    p, n = C.shape
    m = K.shape[0]
    Q, iterations, gaps = np.zeros((p, n)), np.zeros(p, np.int64), np.empty((p, 2))
    model, curvature, last = new_model(n + m), new_curvature(n, m), np.zeros(m)
    point, trial, best = new_point(n, m), new_point(n, m), new_point(n, m)
    ceiling = pruning.ceiling
    for j in range(p):
        data = Data(G, K, C[j], targets[j], lambdas[j, 0], lambdas[j, 1], lambdas[j, 2])
        if j > 0 and lambdas[j, 0] != lambdas[j - 1, 0]:
            curvature.latest.t[0] = curvature.base.t[0] = np.nan
            last[:] = 0.0
        hold = rules.warm
        if rules.warm:
            copy(W[j], point.w)
            copy(T[j], point.t)
        else:
            hold = start(data, point, last, curvature, model)
        top = ceiling * (1.0 + pruning.margin) / pruning.units[j] if pruning.units.size else np.inf
        iterations[j], gaps[j, 0], gaps[j, 1] = solve_one(
            data, point, trial, best, model, curvature, rules, hold, top
        )
        if pruning.units.size:
            ceiling = min(ceiling, gaps[j, 0] * pruning.units[j])
        copy(best.w, W[j])
        copy(best.t, T[j])
        copy(best.q, Q[j])
        if best.t.max() > 0.0:
            copy(best.t, last)
    return Q, iterations, gaps
