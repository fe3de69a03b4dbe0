"""Two sets of pictures of one origin: one in which objects are recognised, one in which views are ranked."""

from dataclasses import dataclass
from pathlib import Path

from verification.experiments.measure.evaluation import Part
from verification.experiments.measure.features import Store
from verification.experiments.record.contents import PHOTOGRAPHS, Head
from verification.experiments.scenes.folder import read_case_study, read_physical
from verification.experiments.scenes.photos import draw_photographs
from verification.experiments.scenes.pictures import PictureSet
from verification.ledger.surveys import DECIDING
from verification.provenance import digest


@dataclass(frozen=True, slots=True, eq=False)
class Collection:
    """Both sets.

    Attributes
    ----------
    name : str
    physical, study : PictureSet
    """

    name: str
    physical: PictureSet
    study: PictureSet

    @classmethod
    def simulated(cls, physical: Path, study: Path) -> "Collection":
        """Read the simulation's two folders; for errors see `read_physical`."""
        return cls(DECIDING, read_physical(physical), read_case_study(study))

    @classmethod
    def photographed(cls, folder: Path, seed: int) -> "Collection":
        """Draw scenes from photographs; for errors see `draw_photographs`."""
        return cls(PHOTOGRAPHS, *draw_photographs(folder, seed))

    @property
    def digest(self) -> str:
        """Of all pictures and masks."""
        return digest([self.physical.layout.digest, self.study.layout.digest])

    def parts(self, cache: Path) -> tuple[Part, Part]:
        """Both sets as workers get them."""
        sets = self.physical, self.study
        first, second = (Part(each.layout, Store.of(cache, each)) for each in sets)
        return first, second

    def as_json(self) -> Head:
        """The record's head of the set."""
        scenes = self.physical.layout.scenes
        levels = [scene.level for scene in scenes]
        study = self.study.layout
        return {
            "name": self.name,
            "digest": self.digest,
            "source": self.physical.source,
            "objects": list(self.physical.layout.objects),
            "scenes": len(scenes),
            "views": sum(len(scene.views) for scene in scenes),
            "levels": {level: levels.count(level) for level in dict.fromkeys(levels)},
            "case_study": {
                "objects": list(study.objects),
                "scenes": len(study.scenes),
                "views": sum(len(scene.views) for scene in study.scenes),
                "source": self.study.source,
            },
        }
