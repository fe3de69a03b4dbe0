"""A camera's effects on a picture: exposure, blur and noise, in this order."""

import zlib

import cv2
import numpy as np
from jaxtyping import Float, UInt8

from convexperc.simulation.camera import Camera

Picture = UInt8[np.ndarray, "height width 3"]
"""Rows from the top, columns from the left, channels red, green, blue."""


def apply_effects(
    samples: Float[np.ndarray, "height width 3"], camera: Camera, name: str, seed: int
) -> Picture:
    """Return the picture, (height, width, 3), that a camera makes of exact gray levels.

    Exposure and blur act on linear light, to which the gray levels of sRGB are converted and from which they
    are converted back; noise is added to the gray levels. A camera without effects only rounds.

    Parameters
    ----------
    samples : ndarray, shape (height, width, 3)
        Gray levels in [0, 255].
    camera : Camera
        Gives the strength of each effect.
    name : str
        The camera's name in its scene, part of the seed of its noise.
    seed : int
        The scene's seed, not negative.
    """
    levels = samples
    if camera.exposure != 0.0 or camera.blur > 0.0:
        light = _light(levels) * 2.0**camera.exposure
        if camera.blur > 0.0:
            light = cv2.GaussianBlur(light, (0, 0), camera.blur, borderType=cv2.BORDER_REPLICATE)
        levels = _levels(np.clip(light, 0.0, 1.0))
    if camera.noise > 0.0:
        random = np.random.default_rng([seed, zlib.crc32(name.encode())])
        levels = levels + camera.noise * random.standard_normal(levels.shape)
    picture: Picture = np.rint(np.clip(levels, 0.0, 255.0)).astype(np.uint8)
    return picture


def _light(levels: Float[np.ndarray, "*shape"]) -> Float[np.ndarray, "*shape"]:
    """Turn gray levels of sRGB (IEC 61966-2-1) into light, 1 at level 255."""
    share = levels / 255.0
    return np.asarray(np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4))


def _levels(light: Float[np.ndarray, "*shape"]) -> Float[np.ndarray, "*shape"]:
    """Turn light in [0, 1] into gray levels of sRGB."""
    return 255.0 * np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
