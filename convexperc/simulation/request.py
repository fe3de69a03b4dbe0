"""The request of a data set: everything that determines its files."""

import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal

from convexperc.errors import InputError
from convexperc.simulation import case_study, physical
from convexperc.simulation.catalogue import Catalogue
from convexperc.simulation.checks import check_range
from convexperc.simulation.image_size import ImageSize
from convexperc.simulation.manifest import manifest_head
from convexperc.simulation.objects import CASE_STUDY, PHYSICAL
from convexperc.simulation.opengl import Engine
from convexperc.simulation.proposing import Plan

SetName = Literal["physical", "case-study"]

OBJECTS_OF: dict[SetName, tuple[str, ...]] = {
    "physical": tuple(model.name for model in PHYSICAL),
    "case-study": tuple(model.name for model in CASE_STUDY),
}
"""Default objects of each kind of data set."""


@dataclass(frozen=True, slots=True)
class Request:
    """A data set to be drawn.

    Attributes
    ----------
    set : {"physical", "case-study"}
        The kind of scenes.
    seed : int
        Seed of every random layout.
    scenes : int
        Number of scenes of each object and, in the physical set, of each level.
    objects : tuple of str
        Names of objects, at least one, all different.
    size : ImageSize
        Size of the views.

    Raises
    ------
    InputError
        A number is out of range, or an object is named twice, or none is named.
    """

    set: SetName
    seed: int
    scenes: int
    objects: tuple[str, ...]
    size: ImageSize

    def __post_init__(self) -> None:
        check_range("seed", self.seed, 0, 2**63 - 1)
        check_range("scenes", self.scenes, 1, 99)
        if min(self.size.width, self.size.height) < 32:
            raise InputError("size", value=self.size, must="must be at least 32 pixels a side")
        if not self.objects or len(set(self.objects)) < len(self.objects):
            must = "must name at least one object, each once"
            raise InputError("objects", value=self.objects, must=must)

    def plans(self) -> Iterator[tuple[str, Plan]]:
        """Yield the object and plan of every scene; a scene does not depend on the others of the request."""
        for name in self.objects:
            if self.set == "case-study":
                for number in range(1, self.scenes + 1):
                    # The first scene of the package's own objects is laid out by hand.
                    title = name if number == 1 else f"{name}-{number:02d}"
                    yield name, Plan(title, number, case_study.LEVEL, self._seed(title))
                continue
            for place, level in enumerate(physical.LEVELS, start=1):
                for number in range(1, self.scenes + 1):
                    title = f"{name}-{place}-{number:02d}"
                    yield name, Plan(title, number, level.name, self._seed(title))

    def _seed(self, title: str) -> tuple[int, ...]:
        return self.seed, zlib.crc32(f"{self.set}/{title}".encode())

    def record(self, engine: Engine, objects: Catalogue) -> dict[str, Any]:
        """Return the head of the manifest, plain JSON values.

        Raises
        ------
        InputError
            An object is not known.
        """
        head = manifest_head(self.set, self.seed, self.objects, self.size, engine, objects)
        return {**head, "scenes_each": self.scenes}
