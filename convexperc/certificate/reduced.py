"""Bounds of F* from the reduced data alone, compiled: one answer in time O(m n^2), rounding included.

The point is w as given and u^i = t_i X_i' q; the dual point is a = 2(X'w - o) and one of

    ``coupling``  b = -2 q,               v = X a - b enclosed,
    ``slack``     v in [-lambda2, lambda2] as floats,  b = X a - v enclosed,

scaled until it is feasible by proof. None is ever formed: with y = G w - c and z_i = K_i q,

    ||X'w - o||^2 = w'(y - c) + ||o||^2,   X a = 2 y,   X u - w = sum_i t_i z_i - w,   ||X_i' q||^2 = q'z_i,

and F - D is the sum of terms >= 0 of `convexperc.certificate.duality`. Everything that is not exact is
bounded a priori: an entry of G, K_i or c is off by at most gamma_k times the lengths of its two vectors
(`Reduction.depth`); docs/rounding.md has the lemmas.

Source: Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., section 3.1 (gamma_k).
"""

from typing import no_type_check

import numpy as np
from numpy.typing import NDArray

from convexperc.certificate.cases import Cases, GramBounds, Value, case_of, forget, room_in
from convexperc.certificate.rounding import U
from convexperc.kernels.kernel import Kernel

LARGEST_NUMBER = 2.0**100
"""Numbers beyond this, or below its inverse and not 0, are left out here: products might underflow."""
UNDERFLOW_SUM = 2.0**-300
"""More than all underflows of one bound together."""


@no_type_check
def bound_reduced(shared, cases, order, tolerance, units, most, numbers, bounds):
    """Fill in `bounds` for the templates of `order`.

    The search for a dual point ends with a gap within the relative `tolerance`, or with a lower bound that is
    more than `most` in common units, if there are any. Returns for how many templates it did not end so.
    """
    missed, room = 0, room_in(numbers, cases.W.shape[1], cases.T.shape[1])
    for k in range(order.size):
        j = order[k]
        forget(bounds, j)
        case, found = case_of(cases, j), False
        if case.lambdas[0] > 0.0 and case.lambdas[2] > 0.0 and in_range(case):
            enough = most / units[j] if units.size > 0 else np.inf
            found = _bound_one(shared, case, tolerance, enough, room, bounds, j)
        missed += 0 if found else 1
    return missed


@no_type_check
def in_range(case):
    """Whether t >= 0, and every number is 0 or far from overflow and underflow (Lemma R50)."""
    lambdas, t = case.lambdas, case.t
    for k in range(3):
        if not (1.0 / LARGEST_NUMBER <= lambdas[k] <= LARGEST_NUMBER or lambdas[k] == 0.0):
            return False
    for i in range(t.size):
        if not 0.0 <= t[i] <= LARGEST_NUMBER:
            return False
    for x in (case.w, case.q):
        for k in range(x.size):
            if not abs(x[k]) <= LARGEST_NUMBER:
                return False
    return True


@no_type_check
def _bound_one(shared, case, tolerance, enough, room, bounds, j):
    """Bound one template's optimum and gap by the dual point that suffices (Lemma R48); whether one does."""
    value, best, found = value_bounds(shared, case, room), np.inf, False
    for kind in range(3):
        if kind == 0:
            _coupling(shared, case, value, room)
        else:
            _slack(shared, case, value, kind == 2, room)
        total, s = _gap(shared, case, value, room)
        if total < np.inf:
            _zeros(shared, case.lambdas, total, s, room, bounds, j)
        best = min(best, total)
        if best <= tolerance * value.lower or value.lower - best > enough:
            found = True
            break
    for i in range(case.t.size):
        middle = 0.5 * (room.low[i] + room.high[i]) if room.tau[i] != 0.0 else 0.0  # not what underflow adds
        bounds.modality_norms[j, i] = case.t[i] * middle
    bounds.upper[j], bounds.gap[j] = value.upper, (best + value.stored) * (1.0 + 4 * U)
    bounds.lower[j] = max(0.0, (value.lower - best) - 8 * U * (value.lower + best) - UNDERFLOW_SUM)
    return found


@no_type_check
def _times(A, x, y):
    """Set y = A x for a symmetric A."""
    for a in range(y.size):
        y[a] = 0.0
    for k in range(x.size):
        if x[k] != 0.0:
            for a in range(y.size):
                y[a] += A[k, a] * x[k]


@no_type_check
def _square(x):
    return x * x


@no_type_check
def _inner(x, y):
    total = 0.0
    for k in range(x.size):
        total += x[k] * y[k]
    return total


@no_type_check
def value_bounds(shared, case, room):
    """Bound F(w, u), and leave y, z, e, tau and the bounds of ||X_i'q|| in `room` (Lemma R41)."""
    c, target, lambdas, w, t, q = case
    n, m, g = w.size, t.size, shared.gamma
    omega = np.sqrt(target) * (1.0 + g) + UNDERFLOW_SUM
    rho, size = omega, 0.0
    for a in range(n):
        rho += abs(w[a]) * shared.rows[a]
        size += abs(w[a])
    _times(shared.G, w, room.y)
    loss, linear = target, 0.0
    for a in range(n):
        room.y[a] -= c[a]
        loss += w[a] * (room.y[a] - c[a])
        linear += c[a] * w[a]
        room.e[a], room.e_error[a] = -w[a], g * abs(w[a]) + UNDERFLOW_SUM
    low = high = moved = spread = 0.0
    for i in range(m):
        _times(shared.K[i], q, room.z[i])
        square, tau = _inner(q, room.z[i]), 0.0
        for a in range(n):
            tau += abs(q[a]) * shared.lengths[i, a]
        error = g * tau * tau + UNDERFLOW_SUM
        room.tau[i] = tau
        room.low[i] = np.sqrt(max(0.0, square - error)) * (1.0 - 4 * U)
        room.high[i] = np.sqrt(max(0.0, square) + error) * (1.0 + 4 * U)
        low += t[i] * room.low[i]
        high += t[i] * room.high[i]
        moved += g * t[i] * tau
        spread += shared.blocks[i] * g * t[i] * tau
        for a in range(n):
            room.e[a] += t[i] * room.z[i, a]
            room.e_error[a] += g * t[i] * shared.lengths[i, a] * tau
    near = far = 0.0
    for a in range(n):
        near += _square(max(0.0, abs(room.e[a]) - room.e_error[a]))
        far += _square(abs(room.e[a]) + room.e_error[a])
    error = g * rho * rho + UNDERFLOW_SUM
    most = max(0.0, loss + error)
    lower = max(0.0, loss - error) + lambdas[0] * near + lambdas[1] * size + lambdas[2] * low
    upper = most + lambdas[0] * far + lambdas[1] * size + lambdas[2] * high
    stored = (lambdas[0] * (2.0 * np.sqrt(far) * spread + spread * spread) + lambdas[2] * moved) * (1.0 + g)
    return Value(
        most,
        max(0.0, lower * (1.0 - g) - UNDERFLOW_SUM),
        (upper + stored) * (1.0 + g) + UNDERFLOW_SUM,
        stored,
        rho,
        linear,
    )


@no_type_check
def _coupling(shared, case, value, room):
    """b = -2 q, v = 2 y + 2 q (Lemma R45)."""
    w, q = case.w, case.q
    for a in range(w.size):
        room.b[a], room.b_error[a] = -2.0 * q[a], 0.0
        room.v[a] = 2.0 * (room.y[a] + q[a])
        room.v_error[a] = (
            2.0 * shared.gamma * (shared.rows[a] * value.rho + abs(room.v[a]) + abs(q[a])) + UNDERFLOW_SUM
        )
    for i in range(room.z.shape[0]):
        room.reach[i] = 2.0 * room.high[i]
        room.pull[i] = -2.0 * room.low[i] * room.low[i]


@no_type_check
def _slack(shared, case, value, by_sign, room):
    """v = 2 y - b cut to [-lambda2, lambda2], or -lambda2 sign(w_j); b = 2 y - v (Lemma R46)."""
    g, w, lambdas = shared.gamma, case.w, case.lambdas
    for a in range(w.size):
        v = min(max(2.0 * room.y[a] - room.b[a], -lambdas[1]), lambdas[1])
        if by_sign and w[a] != 0.0:
            v = -lambdas[1] if w[a] > 0.0 else lambdas[1]
        room.v[a], room.v_error[a] = v, 0.0
        room.b[a] = 2.0 * room.y[a] - v
        room.b_error[a] = 2.0 * g * (shared.rows[a] * value.rho + abs(room.b[a]) + abs(v)) + UNDERFLOW_SUM
    for i in range(room.z.shape[0]):
        _times(shared.K[i], room.b, room.Kb[i])
        tau = extra = 0.0
        for a in range(w.size):
            tau += abs(room.b[a]) * shared.lengths[i, a]
            extra += room.b_error[a] * shared.lengths[i, a]
        square = max(0.0, _inner(room.b, room.Kb[i])) + g * tau * tau + UNDERFLOW_SUM
        room.reach[i] = (np.sqrt(square) + extra) * (1.0 + g)
        error = g * room.tau[i] * tau + (1.0 + g) * extra * room.tau[i] + UNDERFLOW_SUM
        room.pull[i] = _inner(room.z[i], room.b) + error


@no_type_check
def _gap(shared, case, value, room):
    """Bound F - D at (s a, s b); returns it with s, or infinity where no s > 0 is feasible (Lemma R47)."""
    w, t, target = case.w, case.t, case.target
    n, m, g = w.size, t.size, shared.gamma
    one, two, three = case.lambdas
    square = worst = 0.0
    for a in range(n):
        square += room.b[a] * room.b[a]
        worst = max(worst, abs(room.v[a]) + room.v_error[a])
    quadratic = value.loss + 0.25 * square / one
    s = max(0.0, target - value.linear) / quadratic if quadratic > 0.0 else 1.0
    if s * worst * (1.0 + 4 * U) > two:
        s = two / worst * (1.0 - 16 * U)
    for i in range(m):
        if s * room.reach[i] * (1.0 + 4 * U) > three:
            s = three / room.reach[i] * (1.0 - 16 * U)
    if not 0.0 < s <= LARGEST_NUMBER:
        return np.inf, 0.0
    coupling = views = modalities = 0.0
    for a in range(n):
        half = 0.5 * s * room.b[a] / one
        error = room.e_error[a] + 0.5 * s * room.b_error[a] / one + 8 * U * (abs(half) + abs(room.e[a]))
        coupling += _square(abs(room.e[a] - half) + error)
        toward = s * room.v[a] if w[a] > 0.0 else -s * room.v[a]
        slack = two + toward + s * room.v_error[a] + 8 * U * (two + abs(toward))
        views += abs(w[a]) * max(0.0, slack)
    for i in range(m):
        if t[i] > 0.0:
            held, pulled = three * room.high[i], s * room.pull[i]
            modalities += t[i] * max(0.0, held + pulled + 8 * U * (held + abs(pulled)))
    total = _square(1.0 - s) * value.loss + one * coupling + views + modalities
    return total * (1.0 + g) + 4 * U * U * value.loss + UNDERFLOW_SUM, s


@no_type_check
def _zeros(shared, lambdas, gap, s, room, bounds, j):
    """Mark the views and modalities that no optimum uses; see `screening.proved_zeros` (Lemma R49)."""
    root = 2.0 * np.sqrt(gap) * (1.0 + 2.0**-40)
    for a in range(room.v.size):
        radius = root * np.sqrt(_square(shared.rows[a]) + lambdas[0]) * (1.0 + 2.0**-40)
        if (s * (abs(room.v[a]) + room.v_error[a]) + radius) * (1.0 + 2.0**-40) < lambdas[1]:
            bounds.zero_views[j, a] = True
    for i in range(room.reach.size):
        radius = root * np.sqrt(lambdas[0]) * shared.blocks[i] * (1.0 + 2.0**-40)
        if (s * room.reach[i] + radius) * (1.0 + 2.0**-40) < lambdas[2]:
            bounds.zero_modalities[j, i] = True


def _interpreted_seconds(shared: GramBounds, cases: Cases, order: NDArray[np.int64], *rest: object) -> float:
    """About what bounds take interpreted: some products with G and each K_i a template."""
    n = cases.C.shape[1]
    return float(order.size * (5e-4 + 3e-7 * (shared.K.shape[0] + 1) * n * n))


bounding_kernel = Kernel(bound_reduced, _interpreted_seconds, compile_seconds=2.0)
"""`bound_reduced`, interpreted or compiled."""
