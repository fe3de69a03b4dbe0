"""Bounds of F* where the coupling costs little: a lasso in w alone lies below F.

F* is at least the optimum of a lasso in w alone, h(w) = ||X'w - o||^2 + lambda2 ||w||_1, and is that optimum
where the coupling costs nothing: with lambda1 = 0, u = 0 is best; with lambda3 = 0 some u has Xu = w. With
sigma <= lambda_min(X X'), y = X(X'w - o), and any v that is lambda2 sign(w_j) where w_j is not 0 and in
[-lambda2, lambda2] elsewhere,

    h(w + s) - h(w) >= sum_j (2 y_j + v_j) s_j + sigma ||s||^2 >= -sum_j (2 y_j + v_j)^2 / (4 sigma).

Equal views count once: their weights add up, so the lasso over the distinct views has the same optimum, and
each of the equal ones may carry the same part of the sum.
"""

from dataclasses import dataclass
from typing import no_type_check

import numpy as np
from jaxtyping import Float, Int

from convexperc.certificate.cases import (
    AnswerBounds,
    Cases,
    GramBounds,
    case_of,
    forget,
    new_numbers,
    room_in,
)
from convexperc.certificate.reduced import UNDERFLOW_SUM, in_range, value_bounds
from convexperc.certificate.rounding import U, gamma, smallest_eigenvalue
from convexperc.kernels.kernel import Kernel
from convexperc.problem.arrays import Matrix


@dataclass(frozen=True, eq=False)
class Distinct:
    """The distinct views: equal ones are taken together.

    Attributes
    ----------
    shared : GramBounds
        G, K and their bounds, of the distinct views alone.
    place : int (n,)
        Which of the distinct views each view is.
    counts : float64 (k,)
        How many views are equal to each of the distinct ones.
    floor : float
        A proved lower bound of lambda_min(X X') over the distinct views, normalised; 0 where none is known.
    """

    shared: GramBounds
    place: Int[np.ndarray, " n"]
    counts: Float[np.ndarray, " k"]
    floor: float

    @classmethod
    def of(cls, X: Matrix, shared: GramBounds) -> "Distinct":
        """Look for equal views only where the views are not proved to be independent (Lemma R43)."""
        n = X.shape[0]
        alone = cls(shared, np.arange(n), np.ones(n), _floor(shared))
        if alone.floor > 0.0:
            return alone
        seen: dict[bytes, int] = {}
        place = np.array([seen.setdefault(row.tobytes(), len(seen)) for row in X])
        if len(seen) == n:
            return alone
        first = np.unique(place, return_index=True)[1]
        part = GramBounds(
            shared.G[np.ix_(first, first)], np.ascontiguousarray(shared.K[:, first][:, :, first]),
            np.ascontiguousarray(shared.lengths[:, first]), shared.rows[first], shared.blocks, shared.gamma,
        )  # fmt: skip
        return cls(part, place, np.bincount(place).astype(np.float64), _floor(part))

    @property
    def repeated(self) -> bool:
        """Whether some views are equal."""
        return self.counts.size < self.place.size

    def merged(self, C: Float[np.ndarray, "p n"]) -> Float[np.ndarray, "p k"]:
        """Columns of the distinct views."""
        first = np.unique(self.place, return_index=True)[1]
        return np.ascontiguousarray(C[:, first])

    def spread(self, W: Float[np.ndarray, "p k"]) -> Float[np.ndarray, "p n"]:
        """Give each of the equal views the same part."""
        return np.ascontiguousarray((W / self.counts)[:, self.place])


def _floor(shared: GramBounds) -> float:
    """Bound lambda_min(X X') by that of G, with ||X X' - G||_2 <= gamma sum_j ||x_j||^2 (Lemma R43)."""
    n = shared.rows.size
    error = shared.gamma * float((shared.rows**2).sum()) * (1.0 + gamma(n + 4)) + UNDERFLOW_SUM
    return smallest_eigenvalue(shared.G, error)


@no_type_check
def bound_lasso(shared, floor, cases, numbers, bounds):
    """Fill in `bounds` for every template.

    Any point may be given; with lambda3 = 0, a good one has T = 1 and G Q about W, with lambda1 = 0, T = 0.
    """
    room = room_in(numbers, cases.W.shape[1], cases.T.shape[1])
    for j in range(cases.C.shape[0]):
        forget(bounds, j)
        case = case_of(cases, j)
        if floor > 0.0 and in_range(case):
            _bound_one(shared, case, floor, room, bounds, j)


@no_type_check
def _bound_one(shared, case, floor, room, bounds, j):
    """Bound one template's optimum and gap (Lemma R51)."""
    value = value_bounds(shared, case, room)
    g, two = shared.gamma, case.lambdas[1]
    lasso = case.lambdas[0] == 0.0 or case.lambdas[2] == 0.0
    deficit = far = norms = 0.0
    for a in range(case.w.size):
        pull = 2.0 * room.y[a]
        error = 2.0 * g * (shared.rows[a] * value.rho + abs(room.y[a])) + UNDERFLOW_SUM
        v = min(max(-pull, -two), two)
        if case.w[a] != 0.0:
            v = two if case.w[a] > 0.0 else -two
        left = abs(pull + v) + error + 8 * U * (abs(pull) + two)
        deficit += left * left
        off = abs(room.e[a]) + room.e_error[a]
        far += off * off
    deficit *= 0.25 / floor * (1.0 + g)
    for i in range(case.t.size):
        norms += case.t[i] * room.high[i]
    coupled = case.lambdas[0] * far + case.lambdas[2] * norms
    gap = (deficit + coupled + value.stored) * (1.0 + g) + UNDERFLOW_SUM
    root = 2.0 * np.sqrt(gap) * (1.0 + 2.0**-40)
    for a in range(case.w.size):
        error = 2.0 * g * (shared.rows[a] * value.rho + abs(room.y[a])) + UNDERFLOW_SUM
        size = abs(2.0 * room.y[a]) + error + root * shared.rows[a]
        bounds.zero_views[j, a] = lasso and size * (1.0 + 2.0**-40) < two
    for i in range(case.t.size):
        middle = 0.5 * (room.low[i] + room.high[i]) if room.tau[i] != 0.0 else 0.0  # not what underflow adds
        bounds.modality_norms[j, i] = case.t[i] * middle
        bounds.zero_modalities[j, i] = case.lambdas[0] == 0.0 and case.lambdas[2] > 0.0
    bounds.upper[j], bounds.gap[j] = value.upper, gap
    bounds.lower[j] = max(0.0, (value.lower - gap) - 8 * U * (value.lower + gap) - UNDERFLOW_SUM)


def _interpreted_seconds(shared: GramBounds, floor: float, cases: Cases, *rest: object) -> float:
    """About what bounds take interpreted: a product with G and each K_i a template."""
    p, n = cases.C.shape
    return float(p * (3e-4 + 1e-6 * (shared.K.shape[0] + 1) * n * n))


lasso_bounding_kernel = Kernel(bound_lasso, _interpreted_seconds, compile_seconds=1.0)
"""`bound_lasso`, interpreted or compiled."""


def bound_merged(
    distinct: Distinct,
    shared: GramBounds,
    C: Float[np.ndarray, "p n"],
    targets: Float[np.ndarray, " p"],
    lambdas: Float[np.ndarray, "p 3"],
    W: Float[np.ndarray, "p n"],
    T: Float[np.ndarray, "p m"],
    Q: Float[np.ndarray, "p n"],
) -> AnswerBounds:
    """Bound the optima where some views may be equal (Lemma R52).

    Parameters
    ----------
    distinct : Distinct
    shared : GramBounds
        Of all views.
    C, targets, lambdas, W, T, Q
        As in `bound_lasso`.

    Returns
    -------
    AnswerBounds
        Of the points as given; with equal views the lower bound is that of the lasso over the distinct ones.
    """
    (p, n), m = C.shape, T.shape[1]
    bounds = AnswerBounds.unknown(p, n, m)
    cases = Cases(C, targets, lambdas, W, T, Q)
    lasso_bounding_kernel(shared, distinct.floor, cases, new_numbers(n, m), bounds)
    if not distinct.repeated:
        return bounds
    k = distinct.counts.size
    merged, nothing = AnswerBounds.unknown(p, k, m), np.zeros((p, k))
    sums = np.zeros((p, k))
    np.add.at(sums.T, distinct.place, W.T)
    alone = lambdas * np.array([0.0, 1.0, 0.0])
    cases = Cases(distinct.merged(C), targets, alone, sums, np.zeros((p, m)), nothing)
    lasso_bounding_kernel(distinct.shared, distinct.floor, cases, new_numbers(k, m), merged)
    gap = (bounds.upper - merged.lower) * (1.0 + 8 * U)
    zeros = merged.zero_views[:, distinct.place]
    return bounds._replace(lower=merged.lower, gap=gap, zero_views=zeros)
