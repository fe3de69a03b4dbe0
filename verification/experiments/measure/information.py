"""How much a view tells of the reference's gray values: mutual information in bits."""

import numpy as np
from numpy.typing import NDArray
from scipy.special import entr

from convexperc.features.pictures import GrayPicture

BINS = 32
"""Bins of equal width for the gray values of each picture."""


def mutual_information(a: GrayPicture, b: GrayPicture) -> float:
    """I(A; B) = H(A) + H(B) - H(A, B) of the gray values at equal places.

    Parameters
    ----------
    a, b : uint8 (h, w)
        Of one size.

    Returns
    -------
    float
        Bits, at least 0.
    """
    cells = (a.astype(np.intp) * BINS // 256) * BINS + b.astype(np.intp) * BINS // 256
    joint: NDArray[np.float64] = np.bincount(cells.ravel(), minlength=BINS * BINS) / cells.size
    table = joint.reshape(BINS, BINS)
    alone = entr(table.sum(axis=1)).sum() + entr(table.sum(axis=0)).sum()
    return max(0.0, float((alone - entr(joint).sum()) / np.log(2.0)))
