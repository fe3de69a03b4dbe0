"""Small sets of pictures, made by code: striped objects on a gray ground, some of them covered."""

import json
from hashlib import sha256
from pathlib import Path

import cv2
import numpy as np

from verification.experiments.design import GOOD_VIEWS, STUDY_VIEWS, VIEWS, Design
from verification.experiments.measure.baselines import BASELINES
from verification.experiments.measure.measured import Measured
from verification.experiments.measure.trials import Trials, Tried
from verification.experiments.measure.weights import Weights
from verification.experiments.record.collection import Collection
from verification.experiments.scenes.pictures import CASE_STUDY, LEVELS, STUDIED, PictureSet, Scene, View

COLOURS = {"red": (200, 40, 40), "green": (40, 180, 60), "blue": (40, 60, 200)}
SHARES = {"none": 1.0, "partial": 0.5, "full": 0.0}
SIDE = 32


def drawn(name: str, kind: str, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """An object's picture and mask; stripes tell the objects apart beside the colour."""
    period = 3 + 2 * list(COLOURS).index(name)
    picture = np.full((SIDE, SIDE, 3), 90, dtype=np.float64)
    mask = np.zeros((SIDE, SIDE), dtype=np.bool_)
    mask[8:24, 8:24] = True
    stripes = 0.6 + 0.4 * (np.arange(SIDE) % period < period / 2)
    picture[mask] = (np.array(COLOURS[name]) * stripes[:, None])[np.newaxis].repeat(SIDE, axis=0)[mask]
    covered = {"none": 0, "partial": 8, "full": 16}[kind]
    picture[8:24, 8 : 8 + covered] = (120, 110, 100)
    mask[:, : 8 + covered] = False
    picture += rng.normal(0.0, 6.0, picture.shape)
    return np.clip(picture, 0, 255).astype(np.uint8), mask


def picture_set(
    objects: tuple[str, ...], *, levels: bool, seed: int = 0, only: tuple[str, ...] = tuple(LEVELS)
) -> PictureSet:
    """One scene for each object and level, or for each object of the case study."""
    rng = np.random.default_rng(seed)
    references = {name: drawn(name, "none", rng) for name in objects}
    scenes = []
    for name in objects:
        for number, level in enumerate(only if levels else [CASE_STUDY]):
            partial, full = LEVELS[level] if levels else (0, STUDY_VIEWS - GOOD_VIEWS)
            rest = (VIEWS if levels else STUDY_VIEWS) - partial - full
            kinds = ["partial"] * partial + ["none"] * rest + ["full"] * full
            views = [View(f"robot-{k}", SHARES[kind], kind == "none", 0.0) for k, kind in enumerate(kinds, 1)]
            pairs = [drawn(name, kind, rng) for kind in kinds]
            scenes.append((Scene(f"{name}-{number}", name, level, tuple(views)), pairs))
    kind = "physical" if levels else "case-study"
    return PictureSet.of(kind, references, scenes, {"seed": seed})


def collection(objects: tuple[str, ...] = ("red", "green"), seed: int = 0) -> Collection:
    """Both sets, the first with two levels alone."""
    physical = picture_set(objects, levels=True, seed=seed, only=("none", STUDIED))
    return Collection("simulation", physical, picture_set(objects, levels=False, seed=seed))


def measured(
    settings: Tried,
    grid: Tried,
    design: Design,
    w: np.ndarray = np.arange(6.0),  # noqa: B008 - never changed
    norms: np.ndarray = np.ones(3),  # noqa: B008
    explained: Tried | None = None,
) -> Measured:
    """A scene for each of three objects and level, all of the same weights, of which everything is known.

    The first object's reference is the shortest, and half of the scenes are recognised by the explained
    fraction.
    """
    physical = picture_set(tuple(COLOURS), levels=True).layout
    study = picture_set(tuple(COLOURS), levels=False).layout
    count, best = len(physical.scenes), np.array([3.0, 2.0, 1.0, 0.5, 0.2])
    return Measured(
        design,
        physical,
        Trials(settings, grid),
        np.full(count, 0.5),
        explained,
        np.zeros((count, len(BASELINES), len(design.counts), design.repetitions)),
        Weights(np.tile(w, (count, 1)), np.tile(norms, (count, 1)), (np.zeros(3),)),
        np.tile(np.arange(6.0), (count, 1)),
        study,
        Weights(np.tile(best, (len(study.scenes), 1)), np.ones((len(study.scenes), 3)), ()),
        0,
        {"color": 1, "hog": 1, "lbp": 1},
    )


def write_folder(folder: Path, pictures: PictureSet) -> Path:
    """A set in the form in which simulated ones are kept."""
    layout = pictures.layout
    pairs = list(zip(pictures.pictures, pictures.masks, strict=True))

    def stored(place: str, number: int) -> dict[str, str]:
        picture, mask = pairs[number]
        files = {"file": (f"{place}.png", picture[..., ::-1]), "mask": (f"masks/{place}.png", mask * 255)}
        entry = {}
        for key, (name, pixels) in files.items():
            target = folder / name
            target.parent.mkdir(parents=True, exist_ok=True)
            cv2.imwrite(str(target), pixels.astype(np.uint8))
            digest = "sha256" if key == "file" else "mask_sha256"
            entry |= {key: name, digest: sha256(target.read_bytes()).hexdigest()}
        return entry

    references = [{"object": name} | stored(f"references/{name}", k) for k, name in enumerate(layout.objects)]
    scenes = []
    for scene, rows in layout.rows():
        views = []
        for view, number in zip(scene.views, range(rows.start, rows.stop), strict=True):
            known = {"visible_share": view.visible_share, "obstruction": view.obstruction, "azimuth": 0.0}
            views.append({"name": view.name} | known | stored(f"views/{scene.name}/{view.name}", number))
        above = stored(f"overhead/{scene.name}", rows.start)
        entry = {"overhead": above["file"], "overhead_sha256": above["sha256"], "views": views}
        scenes.append({"name": scene.name, "object": scene.object, "level": scene.level} | entry)
    manifest = {"format": 1, "set": layout.name, "seed": 0, "references": references, "scenes": scenes}
    (folder / "manifest.json").write_text(json.dumps(manifest), encoding="utf-8")
    return folder
