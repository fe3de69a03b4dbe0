"""OpenCV's reader of videos, cameras and streams."""

import os
import threading
from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray

from convexperc.features.pictures import Picture, as_rgb

_QUIET, _SETTING = threading.Lock(), "OPENCV_FFMPEG_LOGLEVEL"


def capture_of(address: int | str, timeout: float = 0.0) -> cv2.VideoCapture:
    """Open a camera by its number, or a video or stream by its address; whether it is open is to be asked.

    OpenCV and FFmpeg would write on the standard error what an address is not; the caller says it.

    Parameters
    ----------
    address : int or str
    timeout : float
        Seconds that a stream may take to open and to give a picture; 0 for files.
    """
    backend = cv2.CAP_ANY
    if isinstance(address, str) and cv2.videoio_registry.hasBackend(cv2.CAP_FFMPEG):
        backend = cv2.CAP_FFMPEG
    wait = round(1000 * timeout)
    waits = [cv2.CAP_PROP_OPEN_TIMEOUT_MSEC, wait, cv2.CAP_PROP_READ_TIMEOUT_MSEC, wait]
    with _QUIET:
        level, setting = cv2.utils.logging.getLogLevel(), os.environ.get(_SETTING)
        cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
        if setting is None:
            os.environ[_SETTING] = "-8"  # AV_LOG_QUIET; read once, when FFmpeg is first used
        try:
            return cv2.VideoCapture(address, backend, waits if wait and backend == cv2.CAP_FFMPEG else [])
        finally:
            cv2.utils.logging.setLogLevel(level)
            if setting is None:
                del os.environ[_SETTING]


def captured(pixels: NDArray[np.uint8], name: str) -> Callable[[], Picture]:
    """Return what converts a captured picture, B, G, R or gray, to RGB."""
    turned = pixels[..., ::-1] if pixels.ndim == 3 and pixels.shape[2] == 3 else pixels
    return lambda: as_rgb(turned, name)
