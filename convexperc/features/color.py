"""Colour: one histogram each of R, G and B."""

import cv2
import numpy as np
from jaxtyping import Float

from convexperc.features.configuration import FeatureConfiguration
from convexperc.images import Picture


def color_histogram(image: Picture, configuration: FeatureConfiguration) -> Float[np.ndarray, " color"]:
    """Count the pixels of each intensity, first of R, then of G, then of B.

    With B bins, ``h[c B + b] = #{pixels with floor(v_c B / 256) = b}``; each of the three histograms
    sums to the number of pixels, wherever those pixels lie.

    Parameters
    ----------
    image : ndarray of uint8, (h, w, 3)
        Intensities 0..255 of R, G, B.
    configuration : FeatureConfiguration
        Its ``color_bins`` is B.

    Returns
    -------
    ndarray of float64, (3 B,)
        Counts of pixels.

    Notes
    -----
    OpenCV counts in integers and gives single precision: exact, because no working size has more than 2^24
    pixels.

    Paper: Section IV
    """
    bins = configuration.color_bins
    counts = [cv2.calcHist([image], [channel], None, [bins], [0, 256]).ravel() for channel in range(3)]
    return np.concatenate(counts).astype(np.float64)
