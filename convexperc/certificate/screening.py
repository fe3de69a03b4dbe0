"""What is known of every optimum before it is known: bounds of its weights, and entries that must be 0."""

import math

import numpy as np
from numpy.typing import NDArray

from convexperc.certificate.duality import DualPoint
from convexperc.certificate.evaluation import NormalizedData
from convexperc.certificate.rounding import UNDERFLOW, U, up


def view_weight_bound(data: NormalizedData, upper: float) -> float:
    """Upper bound of ||w*||_1 (Lemma R36).

    Formula: at an optimum lambda2 ||w*||_1 <= min(F*, ||o||^2/2), and ||X'w*|| <= ||o||, so that
    ||w*||_1 <= sqrt(n) ||o|| / sigma_min(X').

    Parameters
    ----------
    data : NormalizedData
    upper : float
        An upper bound of F*.

    Returns
    -------
    float
        Infinite where neither bound applies.
    """
    length, sigma = up(math.sqrt(data.target_square[1])), data.smallest_singular_value
    by_rank = (
        up(up(math.sqrt(data.X.shape[0])) * length / sigma * (1.0 + 2.0**-50)) if sigma > 0.0 else math.inf
    )
    return min(by_rank, _by_lambda(data, upper, data.lambda2[0]))


def modality_weight_bound(data: NormalizedData, upper: float) -> float:
    """Upper bound of ||u*||_M = sum_i ||u*^i||, from lambda3 ||u*||_M <= min(F*, ||o||^2/2)."""
    return _by_lambda(data, upper, data.lambda3[0])


def _by_lambda(data: NormalizedData, upper: float, weight: float) -> float:
    """Upper bound of min(F*, ||o||^2/2) / lambda (Lemma R37)."""
    if weight == 0.0:
        return math.inf
    return up(min(upper, 0.5 * data.target_square[1]) / weight)


def proved_zeros(
    data: NormalizedData, point: DualPoint, gap: float
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Find the views and modalities that no optimum uses (Lemma R38).

    Formula: the dual is strongly concave; ||a - a*||^2 + ||b - b*||^2 / lambda1 <= 4 gap at a feasible point,

        |v_j| + 2 sqrt(gap (||x^j||^2 + lambda1)) < lambda2   proves w*_j = 0,
        ||X_i'b|| + 2 sqrt(gap lambda1) ||X_i||_F < lambda3   proves u*^i = 0.

    Parameters
    ----------
    data : NormalizedData
    point : DualPoint
        A feasible one.
    gap : float
        Upper bound of F* - D(s a, s b).

    Returns
    -------
    bool (n,), bool (m,)

    Notes
    -----
    Source: Ndiaye et al., Gap Safe screening rules for sparsity enforcing penalties, JMLR 18 (2017).
    """
    root = up(2.0 * up(math.sqrt(max(gap, 0.0))))
    coupling = data.lambda1[1]
    reach = np.sqrt(data.row_squares + coupling) * (1.0 + 4 * U)
    views = point.v.magnitude() * point.scale + root * reach
    modalities = point.ray.norms * point.scale + up(root * up(math.sqrt(coupling))) * data.block_lengths
    return (
        views * (1.0 + 2.0**-48) + UNDERFLOW < data.lambda2[0],
        modalities * (1.0 + 2.0**-48) + UNDERFLOW < data.lambda3[0],
    )
