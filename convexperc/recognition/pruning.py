"""Which template has the lowest optimum: the others are excluded by lower bounds, most of them unsolved.

In a large library a few templates are solved first. A linear map fitted to their answers predicts a primal
and a dual point for each of the others; whatever these are worth, `convexperc.certificate.reduced` makes proved
bounds of them. What is left is solved in the order of its bounds, and only until it is excluded.
"""

import time

import numpy as np
from jaxtyping import Float, Int

from convexperc.recognition.decision import Decision
from convexperc.solution.run import Run
from convexperc.solvers.newton.method import Batch

SAMPLES = 4
"""Templates solved for the prediction, for each unknown of a row of the linear map."""
WORTH = 8
"""Predict where the library has this many times the templates that are solved for it."""


def race(run: Run, decision: Decision = Decision.OBJECTIVE) -> None:
    """Leave in `run` at least one certified answer, and every other one certified or excluded by proof."""
    ready = run.ready.nonzero()[0]
    run.fall_back((~run.ready).nonzero()[0])
    if ready.size:
        order = ready[np.argsort(_estimate(run, decision)[ready], kind="stable")]
        samples = SAMPLES * (run.projection.C.shape[1] + 1)
        if not (run.warm or run.lasso) and samples * WORTH <= ready.size:
            chosen = _spread(order, samples)
            run.advance(chosen)
            _predict(run, chosen, np.setdiff1d(order, chosen, assume_unique=True))
        lower, upper = run.costs(decision)
        left = order[~run.certified()[order] & (lower[order] <= upper.min())]
        run.advance(left[np.argsort(lower[left], kind="stable")], float(upper.min()), decision)
    run.fall_back(_doubtful(run, decision))


def _doubtful(run: Run, decision: Decision) -> Int[np.ndarray, " k"]:
    """Templates that are neither excluded nor certified."""
    lower, upper = run.costs(decision)
    return np.flatnonzero((lower <= upper.min()) & ~run.certified())


def _estimate(run: Run, decision: Decision) -> Float[np.ndarray, " p"]:
    """A guess at every cost, only to order the templates: what ridge regression on the views leaves."""
    data = run.projection
    ridge = data.shared.G.copy()
    ridge.flat[:: ridge.shape[0] + 1] += run.normalised[0, 0] + 1e-9 * ridge.shape[0]
    explained = np.einsum("pn,np->p", data.C, np.linalg.solve(ridge, data.C.T))
    if decision is Decision.EXPLAINED_SHARE:
        return np.asarray(1.0 - explained / np.where(data.sound, data.targets, 1.0))
    return np.asarray(np.ldexp(data.targets - explained, 2 * data.exponents))


def _spread(order: Int[np.ndarray, " p"], samples: int) -> Int[np.ndarray, " k"]:
    """Half of the samples from the front of the order, half evenly from all of it."""
    front = samples // 2
    rest = np.linspace(front, order.size - 1, samples - front).astype(np.int64)
    return np.concatenate([order[:front], order[rest]])


def _predict(run: Run, known: Int[np.ndarray, " k"], others: Int[np.ndarray, " r"]) -> None:
    """Bound the other templates by points that are predicted from the known ones."""
    began, data, batch = time.perf_counter(), run.projection, run.batch
    n = data.C.shape[1]
    given = np.hstack([data.C, np.ones((data.C.shape[0], 1))])
    found = np.hstack([batch.W[known], batch.Q[known]])
    predicted = given[others] @ np.linalg.lstsq(given[known], found, rcond=None)[0]
    W, Q = (np.ascontiguousarray(part) for part in (predicted[:, :n], predicted[:, n:]))
    T = np.tile(batch.T[known].mean(axis=0), (others.size, 1))
    run.solving += time.perf_counter() - began
    run.prove(others, Batch(W, T, Q, np.zeros(others.size, dtype=np.int64)), thorough=False)
