"""Colour: histograms of R, G and B, separate or joint."""

import cv2
import numpy as np
from jaxtyping import Float

from convexperc.errors import FeatureError, check_type
from convexperc.features.configuration import JOINT, FeatureConfiguration
from convexperc.features.pictures import Picture, check_picture


def color_histogram(image: Picture, configuration: FeatureConfiguration) -> Float[np.ndarray, " color"]:
    """Count the pixels of each intensity.

    With B bins, a pixel has ``b_c = floor(v_c B / 256)``. By channel ``h[c B + b] = #{pixels with b_c = b}``,
    first R, then G, then B. In a joint histogram, ``h[(b_R B + b_G) B + b_B]`` counts the pixels of that
    colour. Each histogram sums to the number of pixels and does not depend on their positions.

    Parameters
    ----------
    image : ndarray of uint8, (h, w, 3)
        Intensities 0..255 of R, G, B.
    configuration : FeatureConfiguration
        Its ``color_histogram``; its ``color_bins`` is B.

    Returns
    -------
    ndarray of float64, (3 B,) or (B^3,)
        Counts of pixels.

    Notes
    -----
    OpenCV returns the counts in single precision, which is exact because no working size has more than 2^24
    pixels.

    Paper: Section IV
    """
    check_picture(image)
    check_type(configuration, FeatureConfiguration, "configuration", FeatureError)
    bins = configuration.color_bins
    if configuration.color_histogram == JOINT:
        joint = cv2.calcHist([image], [0, 1, 2], None, 3 * [bins], 3 * [0, 256])
        return joint.ravel().astype(np.float64)
    counts = [cv2.calcHist([image], [channel], None, [bins], [0, 256]).ravel() for channel in range(3)]
    return np.concatenate(counts).astype(np.float64)
