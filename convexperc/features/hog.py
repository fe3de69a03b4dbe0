"""Shape: histograms of oriented gradients."""

import numpy as np
from jaxtyping import Float
from skimage.feature import hog

from convexperc.features.configuration import FeatureConfiguration
from convexperc.features.pictures import GrayPicture


def hog_descriptor(gray: GrayPicture, configuration: FeatureConfiguration) -> Float[np.ndarray, " hog"]:
    """Return histograms of the gradient's direction in cells, normalised over overlapping blocks.

    Central differences of the 8-bit values (zero on the border), unsigned directions over 180 degrees,
    each pixel counted in one bin with its gradient's magnitude, blocks stepping by one cell. The order
    is block row, block column, cell row, cell column, orientation.

    Parameters
    ----------
    gray : ndarray of uint8, (h, w)
        The picture at the working size.
    configuration : FeatureConfiguration
        Its ``hog_...`` values.

    Returns
    -------
    ndarray of float64, (blocks * cells a block * orientations,)
        Dimensionless values >= 0; all zero for a uniform picture.

    Notes
    -----
    Source: N. Dalal and B. Triggs, Histograms of oriented gradients for human detection, CVPR 2005,
    by scikit-image's ``hog``.
    Paper: Section IV
    """
    descriptor = hog(
        gray,
        orientations=configuration.hog_orientations,
        pixels_per_cell=configuration.hog_pixels_per_cell,
        cells_per_block=configuration.hog_cells_per_block,
        block_norm=configuration.hog_block_norm,
        visualize=False,
        transform_sqrt=configuration.hog_transform_sqrt,
        feature_vector=True,
        channel_axis=None,
    )
    return np.asarray(descriptor, dtype=np.float64)
