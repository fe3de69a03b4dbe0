"""Programs for the tests: some right, some with the faults that are printed and installed."""

import warnings

import numpy as np

from verification.reweighted import norm, norm1, squares, variable


def median_objective(y):
    m = variable("m")
    return sum(norm(m - v) for v in y)


def geometric_objective(points):
    m = variable("m", points.shape[1])
    return sum(norm(m - p) for p in points)


def absolute_objective(X, y):
    return norm1(X @ variable("b", X.shape[1]) - y)


def lasso_objective(X, y, penalty):
    b = variable("b", X.shape[1])
    return squares(X @ b - y) * 0.5 + norm1(b) * penalty


def right_median(y):
    return np.median(y)


def mean_for_median(y):
    return np.mean(y)


def reweighted_median(
    y, floor=lambda size: 1e-12 * size, stop=lambda size: 1e-14 * size, most=500, power=1.0
):
    size, m = np.max(np.abs(y - np.mean(y))), np.mean(y)
    if size == 0:
        return m
    for _ in range(most):
        weights = np.maximum(np.abs(y - m), floor(size)) ** -power
        moved = np.sum(weights * y) / np.sum(weights)
        if abs(moved - m) <= stop(size):
            return moved
        m = moved
    return m


def absolute_floor(y):
    return reweighted_median(y, floor=lambda size: 1e-6, stop=lambda size: 0.0, most=100)


def absolute_stop(y):
    return reweighted_median(y, stop=lambda size: 1e-6)


def wrong_power(y):
    """Weights 1/sqrt(r): the sum of |r|^(3/2)."""
    return reweighted_median(y, power=0.5)


def one_iteration(y):
    return reweighted_median(y, most=1)


def divides_by_zero(y, start=0.5):
    m = float(np.mean(y)) + start
    with np.errstate(all="ignore"):
        for _ in range(60):
            weights = 1 / np.abs(y - m)
            m = np.sum(weights * y) / np.sum(weights)
    return m


def raises_at_zero(y):
    if np.any(y == 0):
        raise ZeroDivisionError("float division by zero")
    return np.median(y)


def refuses_zeros(y):
    if np.any(y == 0):
        raise ValueError("zeros are not supported")
    return np.median(y)


def warns_that_it_did_not_converge(y):
    warnings.warn("did not converge", UserWarning, stacklevel=2)
    return np.mean(y)


def only_the_first_is_doubled(y):
    """Right unless a row is repeated: keeps each value once."""
    return np.median(np.unique(y))


def depends_on_order(y):
    """The middle of the list, where that is right anyway."""
    middle = y[len(y) // 2]
    return middle if np.all(np.diff(y) >= 0) else y[0]


def skips_zeros(y):
    """Takes 0 for a missing value; where all are missing, it is 0."""
    kept = y[y != 0]
    return np.median(kept) if len(kept) else 0.0


def sorts_its_argument(y):
    """Right once; then the caller's array has another content."""
    found = np.median(y)
    y *= 2
    return found


def vardi_zhang(points, start=None):
    """The modified Weiszfeld step, until the relative change is below float64's."""
    scale = np.max(np.abs(points - np.mean(points, axis=0)))
    m = np.mean(points, axis=0) if start is None else start
    for _ in range(1000):
        away = points - m
        r = np.linalg.norm(away, axis=1)
        near = r <= 1e-15 * scale
        if near.all():
            return m
        weights = 1 / r[~near]
        pull = (away[~near] * weights[:, None]).sum(axis=0)
        force = np.linalg.norm(pull)
        share = max(0.0, 1 - near.sum() / force) if force else 0.0
        step = share * pull / weights.sum()
        m = m + step
        if np.linalg.norm(step) <= 1e-15 * scale:
            break
    return min([m, *points], key=lambda p: np.linalg.norm(points - p, axis=1).sum())


def plain_weiszfeld(points, start=None):
    """Without the repair: it stays at a data point from which it starts."""
    m = np.mean(points, axis=0) if start is None else start
    scale = np.max(np.abs(points - np.mean(points, axis=0)))
    for _ in range(500):
        r = np.linalg.norm(points - m, axis=1)
        if np.any(r <= 1e-15 * scale):
            break
        m = (points / r[:, None]).sum(axis=0) / (1 / r).sum()
    return min(
        [m, *(points if start is None else [])], key=lambda p: np.linalg.norm(points - p, axis=1).sum()
    )


def descends_half_the_penalty(X, y, penalty):
    """A lasso whose weights miss the factor 2 of the square: it has half the penalty."""
    return lasso(X, y, penalty / 2)


def lasso(X, y, penalty):
    """Coordinate descent to the last digit."""
    b = np.zeros(X.shape[1])
    squares_of = (X**2).sum(axis=0)
    for _ in range(5000):
        before = b.copy()
        for j in np.flatnonzero(squares_of):
            pull = X[:, j] @ (y - X @ b) + squares_of[j] * b[j]
            b[j] = np.sign(pull) * max(abs(pull) - penalty, 0) / squares_of[j]
        if np.max(np.abs(b - before)) <= 1e-13 * np.max(np.abs(b)):
            break
    return b
