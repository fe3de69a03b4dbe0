"""Proximal Newton on (w, t), compiled: all templates of a frame in one call.

The notation is that of `convexperc.reduction`. One iteration evaluates q and the duality gap, which is free,
then minimises the quadratic model of the smooth part plus lambda2 ||w||_1 over t >= 0. In the first one t is
held. The equation of t_i is posed as 1/||X_i'q|| = 2/lambda3, which is almost linear in t (the secular
equation of trust-region methods); where that step does not descend, the plain Newton step is cut back until
it does.

Source: Lee, Sun and Saunders, Proximal Newton-type methods, SIAM J. Optim. 24 (2014); More and Sorensen,
Computing a trust region step, SIAM J. Sci. Stat. Comput. 4 (1983).
"""

from typing import NamedTuple, no_type_check

import numpy as np
from numba import njit
from numpy.typing import NDArray

from convexperc.solvers.lapack import cholesky, cholesky_inverse, cholesky_solve, copy, inner, symmetric_times
from convexperc.solvers.quadratic import Model, minimise

NOISE = 4e-15
"""A rise of the objective below this share of ||o||^2 is rounding."""
PATIENCE = 12
"""Iterations without halving the best gap, after which rounding has won."""
HELD, SECULAR, PLAIN = 0, 1, 2
"""The three steps that are tried in turn."""

Floats = NDArray[np.float64]


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


class Answers(NamedTuple):
    """W (p, n), T (p, m) and Q (p, n); iterations (p,); F and gap (p, 2). W and T may hold the starts."""

    W: Floats
    T: Floats
    Q: Floats
    iterations: NDArray[np.int64]
    gaps: Floats


class Race(NamedTuple):
    """What templates are compared by: F times units (p,) in common; no race where `units` is empty.

    Attributes
    ----------
    units : float64 (p,) or (0,)
    ceiling : float
        In common units.
    margin : float
        How far above, relatively, a template must be seen to be given up.
    """

    units: Floats
    ceiling: float
    margin: float


@no_type_check
@njit(cache=True)
def new_point(n, m):
    """A point with room for its numbers."""
    return Point(np.zeros(n), np.zeros(m), np.zeros(n), np.zeros((m, n)), np.zeros(m), np.zeros(n))


@no_type_check
@njit(cache=True)
def copy_point(source, target):
    """Copy every number."""
    copy(source.w, target.w)
    copy(source.t, target.t)
    copy(source.q, target.q)
    copy(source.r, target.r)
    copy(source.Gw, target.Gw)
    for i in range(source.t.size):
        copy(source.Kq[i], target.Kq[i])


@no_type_check
@njit(cache=True)
def evaluate(data, point, S, model):
    """Factor S(t) and fill in what follows from (w, t); false where S is not positive definite."""
    n, m = point.w.size, point.t.size
    for a in range(n):
        for b in range(n):
            S[a, b] = 0.0
        S[a, a] = 1.0 / data.lambda1
    for i in range(m):
        if point.t[i] > 0.0:
            for a in range(n):
                for b in range(n):
                    S[a, b] += point.t[i] * data.K[i, a, b]
    if cholesky(S, n, n, model.work) != 0:
        return False
    copy(point.w, point.q)
    cholesky_solve(S, n, n, point.q, 1, n, model.work)
    for i in range(m):
        symmetric_times(data.K[i], n, point.q, point.Kq[i], model.work, model.scalars)
        point.r[i] = np.sqrt(max(0.0, inner(point.q, point.Kq[i])))
    symmetric_times(data.G, n, point.w, point.Gw, model.work, model.scalars)
    return True


@no_type_check
@njit(cache=True)
def merit(data, point):
    """The reduced objective."""
    total = data.target
    for a in range(point.w.size):
        pull = point.Gw[a] - 2.0 * data.c[a] + point.q[a]
        total += point.w[a] * pull + data.lambda2 * abs(point.w[a])
    for i in range(point.t.size):
        total += 0.25 * data.lambda3 * data.lambda3 * point.t[i]
    return total


@no_type_check
@njit(cache=True)
def gap(data, point):
    """(F, F - D) at u^i = t_i X_i'q and a = 2(X'w - o), b = -2q, scaled: a sum of terms >= 0."""
    wGw = cw = qq = size = pull = worst = 0.0
    for a in range(point.w.size):
        v = 2.0 * (point.Gw[a] - data.c[a] + point.q[a])
        wGw += point.w[a] * point.Gw[a]
        cw += point.w[a] * data.c[a]
        qq += point.q[a] * point.q[a]
        size += abs(point.w[a])
        pull += point.w[a] * v
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
    total = (1.0 - s) * (1.0 - s) * quadratic + data.lambda2 * size + s * pull
    for i in range(point.t.size):
        F += data.lambda3 * point.t[i] * point.r[i]
        total += point.t[i] * point.r[i] * (data.lambda3 - 2.0 * s * point.r[i])
    return F, total


@no_type_check
@njit(cache=True)
def hessian(data, point, S, M, model):
    """The Hessian of the smooth part, from the factor of S, with a ridge of the size of rounding."""
    n, m, H = point.w.size, point.t.size, model.H
    for a in range(n):
        copy(S[a], M[a])
    cholesky_inverse(M[:n], n, model.work)
    for a in range(n):
        for b in range(n):
            H[a, b] = 2.0 * (data.G[a, b] + M[a, b])
        H[a, a] *= 1.0 + 1e-15
    largest = 0.0
    for i in range(m):
        symmetric_times(M, n, point.Kq[i], M[n + i], model.work, model.scalars)
        for a in range(n):
            H[a, n + i] = -2.0 * M[n + i, a]
            H[n + i, a] = H[a, n + i]
    for i in range(m):
        for k in range(m):
            H[n + i, n + k] = 2.0 * inner(point.Kq[i], M[n + k])
        largest = max(largest, H[n + i, n + i])
    for i in range(m):
        H[n + i, n + i] += 1e-14 * largest + 1e-300


@no_type_check
@njit(cache=True)
def pose(data, point, model, step):
    """Set h of the model z'Hz/2 + h'z, and its start, for one of the three steps."""
    n, m = point.w.size, point.t.size
    half = 0.5 * data.lambda3
    copy(point.w, model.start[:n])
    copy(point.t, model.start[n:])
    for k in range(n + m):
        if k < n:
            pull = 2.0 * (point.Gw[k] - data.c[k] + point.q[k])
        elif step == SECULAR:
            rho = point.r[k - n] / half
            pull = -2.0 * half * half * rho * rho * (rho - 1.0)
        else:
            pull = half * half - point.r[k - n] * point.r[k - n]
        for a in range(n):
            pull -= model.H[k, a] * point.w[a]
        if step != HELD:
            for i in range(m):
                pull -= model.H[k, n + i] * point.t[i]
        model.h[k] = pull


@no_type_check
@njit(cache=True)
def between(start, end, share, result):
    """The point at `share` of the way; exactly `end` at 1, so that zeros stay zeros."""
    for k in range(start.size):
        result[k] = end[k] if share == 1.0 else start[k] + share * (end[k] - start[k])


@no_type_check
@njit(cache=True)
def descend_once(data, point, trial, height, model, S, first):
    """Minimise the model and step there; returns the new height, or infinity where no step descends."""
    n, m = point.w.size, point.t.size
    slack = 1e-10 * data.lambda3 * data.lambda3
    for step in (HELD, SECULAR, PLAIN):
        if step == HELD and not first:
            continue
        pose(data, point, model, step)
        minimise(model, data.lambda2, slack, n, n if step == HELD else n + m)
        if step == HELD:
            copy(point.t, model.z[n:])
        share = 1.0
        for _ in range(12 if step == PLAIN else 1):
            between(point.w, model.z[:n], share, trial.w)
            between(point.t, model.z[n:], share, trial.t)
            if evaluate(data, trial, S, model):
                reached = merit(data, trial)
                if reached <= height + NOISE * data.target:
                    return reached
            share *= 0.4
    return np.inf


@no_type_check
@njit(cache=True)
def solve_one(data, point, trial, best, model, S, M, tolerance, limit, ceiling):
    """One template from the start in `point`; the answer is left in `best`. Returns iterations, F and gap.

    It is given up as soon as F - gap, a lower bound of F*, exceeds `ceiling`.
    """
    best_F = best_gap = np.inf
    copy_point(point, best)
    if not evaluate(data, point, S, model):
        return 0, best_F, best_gap
    height, stalled, iteration = merit(data, point), 0, 0
    while True:
        F, excess = gap(data, point)
        stalled = 0 if excess < 0.5 * best_gap else stalled + 1
        if excess < best_gap:
            best_F, best_gap = F, excess
            copy_point(point, best)
        if best_gap <= tolerance * best_F or best_gap <= 1e-15 * data.target:
            break
        if iteration == limit or stalled > PATIENCE or best_F - best_gap > ceiling:
            break
        hessian(data, point, S, M, model)
        reached = descend_once(data, point, trial, height, model, S, iteration == 0)
        iteration += 1
        if reached == np.inf:
            break
        copy_point(trial, point)
        height = reached
    return iteration, best_F, best_gap


@no_type_check
@njit(cache=True)
def cold_start(data, point, A, model):
    """The w of the ridge problem, and the t at which each modality alone would satisfy its equation."""
    n, m = point.w.size, point.t.size
    for a in range(n):
        copy(data.G[a], A[a])
        A[a, a] = A[a, a] * (1.0 + 1e-12) + data.lambda1 + 1e-300
    copy(data.c, point.w)
    if cholesky(A, n, n, model.work) == 0:
        cholesky_solve(A, n, n, point.w, 1, n, model.work)
    ww = inner(point.w, point.w)
    for i in range(m):
        symmetric_times(data.K[i], n, point.w, point.q, model.work, model.scalars)
        square = inner(point.w, point.q)
        point.t[i] = 0.0
        if square > 0.0:
            alone = (2.0 * np.sqrt(square) / data.lambda3 - 1.0 / data.lambda1) * ww / square
            point.t[i] = max(0.0, alone) / m


@no_type_check
@njit(cache=True)
def solve_batch(G, K, C, targets, lambdas, answers, tolerance, limit, warm, race):
    """Every template in turn; the t of one starts the next, unless `answers` holds the starts (`warm`).

    G (n, n), K (m, n, n), C (p, n) = X o_j, targets (p,) = ||o_j||^2, lambdas (p, 3). In a race, a template
    is given up when it is seen to lie above `race.ceiling`, or above the lowest F of those before it.
    """
    p, n = C.shape
    m = K.shape[0]
    N = n + m
    model = Model(
        np.empty((N, N)), np.empty(N), np.empty(N), np.empty(N), np.empty(N), np.empty(N * N),
        np.zeros(N, np.int64), np.empty(N, np.int64), np.zeros(8, np.int32), np.array([1.0, 0.0]),
    )  # fmt: skip
    S, M, last = np.empty((n, n)), np.empty((N, n)), np.zeros(m)
    point, trial, best = new_point(n, m), new_point(n, m), new_point(n, m)
    ceiling = race.ceiling
    for j in range(p):
        data = Data(G, K, C[j], targets[j], lambdas[j, 0], lambdas[j, 1], lambdas[j, 2])
        if warm:
            copy(answers.W[j], point.w)
            copy(answers.T[j], point.t)
        else:
            cold_start(data, point, S, model)
            if last.max() > 0.0:
                copy(last, point.t)
        top = ceiling / race.units[j] if race.units.size else np.inf
        count, F, excess = solve_one(data, point, trial, best, model, S, M, tolerance, limit, top)
        if race.units.size:
            ceiling = min(ceiling, F * race.units[j] * (1.0 + race.margin))
        answers.iterations[j], answers.gaps[j, 0], answers.gaps[j, 1] = count, F, excess
        copy(best.w, answers.W[j])
        copy(best.t, answers.T[j])
        copy(best.q, answers.Q[j])
        if best.t.max() > 0.0:
            copy(best.t, last)
