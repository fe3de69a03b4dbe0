"""How the views and the modalities of a scene are weighted for the object that it shows."""

from dataclasses import dataclass
from math import comb

import numpy as np
from numpy.typing import NDArray
from scipy.stats import kendalltau

from convexperc import solve_many
from convexperc.errors import SolverError
from convexperc.solution.solution import Status
from verification.experiments.design import BOTH, GOOD_VIEWS, Pair
from verification.experiments.measure.numbers import rounded
from verification.experiments.measure.trials import Known
from verification.experiments.scenes.pictures import Layout

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Weights:
    """Of every scene, all views together, for the true object's reference.

    Attributes
    ----------
    w : float64 (scenes, views)
        0 where no optimum uses the view, by proof.
    norms : float64 (scenes, modalities)
        ||u^i||_2; 0 where no optimum uses the modality, by proof.
    u : tuple of float64 (d,)
        Feature weights, of the scenes that were asked for.
    """

    w: Floats
    norms: Floats
    u: tuple[Floats, ...]


def weigh(
    layout: Layout, X: Floats, known: Known, wanted: frozenset[str] = frozenset(), pair: Pair = BOTH
) -> Weights:
    """Solve every scene for its own object.

    Parameters
    ----------
    layout : Layout
    X : float64 (pictures, d)
    known : Known
    wanted : set of str
        Names of the scenes whose `u` is kept.
    pair : (float, float)
        lambda2, lambda3.

    Raises
    ------
    SolverError
        An answer is not certified, nor its optimum enclosed.
    """
    w, norms, u = [], [], []
    lambda2, lambda3 = pair
    for scene, rows in layout.rows():
        truth = layout.truth(scene)
        answers = solve_many(
            X[rows],
            known.O[:, truth : truth + 1],
            lambda1=known.lambda1,
            lambda2=lambda2,
            lambda3=lambda3,
            modalities=known.sizes,
        )
        if answers.status(0) is Status.NOT_CERTIFIED:
            gap = float(answers.gap[0])
            raise SolverError(
                f"weights of {scene.name}", value=gap, must="must be certified, or the optimum enclosed"
            )
        w.append(np.where(answers.zero_views[0], 0.0, answers.w[0]))
        norms.append(np.where(answers.zero_modalities[0], 0.0, answers.modality_norms[0]))
        if scene.name in wanted:
            u.append(np.array(answers.u(0)))
    return Weights(np.stack(w), np.stack(norms), tuple(u))


def chance_that_best_are_good(w: Floats, good: NDArray[np.bool_]) -> float:
    """Of all orders by |w|, equal ones in any order, the fraction in which the first three are the good ones.

    Parameters
    ----------
    w : float64 (views,)
    good : bool (views,)
        Three are true.
    """
    size = np.abs(w)
    third = np.sort(size)[-GOOD_VIEWS]
    above, equal = size > third, size == third
    if (above & ~good).any() or (good & ~(above | equal)).any():
        return 0.0
    return 1.0 / comb(int(equal.sum()), GOOD_VIEWS - int(above.sum()))


def followed(layout: Layout, w: Floats) -> float | None:
    """Mean Kendall's tau-b of |w| and the visible share, over the scenes whose views differ in obstruction.

    Parameters
    ----------
    layout : Layout
    w : float64 (scenes, views)

    Returns
    -------
    float or None
        None where it is defined in no scene.
    """
    found = []
    for scene, weights in zip(layout.scenes, np.abs(w), strict=True):
        if len({view.obstruction for view in scene.views}) > 1:
            found.append(kendalltau(weights, [view.visible_share for view in scene.views]).statistic)
    defined = np.array(found)[~np.isnan(found)]
    return float(rounded(defined.mean())) if len(defined) else None


def by_rank(w: Floats, values: Floats) -> Floats:
    """Arrange values by |w|, largest first; views of equal weight share their mean."""
    size = np.abs(w)
    order = np.argsort(-size, kind="stable")
    return np.array([values[size == size[k]].mean() for k in order])
