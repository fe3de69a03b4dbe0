"""Scenes drawn from photographs: six robots' views at five levels of obstruction, and a case study."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from convexperc.errors import InputError
from verification.experiments.design import GOOD_VIEWS, STUDY_VIEWS, VIEWS, key
from verification.experiments.scenes.album import Album, Photo, read_albums
from verification.experiments.scenes.obstacles import cover_fully, cover_partly
from verification.experiments.scenes.pictures import (
    CASE_STUDY,
    LEVELS,
    Mask,
    Picture,
    PictureSet,
    Scene,
    View,
)

SCENES = 6
"""Scenes of each object and level, and of each object in the case study."""
GOOD_WITHIN, BAD_BEYOND = 45.0, 90.0
"""Degrees from the reference's direction: at most, of a good view; more than, of a bad one in the clear."""

Drawn = tuple[Scene, list[tuple[Picture, Mask]]]


def draw_photographs(folder: Path, seed: int) -> tuple[PictureSet, PictureSet]:
    """Draw both sets from the photographs of a folder; the same seed draws the same.

    Parameters
    ----------
    folder : Path
        ``<object>/<view>.png`` and, if there are any, ``<object>/masks/<view>.png``. A view whose name is a
        whole number is taken from that azimuth in degrees.
    seed : int

    Returns
    -------
    (PictureSet, PictureSet)
        That in which objects are recognised, and the case study.

    Raises
    ------
    ImageError, InputError
        See `read_albums`; also too few views near the reference, or masks too small to be covered.
    """
    albums = read_albums(folder)
    references = {album.object: (album.reference.picture, album.reference.mask) for album in albums}
    source = _source(albums, seed)
    physical = [scene for album in albums for scene in _levels(album, seed)]
    study = [scene for album in albums for scene in _study(album, seed)]
    return (
        PictureSet.of("photographs", references, physical, source),
        PictureSet.of("photographs, case study", references, study, source),
    )


def _source(albums: Sequence[Album], seed: int) -> dict[str, Any]:
    return {
        "kind": "photographs with composed obstacles",
        "seed": seed,
        "photographs": {album.object: 1 + len(album.others) for album in albums},
        "references": {album.object: album.reference.name for album in albums},
        "robots": "views of one scene are different photographs, never the reference",
    }


def _levels(album: Album, seed: int) -> Iterator[Drawn]:
    """Every level's scenes of one object."""
    for level, (partial, full) in LEVELS.items():
        kinds = ["partial"] * partial + ["full"] * full + ["none"] * (VIEWS - partial - full)
        for number in range(SCENES):
            name = f"{album.object}-{level.replace(', ', '-').replace(' ', '-')}-{number:02d}"
            rng = np.random.default_rng([seed, key(name)])
            chosen = [album.others[k] for k in rng.choice(len(album.others), VIEWS, replace=False)]
            pairs = list(zip(chosen, rng.permutation(kinds).tolist(), strict=True))
            yield _scene(name, album, level, pairs, rng)


def _study(album: Album, seed: int) -> Iterator[Drawn]:
    """Scenes with three clear views from near the reference's direction and two others."""
    near = [photo for photo in album.others if _within(album, photo, 0.0, GOOD_WITHIN)]
    if len(near) < GOOD_VIEWS:
        must = f"must have at least {GOOD_VIEWS} views within {GOOD_WITHIN:g} degrees of the reference's"
        raise InputError(f"photographs of {album.object}", value=[photo.name for photo in near], must=must)
    for number in range(SCENES):
        name = f"{album.object}-study-{number:02d}"
        rng = np.random.default_rng([seed, key(name)])
        good = [near[k] for k in rng.choice(len(near), GOOD_VIEWS, replace=False)]
        left = [photo for photo in album.others if photo not in good]
        other = [left[k] for k in rng.choice(len(left), STUDY_VIEWS - GOOD_VIEWS, replace=False)]
        pairs = [(photo, "none") for photo in good]
        pairs += [(photo, _spoiled(album, photo, rng)) for photo in other]
        order = rng.permutation(STUDY_VIEWS)
        yield _scene(name, album, CASE_STUDY, [pairs[k] for k in order], rng)


def _within(album: Album, photo: Photo, low: float, high: float) -> bool:
    """Whether a view's direction is so far from the reference's; any view's may be where none is known."""
    turned = album.turned(photo)
    return turned is None or low <= abs(turned) <= high


def _spoiled(album: Album, photo: Photo, rng: np.random.Generator) -> str:
    """How a view is made one that is not good: it may be left clear if it is far off."""
    turned = album.turned(photo)
    far = turned is not None and abs(turned) > BAD_BEYOND
    return "none" if far and rng.random() < 0.5 else "full"


def _scene(
    name: str, album: Album, level: str, pairs: list[tuple[Photo, str]], rng: np.random.Generator
) -> Drawn:
    views, seen = [], []
    for number, (photo, kind) in enumerate(pairs, 1):
        picture, mask, share = photo.picture, photo.mask, 1.0
        if kind != "none":
            cover = cover_fully if kind == "full" else cover_partly
            covered = cover(picture, mask, rng)
            picture, mask, share = covered.picture, covered.mask, covered.visible_share
        good = level == CASE_STUDY and kind == "none" and _within(album, photo, 0.0, GOOD_WITHIN)
        source = f"{album.object}/{photo.name}"
        views.append(View(f"robot-{number}", share, good, album.turned(photo), source))
        seen.append((picture, mask))
    return Scene(name, album.object, level, tuple(views)), seen
