"""Which template has the lowest optimum: the others are excluded by lower bounds, most of them unsolved.

In a large library a few templates are solved first. Polynomials in c_j = X o_j, fitted to their answers,
predict a primal and a dual point for each of the others; whatever these are worth,
`convexperc.certificate.reduced` makes proved bounds of them. What is left is solved in the order of its
bounds, and only until it is excluded.
"""

import math
import time

import numpy as np
from jaxtyping import Float, Int

from convexperc.certificate.data_bounds import Intervals
from convexperc.problem.arrays import every, lowest
from convexperc.recognition.decision import Decision, costs
from convexperc.solution.batch import BatchSolver
from convexperc.solvers.newton.loop import Pruning

MARGIN = 1e-6
"""A template is given up only this far, relatively, above the best one: it must be proved to lie above."""
SAMPLES_PER_UNKNOWN = 4
"""Templates solved for the prediction, for each of its coefficients."""
HIGHEST_DEGREE = 2
"""Of the polynomials in c_j that predict the answers."""
WORTH_PREDICTING = 8
"""Predict where the library has this many times the templates that are solved for it."""


def prune(batch: BatchSolver, decision: Decision = Decision.OBJECTIVE) -> None:
    """Leave in `batch` at least one certified answer, and every other one certified or excluded by proof."""
    order, pruning = np.arange(batch.data.p), _pruning(batch, math.inf, decision)
    if not every(batch.ready):
        batch.fall_back((~batch.ready).nonzero()[0])
        order = batch.ready.nonzero()[0]
    degree = _degree(batch, order.size)
    if degree:
        batch.rank(order, pruning)
        chosen = _spread(order, _samples(batch.data.n, degree))
        batch.advance(chosen)
        _predict(batch, degree, chosen, np.setdiff1d(order, chosen, assume_unique=True))
        lower, upper = _costs(batch, decision)
        order = order[~batch.known.certified[order] & (lower[order] <= lowest(upper))]
        order, pruning = (
            order[np.argsort(lower[order], kind="stable")],
            _pruning(batch, lowest(upper), decision),
        )
    batch.advance(order, pruning, ranked=not degree)
    batch.fall_back(_doubtful(batch, decision))


def _costs(batch: BatchSolver, decision: Decision) -> Intervals:
    """Proved bounds of what decides; see `convexperc.recognition.decision`."""
    return costs(decision, batch.known[:2], batch.bounds.squares)


def _pruning(batch: BatchSolver, ceiling: float, decision: Decision) -> Pruning:
    """The ceiling in units that the templates share."""
    lengths = batch.data.library.lengths
    if decision is Decision.EXPLAINED_FRACTION:
        return Pruning(1.0 / np.where(lengths.sound, lengths.targets, 1.0), ceiling, MARGIN)
    return Pruning(lengths.units, math.ldexp(ceiling, -2 * lengths.largest), MARGIN)


def _doubtful(batch: BatchSolver, decision: Decision) -> Int[np.ndarray, " k"]:
    """Templates that are neither excluded nor certified."""
    lower, upper = _costs(batch, decision)
    return np.asarray(((lower <= lowest(upper)) & ~batch.known.certified).nonzero()[0])


def _samples(n: int, degree: int) -> int:
    """Templates to be solved for a prediction by monomials in n numbers up to a degree."""
    return SAMPLES_PER_UNKNOWN * math.comb(n + degree, degree)


def _degree(batch: BatchSolver, templates: int) -> int:
    """The degree up to which the prediction is worth its samples; 0 where none is."""
    if batch.warm or batch.penalties.uncoupled:
        return 0
    degree, most = 0, templates // WORTH_PREDICTING
    while degree < HIGHEST_DEGREE and _samples(batch.data.n, degree + 1) <= most:
        degree += 1
    return degree


def _monomials(C: Float[np.ndarray, "p n"], degree: int) -> Float[np.ndarray, "p k"]:
    """Of every row, up to the degree."""
    parts = [np.ones((C.shape[0], 1)), C]
    if degree > 1:
        first, second = np.triu_indices(C.shape[1])
        parts.append(C[:, first] * C[:, second])
    return np.hstack(parts)


def _spread(order: Int[np.ndarray, " p"], samples: int) -> Int[np.ndarray, " k"]:
    """Half of the samples from the front of the order, half evenly from all of it."""
    front = samples // 2
    rest = np.linspace(front, order.size - 1, samples - front).astype(np.int64)
    return np.concatenate([order[:front], order[rest]])


def _predict(
    batch: BatchSolver, degree: int, known: Int[np.ndarray, " k"], others: Int[np.ndarray, " r"]
) -> None:
    """Bound the other templates by points that are predicted from the known ones."""
    began, data, reduced = time.perf_counter(), batch.data, batch.reduced
    given = _monomials(data.C, degree)
    found = np.hstack([reduced.W[known], reduced.Q[known]])
    predicted = given[others] @ np.linalg.lstsq(given[known], found, rcond=None)[0]
    reduced.W[others], reduced.Q[others] = np.hsplit(predicted, [data.n])
    reduced.T[others] = reduced.T[known].mean(axis=0)
    batch.solving += time.perf_counter() - began
    batch.prove(others, thorough=False)
