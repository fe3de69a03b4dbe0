"""Scenes in memory: what each robot saw, which pixels show the object, and what is known of the view."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from hashlib import sha256
from typing import Any

import numpy as np
from numpy.typing import NDArray

from convexperc.errors import InputError

Picture = NDArray[np.uint8]
"""(h, w, 3), R, G, B."""
Mask = NDArray[np.bool_]
"""(h, w), true where the object is seen."""

OBSTRUCTIONS = ("none", "partial", "full")
FULL_SHARE, CLEAR_SHARE = 0.05, 0.9
"""At most this share of the object is seen in a fully obstructed view; at least this in a clear one."""
LEVELS = {
    "none": (0, 0),
    "one partial": (1, 0),
    "one full": (0, 1),
    "one full, one partial": (1, 1),
    "two full, two partial": (2, 2),
}
"""How many of a scene's views are partly and fully obstructed."""
STUDIED = "one full, one partial"
"""The level on which the paper looks at single weights."""
CASE_STUDY = "case study"


def obstruction(visible_share: float) -> str:
    """Say how far a view is obstructed, by the share of the object's pixels that are seen."""
    if visible_share <= FULL_SHARE:
        return "full"
    return "none" if visible_share >= CLEAR_SHARE else "partial"


@dataclass(frozen=True, slots=True)
class View:
    """What is known of one robot's view.

    Attributes
    ----------
    name : str
    visible_share : float
        Pixels that show the object, divided by those that show it when nothing stands before it; 0..1.
    good : bool
        In the case study: whether it is a clear view from near the reference's direction.
    azimuth : float or None
        Degrees from the reference's direction, in (-180, 180]; None where it is not known.
    photograph : str or None
        Which photograph the view was made from: several scenes may share one. None of a view that is drawn
        for its scene alone.
    """

    name: str
    visible_share: float
    good: bool = False
    azimuth: float | None = None
    photograph: str | None = None

    def __post_init__(self) -> None:
        if not 0.0 <= self.visible_share <= 1.0:
            raise InputError(f"visible share of {self.name}", value=self.visible_share, must="must be 0..1")

    @property
    def obstruction(self) -> str:
        """One of `OBSTRUCTIONS`."""
        return obstruction(self.visible_share)


@dataclass(frozen=True, slots=True)
class Scene:
    """Several views of one object.

    Attributes
    ----------
    name : str
        Unlike that of any other scene.
    object : str
        What the views show.
    level : str
        One of `LEVELS`, or `CASE_STUDY`.
    views : tuple of View
    """

    name: str
    object: str
    level: str
    views: tuple[View, ...]

    def __post_init__(self) -> None:
        if len({view.name for view in self.views}) < max(1, len(self.views)):
            names = [view.name for view in self.views]
            raise InputError(
                f"views of {self.name}", value=names, must="must be there, all named differently"
            )


@dataclass(frozen=True, slots=True)
class Layout:
    """All that is known of a set but its pixels, which are numbered: references first, then view by view.

    Attributes
    ----------
    name : str
        Seeds what is drawn at random for the set.
    objects : tuple of str
        The known objects, in the order of their references.
    scenes : tuple of Scene
    digest : str
        Of the pixels, see `PictureSet`.
    """

    name: str
    objects: tuple[str, ...]
    scenes: tuple[Scene, ...]
    digest: str

    def rows(self) -> Iterator[tuple[Scene, slice]]:
        """Each scene with the numbers of its views' pictures."""
        start = len(self.objects)
        for scene in self.scenes:
            yield scene, slice(start, start + len(scene.views))
            start += len(scene.views)

    def truth(self, scene: Scene) -> int:
        """Return the number of the scene's own reference."""
        return self.objects.index(scene.object)


@dataclass(frozen=True, slots=True, eq=False)
class PictureSet:
    """A layout with its pixels.

    Attributes
    ----------
    layout : Layout
    pictures, masks : tuple of arrays
        One of each for every reference, then for every view.
    source : dict
        Where the pictures come from: plain JSON values.

    Raises
    ------
    InputError
        Pictures and layout do not fit together.
    """

    layout: Layout
    pictures: tuple[Picture, ...]
    masks: tuple[Mask, ...]
    source: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        layout = self.layout
        wanted = len(layout.objects) + sum(len(scene.views) for scene in layout.scenes)
        if not len(self.pictures) == len(self.masks) == wanted:
            found = len(self.pictures), len(self.masks)
            raise InputError("pictures and masks", value=found, must=f"must be {wanted} each")
        for number, (picture, mask) in enumerate(zip(self.pictures, self.masks, strict=True)):
            if picture.shape != (*mask.shape, 3) or picture.dtype != np.uint8 or mask.dtype != np.bool_:
                sizes = picture.shape, mask.shape
                raise InputError(f"mask {number}", value=sizes, must="must have the size of its picture")

    @classmethod
    def of(
        cls,
        name: str,
        references: dict[str, tuple[Picture, Mask]],
        scenes: list[tuple[Scene, list[tuple[Picture, Mask]]]],
        source: dict[str, Any],
    ) -> "PictureSet":
        """Number the pictures and take their digest."""
        seen = [*references.values(), *(pair for _, views in scenes for pair in views)]
        pictures, masks = tuple(picture for picture, _ in seen), tuple(mask for _, mask in seen)
        known = tuple(scene for scene, _ in scenes)
        layout = Layout(name, tuple(references), known, _digest(name, tuple(references), known, seen))
        _check(layout)
        return cls(layout, pictures, masks, source)


def _check(layout: Layout) -> None:
    """Names are different, and each scene's object is known."""
    names = [scene.name for scene in layout.scenes]
    if len(set(names)) < len(names) or not names:
        raise InputError(f"scenes of {layout.name}", value=names, must="must be there, all named differently")
    for scene in layout.scenes:
        if scene.object not in layout.objects:
            must = f"must be one of {', '.join(layout.objects)}"
            raise InputError(f"object of {scene.name}", value=scene.object, must=must)


def _digest(
    name: str, objects: tuple[str, ...], scenes: tuple[Scene, ...], seen: list[tuple[Picture, Mask]]
) -> str:
    """SHA-256 over what is known of the views and over every picture and mask in order."""
    sha = sha256(repr((name, objects, scenes)).encode())
    for picture, mask in seen:
        sha.update(repr(picture.shape).encode() + picture.tobytes() + np.packbits(mask).tobytes())
    return sha.hexdigest()
