"""Texture: a histogram of local binary patterns."""

import numpy as np
from jaxtyping import Float
from skimage.feature import local_binary_pattern

from convexperc.features.configuration import FeatureConfiguration
from convexperc.features.pictures import GrayPicture


def lbp_histogram(gray: GrayPicture, configuration: FeatureConfiguration) -> Float[np.ndarray, " lbp"]:
    """Count the codes of the pixels that have a full circle of neighbours.

    P neighbours on a circle of radius R, interpolated linearly, each give one bit: at least as bright
    as the centre, or not. The border of width ``ceil(R)`` is excluded: there scikit-image treats the
    missing neighbours as black, which would make the codes depend on brightness.

    Parameters
    ----------
    gray : ndarray of uint8, (h, w)
        The picture at the working size.
    configuration : FeatureConfiguration
        Its ``lbp_...`` values.

    Returns
    -------
    ndarray of float64, (lbp_bins,)
        Counts of pixels; their sum is ``(h - 2 ceil(R)) (w - 2 ceil(R))``.

    Notes
    -----
    Where an interpolated neighbour equals the centre exactly although its four pixels differ, rounding
    determines the bit, so that such a pixel's code may differ between processors.

    Source: T. Ojala, M. Pietikäinen and D. Harwood, Performance evaluation of texture measures, ICPR
    1994; uniform codes by T. Ojala, M. Pietikäinen and T. Mäenpää, 2002; by scikit-image's
    ``local_binary_pattern``.
    Paper: Section IV
    """
    codes = local_binary_pattern(  # type: ignore[no-untyped-call]
        gray,
        P=configuration.lbp_points,
        R=configuration.lbp_radius,
        method=configuration.lbp_method,
    )
    margin = configuration.lbp_margin
    inner = codes[margin:-margin, margin:-margin].astype(np.int64)
    return np.bincount(inner.ravel(), minlength=configuration.lbp_bins).astype(np.float64)
