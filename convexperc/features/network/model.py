"""Features of a pretrained network: the fourth modality, where a configuration names one."""

import functools
import threading
from typing import Any

import cv2
import numpy as np
from jaxtyping import Float

from convexperc.errors import FeatureError
from convexperc.features.configuration import FeatureConfiguration
from convexperc.features.network.weights import pretrained_weights, require_network
from convexperc.features.pictures import Picture, resize

SIDE = 224
"""Height and width in pixels of the pictures that the network was trained with."""
MEAN, SCALE = 127, 128
"""What its training subtracted from each 8-bit value, and then divided by."""
_ALONE = threading.Lock()
"""Held by the thread that uses the network: OpenCV keeps the values of its layers in it."""


def network_features(image: Picture, configuration: FeatureConfiguration) -> Float[np.ndarray, " d"]:
    """Return what the configuration's pretrained network sees in a picture.

    The picture is resized to 224 x 224 pixels (`resize`; not by way of the working size), and each of R, G, B
    becomes ``(v - 127) / 128``, as in the training of EfficientNet-Lite0. Each entry is the mean of a channel
    of the last layer of features over its 7 x 7 places.

    Parameters
    ----------
    image : ndarray of uint8, (h, w, 3)
    configuration : FeatureConfiguration
        It names a network.

    Returns
    -------
    ndarray of float64, (1280,)
        In 0..6, since the layer ends in ReLU6. The network sees one picture at a time, so that the result
        depends on no other. It is computed in single precision: another version of OpenCV, or another
        processor, may give other last bits.

    Raises
    ------
    FeatureError
        The configuration names no network.
    MissingExtraError
        The extra ``cnn`` is not installed.
    FileFormatError
        The installed weights are not the expected ones.

    Notes
    -----
    Tan and Le, *EfficientNet: Rethinking Model Scaling for Convolutional Neural Networks*, 2019
    """
    if configuration.network is None:
        raise FeatureError("network", value=None, must="must be the name of a network")
    pixels = resize(image, (SIDE, SIDE)).transpose(2, 0, 1)[np.newaxis]
    given = (pixels - np.float32(MEAN)) / np.float32(SCALE)  # exact
    with _ALONE:
        network = _network()
        network.setInput(given)
        last = network.forward()[0].astype(np.float64)
    found: Float[np.ndarray, " d"] = last.mean(axis=(1, 2))
    return found


@functools.cache
def _network() -> Any:
    """Return the network, ready to run; the lock is held."""
    require_network()
    from convexperc.features.network import graph  # noqa: PLC0415 - imports onnx, which comes with an extra

    model = graph.onnx_model(pretrained_weights(), SIDE)
    return cv2.dnn.readNetFromONNX(np.frombuffer(model, np.uint8))
