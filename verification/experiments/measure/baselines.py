"""Simpler ways to name the object, on the same subsets of views."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from verification.experiments.design import Design
from verification.experiments.measure.subsets import Subset, drawn
from verification.experiments.measure.trials import Known
from verification.experiments.scenes.pictures import Layout

Floats = NDArray[np.float64]
TIE_TOLERANCE = 1e-12
"""Values that differ by no more than this, relatively, are a tie."""
RIDGE = 0.1
"""The weight of ||w||^2."""


def best_single_view(G: Floats, C: Floats, squares: Floats) -> Floats:
    """The least over the views of ||x_i - o_j||^2, shape (p,), from G = X X', C = X O and ||o_j||^2."""
    return np.asarray((G.diagonal()[:, None] - 2.0 * C + squares).min(axis=0))


def mean_of_the_views(G: Floats, C: Floats, squares: Floats) -> Floats:
    """||x - o_j||^2 with x the mean of the views, shape (p,)."""
    return np.asarray(G.mean() - 2.0 * C.mean(axis=0) + squares)


def ridge(G: Floats, C: Floats, squares: Floats) -> Floats:
    """The least over w of ||X'w - o_j||^2 + 0.1 ||w||^2 = ||o_j||^2 - c'(G + 0.1 I)^-1 c, shape (p,)."""
    solved = np.linalg.solve(G + RIDGE * np.eye(len(G)), C)
    return np.asarray(squares - (C * solved).sum(axis=0))


BASELINES: dict[str, Callable[[Floats, Floats, Floats], Floats]] = {
    "best single view": best_single_view,
    "mean of the views": mean_of_the_views,
    "ridge": ridge,
}


def score(values: Floats, truth: int) -> float:
    """The chance that a fair draw among the lowest values is right."""
    lowest = values <= values.min() + TIE_TOLERANCE * np.abs(values).max()
    return float(lowest[truth] / lowest.sum())


def run_baselines(layout: Layout, X: Floats, known: Known, design: Design) -> Floats:
    """Score every trial of every baseline, shape (scenes, baselines, counts, repetitions)."""
    squares = np.einsum("dp,dp->p", known.O, known.O)
    found = []
    for scene, rows in layout.rows():
        G, C = X[rows] @ X[rows].T, X[rows] @ known.O
        known_scores: dict[Subset, list[float]] = {}
        subsets = drawn(design, layout.name, scene)
        for subset in dict.fromkeys(s for each in subsets for s in each):
            part = G[np.ix_(subset, subset)], C[list(subset)], squares
            truth = layout.truth(scene)
            known_scores[subset] = [score(value(*part), truth) for value in BASELINES.values()]
        scores = np.array([[known_scores[s] for s in each] for each in subsets])
        found.append(scores.transpose(2, 0, 1))
    return np.stack(found)
