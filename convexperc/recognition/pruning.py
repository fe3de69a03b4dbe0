"""Which template has the lowest optimum: the others are excluded by lower bounds, most of them unsolved.

In a large library a few templates are solved first. A linear map fitted to their answers predicts a primal
and a dual point for each of the others; whatever these are worth, `convexperc.certificate.reduced` makes
proved bounds of them. What is left is solved in the order of its bounds, and only until it is excluded.
"""

import math
import time

import numpy as np
from jaxtyping import Float, Int

from convexperc.certificate.data_bounds import Intervals
from convexperc.recognition.decision import Decision, costs
from convexperc.solution.batch import BatchSolver
from convexperc.solvers.newton.loop import Pruning
from convexperc.solvers.newton.method import Batch

MARGIN = 1e-6
"""A template is given up only this far, relatively, above the best one: it must be proved to lie above."""
SAMPLES_PER_UNKNOWN = 4
"""Templates solved for the prediction, for each unknown of a row of the linear map."""
WORTH_PREDICTING = 8
"""Predict where the library has this many times the templates that are solved for it."""


def prune(batch: BatchSolver, decision: Decision = Decision.OBJECTIVE) -> None:
    """Leave in `batch` at least one certified answer, and every other one certified or excluded by proof."""
    ready = batch.ready.nonzero()[0]
    batch.fall_back((~batch.ready).nonzero()[0])
    if ready.size:
        order = ready[np.argsort(_estimate(batch, decision)[ready], kind="stable")]
        samples = SAMPLES_PER_UNKNOWN * (batch.data.n + 1)
        if not (batch.warm or batch.penalties.uncoupled) and samples * WORTH_PREDICTING <= ready.size:
            chosen = _spread(order, samples)
            batch.advance(chosen)
            _predict(batch, chosen, np.setdiff1d(order, chosen, assume_unique=True))
        lower, upper = _costs(batch, decision)
        left = order[~batch.certified[order] & (lower[order] <= upper.min())]
        left = left[np.argsort(lower[left], kind="stable")]
        batch.advance(left, _pruning(batch, left, float(upper.min()), decision) if left.size else None)
    batch.fall_back(_doubtful(batch, decision))


def _costs(batch: BatchSolver, decision: Decision) -> Intervals:
    """Proved bounds of what decides; see `convexperc.recognition.decision`."""
    return costs(decision, batch.intervals, batch.bounds.squares)


def _pruning(
    batch: BatchSolver, chosen: Int[np.ndarray, " k"], ceiling: float, decision: Decision
) -> Pruning:
    """The ceiling in units that the chosen templates share."""
    data = batch.data
    if decision is Decision.EXPLAINED_FRACTION:
        return Pruning(1.0 / data.targets[chosen], ceiling, MARGIN)
    largest = int(data.exponents.max())
    units = np.ldexp(1.0, 2 * (data.exponents[chosen] - largest))
    return Pruning(units, math.ldexp(ceiling, -2 * largest), MARGIN)


def _doubtful(batch: BatchSolver, decision: Decision) -> Int[np.ndarray, " k"]:
    """Templates that are neither excluded nor certified."""
    lower, upper = _costs(batch, decision)
    return np.flatnonzero((lower <= upper.min()) & ~batch.certified)


def _estimate(batch: BatchSolver, decision: Decision) -> Float[np.ndarray, " p"]:
    """A guess at every cost, only to order the templates: what ridge regression on the views leaves."""
    data = batch.data
    ridge = data.G.copy()
    ridge.flat[:: data.n + 1] += batch.normalised[0, 0] + 1e-9 * data.n
    explained = np.einsum("pn,np->p", data.C, np.linalg.solve(ridge, data.C.T))
    if decision is Decision.EXPLAINED_FRACTION:
        return np.asarray(1.0 - explained / np.where(data.sound, data.targets, 1.0))
    return np.asarray(np.ldexp(data.targets - explained, 2 * data.exponents))


def _spread(order: Int[np.ndarray, " p"], samples: int) -> Int[np.ndarray, " k"]:
    """Half of the samples from the front of the order, half evenly from all of it."""
    front = samples // 2
    rest = np.linspace(front, order.size - 1, samples - front).astype(np.int64)
    return np.concatenate([order[:front], order[rest]])


def _predict(batch: BatchSolver, known: Int[np.ndarray, " k"], others: Int[np.ndarray, " r"]) -> None:
    """Bound the other templates by points that are predicted from the known ones."""
    began, data, reduced = time.perf_counter(), batch.data, batch.reduced
    given = np.hstack([data.C, np.ones((data.p, 1))])
    found = np.hstack([reduced.W[known], reduced.Q[known]])
    predicted = given[others] @ np.linalg.lstsq(given[known], found, rcond=None)[0]
    W, Q = (np.ascontiguousarray(part) for part in np.hsplit(predicted, [data.n]))
    T = np.tile(reduced.T[known].mean(axis=0), (others.size, 1))
    guessed = Batch(W, T, Q, np.zeros(others.size, dtype=np.int64), np.full((others.size, 2), np.nan))
    batch.solving += time.perf_counter() - began
    batch.prove(others, guessed, thorough=False)
