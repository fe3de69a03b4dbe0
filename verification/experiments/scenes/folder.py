"""Read a simulated set from its folder: every picture and mask is there, and is the one that was written."""

import json
from collections.abc import Mapping
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from convexperc.errors import FileFormatError
from convexperc.features.pictures import read_image, to_gray
from verification.experiments.design import GOOD_VIEWS, STUDY_VIEWS, VIEWS
from verification.experiments.scenes.pictures import (
    CASE_STUDY,
    LEVELS,
    Mask,
    Picture,
    PictureSet,
    Scene,
    View,
)

MANIFEST = "manifest.json"
GOOD_WITHIN = 40.0
"""A view within as many degrees of the reference's direction shows what the reference shows."""
TWO_SIDED = "-car"
"""Objects of such a name look the same from the opposite side."""
AGAIN = "Write the folder again by `convexperc simulate`."


def read_physical(folder: Path) -> PictureSet:
    """Read the set in which objects are recognised.

    Raises
    ------
    FileFormatError
        The manifest is not of this form, or a picture is not the one it names.
    ImageError
        A picture cannot be read.
    """
    found = _read(folder, "physical")
    for scene in found.layout.scenes:
        partial, full = _levels(folder, scene)
        kinds = [view.obstruction for view in scene.views]
        if len(kinds) != VIEWS or kinds.count("partial") != partial or kinds.count("full") != full:
            must = f"must have {VIEWS} views as its level {scene.level!r} says"
            raise FileFormatError(f"scene {scene.name}", value=kinds, must=must, remedy=AGAIN)
    return found


def read_case_study(folder: Path) -> PictureSet:
    """Read the set in which views are ranked; see `read_physical`."""
    found = _read(folder, CASE_STUDY.replace(" ", "-"))
    for scene in found.layout.scenes:
        good = [view.good for view in scene.views]
        if len(good) != STUDY_VIEWS or sum(good) != GOOD_VIEWS:
            must = f"must have {STUDY_VIEWS} views, {GOOD_VIEWS} of them clear and from a side that tells"
            raise FileFormatError(f"scene {scene.name}", value=good, must=must, remedy=AGAIN)
    return found


def _levels(folder: Path, scene: Scene) -> tuple[int, int]:
    if scene.level not in LEVELS:
        must = f"must be one of {', '.join(LEVELS)}"
        raise FileFormatError(f"level of {scene.name} in {folder.name}", value=scene.level, must=must)
    return LEVELS[scene.level]


def _read(folder: Path, kind: str) -> PictureSet:
    manifest = _manifest(folder, kind)
    try:
        references = {each["object"]: _pair(folder, each) for each in manifest["references"]}
        scenes = [_scene(folder, each) for each in manifest["scenes"]]
        keys = ("seed", "engine", "image", "units")
        source = {name: manifest[name] for name in keys if name in manifest}
    except (KeyError, TypeError, AttributeError) as problem:
        must = "must have the form of a simulated set"
        value = f"{type(problem).__name__}: {problem}"
        raise FileFormatError(str(folder / MANIFEST), value=value, must=must, remedy=AGAIN) from None
    return PictureSet.of(kind, references, scenes, source)


def _manifest(folder: Path, kind: str) -> Mapping[str, Any]:
    place = folder / MANIFEST
    try:
        manifest = json.loads(place.read_text(encoding="utf-8"))
    except (OSError, ValueError) as problem:
        must = "must be a folder that `convexperc simulate` has finished"
        raise FileFormatError(str(folder), value=str(problem), must=must, remedy=AGAIN) from None
    if not isinstance(manifest, Mapping) or manifest.get("format") != 1 or manifest.get("set") != kind:
        found = {name: manifest.get(name) for name in ("format", "set")} if manifest else manifest
        must = f"must be of format 1 and of the set {kind!r}"
        raise FileFormatError(str(place), value=found, must=must, remedy="Is it the folder of the other set?")
    return manifest


def _scene(folder: Path, record: Mapping[str, Any]) -> tuple[Scene, list[tuple[Picture, Mask]]]:
    views = tuple(_view(record["object"], each) for each in record["views"])
    scene = Scene(record["name"], record["object"], record["level"], views)
    for view, each in zip(views, record["views"], strict=True):
        if view.obstruction != each["obstruction"]:
            what = f"obstruction of {view.name} in {scene.name}"
            must = f"must be {view.obstruction!r} for a visible share of {view.visible_share}"
            raise FileFormatError(what, value=each["obstruction"], must=must, remedy=AGAIN)
    return scene, [_pair(folder, each) for each in record["views"]]


def _view(name: str, record: Mapping[str, Any]) -> View:
    azimuth, share = float(record["azimuth"]), float(record["visible_share"])
    near = abs(azimuth) <= GOOD_WITHIN or (name.endswith(TWO_SIDED) and abs(azimuth) >= 180.0 - GOOD_WITHIN)
    view = View(record["name"], share, azimuth=azimuth)
    return View(view.name, share, near and view.obstruction == "none", azimuth)


def _pair(folder: Path, record: Mapping[str, Any]) -> tuple[Picture, Mask]:
    """A picture and its mask, both as their hashes say."""
    places = {"file": "sha256", "mask": "mask_sha256"}
    for name, digest in places.items():
        place = folder / record[name]
        try:
            found = sha256(place.read_bytes()).hexdigest()
        except OSError as problem:
            must = "must be there: the manifest names it"
            raise FileFormatError(str(place), value=problem.strerror, must=must, remedy=AGAIN) from None
        if found != record[digest]:
            must = f"must have the hash {record[digest]} of the manifest"
            raise FileFormatError(str(place), value=found, must=must, remedy=AGAIN)
    return read_image(folder / record["file"]), read_mask(folder / record["mask"])


def read_mask(place: Path) -> Mask:
    """Read a gray picture as a mask: 128 and more shows the object."""
    return np.asarray(to_gray(read_image(place)) >= 128)
