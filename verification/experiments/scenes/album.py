"""Photographs of several objects, one folder an object, with or without masks."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from convexperc.errors import ImageError, InputError
from convexperc.features.pictures import list_images, read_image
from verification.experiments.design import VIEWS
from verification.experiments.scenes.folder import read_mask
from verification.experiments.scenes.pictures import Mask, Picture

MASKS = "masks"
CENTRAL = 0.8
"""Without a mask the object is taken to fill this part of the height and of the width, in the middle."""
SIDE = 90
"""Azimuth of the reference where azimuths are known: objects are best told from their side."""


@dataclass(frozen=True, slots=True, eq=False)
class Photo:
    """One picture of an album.

    Attributes
    ----------
    name : str
    azimuth : int or None
        Degrees, where the name is a whole number.
    picture : uint8 (h, w, 3)
    mask : bool (h, w)
    """

    name: str
    azimuth: int | None
    picture: Picture
    mask: Mask


@dataclass(frozen=True, slots=True, eq=False)
class Album:
    """All pictures of one object.

    Attributes
    ----------
    object : str
    reference : Photo
        By which the object is known; the one from azimuth 90 if there is one, else the first by name.
    others : tuple of Photo
        Sorted by name.
    """

    object: str
    reference: Photo
    others: tuple[Photo, ...]

    def turned(self, photo: Photo) -> float | None:
        """Return the degrees between a photograph's direction and the reference's, in (-180, 180]."""
        if photo.azimuth is None or self.reference.azimuth is None:
            return None
        return float(180 - (180 - (photo.azimuth - self.reference.azimuth)) % 360)


def read_albums(folder: Path) -> tuple[Album, ...]:
    """Read every object's folder, sorted by name.

    Raises
    ------
    ImageError
        A folder or picture cannot be read, or a mask has another size than its picture.
    InputError
        Fewer than two objects, or too few pictures of one.
    """
    try:
        places = sorted(p for p in folder.iterdir() if p.is_dir() and not p.name.startswith("."))
    except OSError as problem:
        raise ImageError(f"folder {folder}", value=problem.strerror, must="must be readable") from None
    if len(places) < 2:
        must, remedy = "must hold a folder for each of at least two objects", "See --help."
        raise InputError(f"folder {folder}", value=[p.name for p in places], must=must, remedy=remedy)
    return tuple(_album(place) for place in places)


def _album(folder: Path) -> Album:
    photos = [_photo(place) for place in list_images(folder)]
    if len(photos) < VIEWS + 1 or len({photo.name for photo in photos}) < len(photos):
        must = f"must hold at least {VIEWS + 1} pictures, one the reference and {VIEWS} the views, by stem"
        raise InputError(f"folder {folder}", value=[photo.name for photo in photos], must=must)
    reference = next((photo for photo in photos if photo.azimuth == SIDE), photos[0])
    return Album(folder.name, reference, tuple(photo for photo in photos if photo is not reference))


def _photo(place: Path) -> Photo:
    picture, mask = read_image(place), place.parent / MASKS / f"{place.stem}.png"
    shown = read_mask(mask) if mask.is_file() else _central(*picture.shape[:2])
    if shown.shape != picture.shape[:2] or not shown.any():
        must = f"must have the size {picture.shape[:2]} of its picture and show something"
        raise ImageError(f"mask {mask}", value=shown.shape, must=must)
    azimuth = int(place.stem) if place.stem.isascii() and place.stem.isdigit() else None
    return Photo(place.stem, azimuth, picture, shown)


def _central(height: int, width: int) -> Mask:
    """The box in the middle of a picture without a mask."""
    mask = np.zeros((height, width), dtype=np.bool_)
    down, across = round(height * (1 - CENTRAL) / 2), round(width * (1 - CENTRAL) / 2)
    mask[down : height - down, across : width - across] = True
    return mask
