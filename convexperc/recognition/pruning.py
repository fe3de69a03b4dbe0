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

MARGIN = 1e-6
"""A template is given up only this far, relatively, above the best one: it must be proved to lie above."""
SAMPLES_PER_UNKNOWN = 4
"""Templates solved for the prediction, for each unknown of a row of the linear map."""
WORTH_PREDICTING = 8
"""Predict where the library has this many times the templates that are solved for it."""


def prune(batch: BatchSolver, decision: Decision = Decision.OBJECTIVE) -> None:
    """Leave in `batch` at least one certified answer, and every other one certified or excluded by proof."""
    if batch.ready.all():
        order = _estimate(batch, decision).argsort(kind="stable")
    else:
        batch.fall_back((~batch.ready).nonzero()[0])
        order = np.empty(0, dtype=np.int64)
        if batch.ready.any():
            with np.errstate(over="ignore", invalid="ignore"):  # where a template is not ready
                order = _estimate(batch, decision).argsort(kind="stable")
            order = order[batch.ready[order]]
    ceiling, samples = math.inf, SAMPLES_PER_UNKNOWN * (batch.data.n + 1)
    if not (batch.warm or batch.penalties.uncoupled) and samples * WORTH_PREDICTING <= order.size:
        chosen = _spread(order, samples)
        batch.advance(chosen)
        _predict(batch, chosen, np.setdiff1d(order, chosen, assume_unique=True))
        lower, upper = _costs(batch, decision)
        order = order[~batch.certified[order] & (lower[order] <= upper.min())]
        order = order[np.argsort(lower[order], kind="stable")]
        ceiling = float(upper.min())
    if order.size:
        batch.advance(order, _pruning(batch, ceiling, decision))
    batch.fall_back(_doubtful(batch, decision))


def _costs(batch: BatchSolver, decision: Decision) -> Intervals:
    """Proved bounds of what decides; see `convexperc.recognition.decision`."""
    return costs(decision, batch.intervals, batch.bounds.squares)


def _pruning(batch: BatchSolver, ceiling: float, decision: Decision) -> Pruning:
    """The ceiling in units that the templates share."""
    lengths = batch.data.library.lengths
    if decision is Decision.EXPLAINED_FRACTION:
        return Pruning(1.0 / np.where(lengths.sound, lengths.targets, 1.0), ceiling, MARGIN)
    return Pruning(lengths.units, math.ldexp(ceiling, -2 * lengths.largest), MARGIN)


def _doubtful(batch: BatchSolver, decision: Decision) -> Int[np.ndarray, " k"]:
    """Templates that are neither excluded nor certified."""
    lower, upper = _costs(batch, decision)
    return np.asarray(((lower <= upper.min()) & ~batch.certified).nonzero()[0])


def _estimate(batch: BatchSolver, decision: Decision) -> Float[np.ndarray, " p"]:
    """A guess at every cost, only to order the templates: what ridge regression on the views leaves."""
    data = batch.data
    ridge = data.G.copy()
    ridge.reshape(-1)[:: data.n + 1] += batch.normalised[0, 0] + 1e-9 * data.n
    explained = np.einsum("pn,np->p", data.C, np.linalg.solve(ridge, data.C.T))
    if decision is Decision.EXPLAINED_FRACTION:
        return np.asarray(1.0 - explained / np.where(data.sound, data.targets, 1.0))
    return np.asarray((data.targets - explained) * data.library.lengths.units)


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
    reduced.W[others], reduced.Q[others] = np.hsplit(predicted, [data.n])
    reduced.T[others] = reduced.T[known].mean(axis=0)
    batch.solving += time.perf_counter() - began
    batch.prove(others, thorough=False)
