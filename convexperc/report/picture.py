"""A recognition as a picture: arguments are validated here, without Matplotlib; `figure` draws it."""

import os
from collections.abc import Mapping

from convexperc.errors import InputError, check_type, is_one_of
from convexperc.features.pictures import Picture
from convexperc.files import given_path
from convexperc.recognition.calibration import Judgement
from convexperc.recognition.recognition import Recognition
from convexperc.report.backend import load_matplotlib, require_matplotlib

KINDS = ("png", "svg")
"""File formats, by their suffixes."""


def picture_kind(path: str | os.PathLike[str]) -> str:
    """Return the file format of a path by its suffix, ``"png"`` or ``"svg"``; call it before any long work.

    Raises
    ------
    InputError
        Another suffix.
    MissingExtraError
        Matplotlib is not installed.
    """
    place = given_path(path, "picture", InputError)
    kind = place.suffix.lower().removeprefix(".")
    if kind not in KINDS:
        raise InputError(f"picture {os.fspath(path)}", value=kind, must="must end in .png or .svg")
    require_matplotlib()
    return kind


def recognition_picture(
    recognition: Recognition,
    views: Mapping[str, Picture],
    kind: str,
    judgement: Judgement | None = None,
) -> bytes:
    """Draw a recognition as the content of a file; the same input gives the same bytes.

    Parameters
    ----------
    recognition : Recognition
    views : mapping of str to uint8 (h, w, 3)
        The picture of each of the recognition's views.
    kind : {"png", "svg"}
        File format.
    judgement : Judgement, optional
        By a calibration.

    Returns
    -------
    bytes

    Raises
    ------
    InputError
        A view has no picture, or another `kind`.
    MissingExtraError
        Matplotlib is not installed.
    """
    check_type(recognition, Recognition, "recognition")
    check_type(views, Mapping, "views")
    check_type(judgement, (Judgement, type(None)), "judgement")
    if not is_one_of(kind, KINDS):
        raise InputError("kind", value=kind, must=f"must be one of {KINDS}")
    missing = [name for name in recognition.views if name not in views]
    if missing:
        raise InputError("views", value=missing, must="must hold a picture of every view")
    load_matplotlib()
    from convexperc.report import figure  # noqa: PLC0415 - Matplotlib comes with an extra

    return figure.draw(recognition, views, kind, judgement)
