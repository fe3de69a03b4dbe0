"""Block coordinate descent in float64 on small problems: where the referee begins; answers to be judged."""

import numpy as np
from numpy.typing import NDArray

from verification.lassos.objective import Exact

STILL = 1e-15
"""A sweep that moves no block by more than this share of the largest entry ends the descent."""


def exponent(values: NDArray[np.float64]) -> int:
    """The binary exponent of the largest entry; 0 where all are 0."""
    largest = float(np.abs(values).max(initial=0.0))
    return int(np.frexp(largest)[1]) if largest else 0


def descend(exact: Exact, sweeps: int) -> tuple[NDArray[np.float64], float]:
    """Return (b, b0) after some sweeps from 0; a prox step for each block in turn.

    Parameters
    ----------
    exact : Exact
    sweeps : int

    Returns
    -------
    float64 (p,), float
    """
    X, y = np.array(exact.X, dtype=float), np.array(exact.y, dtype=float)
    x, t = exponent(X), exponent(y)
    X, y = np.ldexp(X, -x), np.ldexp(y, -t)
    k = np.array(exact.k, dtype=float)
    l1 = np.ldexp(np.array(exact.l1, dtype=float), -x - t)
    ridge = np.ldexp(np.array(exact.ridge, dtype=float), -2 * x)
    single = set(range(len(l1))) - {j for group, _ in exact.groups for j in group}
    blocks = [(group, float(np.ldexp(float(c), -x - t))) for group, c in exact.groups]
    blocks += [([j], 0.0) for j in sorted(single)]
    if exact.intercept:
        X = np.column_stack([X, np.ones(len(y))])
        l1, ridge = np.append(l1, 0.0), np.append(ridge, 0.0)
        blocks = [([X.shape[1] - 1], 0.0), *blocks]
    gram, pull = (X.T * k) @ X, X.T @ (k * y)
    b = _sweep(gram, pull, (l1, ridge), blocks, exact.positive and len(exact.l1), sweeps)
    p = len(exact.l1)
    return np.ldexp(b[:p], t - x), float(np.ldexp(b[p], t)) if exact.intercept else 0.0


def _sweep(
    gram: NDArray[np.float64],
    pull: NDArray[np.float64],
    penalties: tuple[NDArray[np.float64], NDArray[np.float64]],
    blocks: list[tuple[list[int], float]],
    positive: int,
    sweeps: int,
) -> NDArray[np.float64]:
    """The first `positive` entries are kept >= 0. On lists: arrays of this size cost more than they save."""
    rows, slope = gram.tolist(), (-pull).tolist()
    l1, ridge = (each.tolist() for each in penalties)
    curves = [float(np.linalg.norm(gram[np.ix_(block, block)], 2)) for block, _ in blocks]
    b = [0.0] * len(slope)
    for _ in range(sweeps):
        moved = 0.0
        for (block, c), curve in zip(blocks, curves, strict=True):
            if curve <= 0.0:
                continue
            new = []
            for j in block:
                target = b[j] - slope[j] / curve
                size = max(0.0, (target if j < positive else abs(target)) - l1[j] / curve)
                new.append(size if target > 0.0 else -size)
            length = sum(each * each for each in new) ** 0.5
            shrink = max(0.0, 1.0 - c / curve / length) if length > 0.0 else 0.0
            for j, each in zip(block, new, strict=True):
                step = each * shrink / (1.0 + ridge[j] / curve) - b[j]
                if step:
                    b[j] += step
                    moved = max(moved, abs(step))
                    slope = [s + row * step for s, row in zip(slope, rows[j], strict=True)]
        if moved <= STILL * max(map(abs, b)):
            break
    return np.array(b)
