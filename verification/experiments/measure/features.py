"""Features of every picture of a set, each modality computed once for each way to make it, and kept."""

import io
import json
from collections.abc import Callable, Iterable
from dataclasses import dataclass, fields
from functools import cache
from hashlib import sha256
from pathlib import Path

import numpy as np
from joblib import Parallel, delayed
from numpy.typing import NDArray

from convexperc.features.color import color_histogram
from convexperc.features.configuration import FeatureConfiguration
from convexperc.features.extraction import normalise
from convexperc.features.hog import hog_descriptor
from convexperc.features.lbp import lbp_histogram
from convexperc.features.pictures import resize, to_gray
from convexperc.files import write_atomic
from verification.experiments.measure.configurations import Configuration
from verification.experiments.measure.information import mutual_information
from verification.experiments.scenes.pictures import Layout, Mask, Picture, PictureSet
from verification.provenance import code_digest, versions

GRAY = 128
"""What stands in place of a background that is left out, in all three colours."""
Floats = NDArray[np.float64]
MODALITIES: dict[str, Callable[[Picture, FeatureConfiguration], Floats]] = {
    "color": color_histogram,
    "hog": lambda picture, configuration: hog_descriptor(to_gray(picture), configuration),
    "lbp": lambda picture, configuration: lbp_histogram(to_gray(picture), configuration),
}


@cache
def _source() -> str:
    """Of all that describes pictures: source files and versions."""
    source = code_digest("convexperc/features", "verification/experiments/measure/features.py")
    return source + json.dumps(versions(), sort_keys=True)


@dataclass(frozen=True, slots=True)
class Block:
    """One modality, made in one way.

    Attributes
    ----------
    modality : str
    background : bool
        Whether pixels are kept that do not show the object.
    features : FeatureConfiguration
        With the defaults for all that does not concern the modality.
    """

    modality: str
    background: bool
    features: FeatureConfiguration


def blocks(configuration: Configuration) -> tuple[Block, ...]:
    """What a configuration's features are joined from, before they are normalised."""
    features = configuration.features
    found = []
    for modality in MODALITIES:
        names = [each.name for each in fields(features) if each.name.startswith(f"{modality}_")]
        own = {name: getattr(features, name) for name in names}
        own["working_size"] = features.working_size
        found.append(Block(modality, configuration.background, FeatureConfiguration(**own)))
    return tuple(found)


@dataclass(frozen=True, slots=True)
class Store:
    """Features on disk, named by all that they depend on.

    Attributes
    ----------
    folder : Path
        It is there.
    digest : str
        Of the set of pictures.
    count : int
        How many pictures the set has.
    """

    folder: Path
    digest: str
    count: int

    @classmethod
    def of(cls, folder: Path, pictures: PictureSet) -> "Store":
        """Make the folder where it is missing."""
        folder.mkdir(parents=True, exist_ok=True)
        return cls(folder, pictures.layout.digest, len(pictures.pictures))

    def place(self, name: object) -> Path:
        """The file of what has this name."""
        text = json.dumps([_source(), self.digest, repr(name)])
        return self.folder / f"{sha256(text.encode()).hexdigest()[:32]}.npy"

    def known(self, name: object) -> bool:
        """Whether that file is there and whole."""
        try:
            return len(np.load(self.place(name), mmap_mode="r")) == self.count
        except (OSError, ValueError, EOFError):
            return False

    def load(self, name: object) -> NDArray[np.generic]:
        """Read it without a copy."""
        found: NDArray[np.generic] = np.load(self.place(name), mmap_mode="r")
        return found

    def save(self, name: object, values: NDArray[np.generic]) -> None:
        """Write it, whole or not at all."""
        stream = io.BytesIO()
        np.save(stream, values)
        write_atomic(self.place(name), stream.getvalue())

    def pictures(self, size: tuple[int, int], *, background: bool) -> NDArray[np.uint8]:
        """Pictures at the working size, shape (count, height, width, 3)."""
        return np.asarray(self.load(_prepared(size, background)), dtype=np.uint8)

    def matrix(self, configuration: Configuration) -> Floats:
        """Features of all pictures under one configuration, shape (count, d)."""
        parts = {block.modality: self.load(block) for block in blocks(configuration)}
        rows = [{name: part[k] for name, part in parts.items()} for k in range(self.count)]
        return np.stack([normalise(row, configuration.features.normalisation) for row in rows])


def prepare(
    pictures: PictureSet,
    store: Store,
    configurations: Iterable[Configuration],
    workers: int,
    progress: Callable[[int, int], None],
) -> None:
    """Compute what the configurations need and the store does not have.

    Parameters
    ----------
    pictures : PictureSet
        That of the store.
    store : Store
    configurations : iterable of Configuration
    workers : int
        Processes.
    progress : callable
        Called with how many blocks are done, of how many.
    """
    chosen = list(dict.fromkeys(block for configuration in configurations for block in blocks(configuration)))
    for size, background in dict.fromkeys((b.features.working_size, b.background) for b in chosen):
        name = _prepared(size, background)
        if not store.known(name):
            store.save(name, _resized(pictures, size, background=background))
        if not store.known(bits := _bits(size, background)):
            store.save(bits, _information(pictures.layout, store.pictures(size, background=background)))
    missing = [block for block in chosen if not store.known(block)]
    done = Parallel(n_jobs=workers, return_as="generator_unordered", batch_size=1)(
        delayed(_compute)(store, block) for block in missing
    )
    for count, _ in enumerate(done, 1):
        progress(count, len(missing))


def without_background(picture: Picture, mask: Mask) -> Picture:
    """Return the picture with gray in place of all that is not the object."""
    return np.where(mask[..., None], picture, np.uint8(GRAY))


def bits_name(configuration: Configuration) -> str:
    """Name in the store of the bits that each picture shares with its object's reference."""
    return _bits(configuration.features.working_size, configuration.background)


def _bits(size: tuple[int, int], background: bool) -> str:
    return f"bits shared with the reference, {_prepared(size, background)}"


def _information(layout: Layout, pictures: NDArray[np.uint8]) -> Floats:
    """Bits of each view and its object's reference; of a reference, all that it has."""
    gray = [to_gray(picture) for picture in pictures]
    owners = list(range(len(layout.objects)))
    owners += [layout.truth(scene) for scene in layout.scenes for _ in scene.views]
    return np.array([mutual_information(view, gray[k]) for view, k in zip(gray, owners, strict=True)])


def _prepared(size: tuple[int, int], background: bool) -> str:
    return f"pictures {size[0]} x {size[1]}, background {background}"


def _resized(pictures: PictureSet, size: tuple[int, int], *, background: bool) -> NDArray[np.uint8]:
    pairs = zip(pictures.pictures, pictures.masks, strict=True)
    chosen = (picture if background else without_background(picture, mask) for picture, mask in pairs)
    return np.stack([resize(picture, size) for picture in chosen])


def _compute(store: Store, block: Block) -> None:
    pictures = store.pictures(block.features.working_size, background=block.background)
    describe = MODALITIES[block.modality]
    store.save(block, np.stack([describe(picture, block.features) for picture in pictures]))
