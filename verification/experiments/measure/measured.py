"""What is measured on one set of pictures under one configuration: what verdicts rest on, and no verdict."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from verification.experiments.design import Design
from verification.experiments.measure.arrays import packed, unpacked
from verification.experiments.measure.trials import Trials, Tried
from verification.experiments.measure.weights import Weights
from verification.experiments.scenes.pictures import STUDIED, Layout

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Measured:
    """All that was measured under one configuration.

    Attributes
    ----------
    design : Design
    layout : Layout
        Of the scenes in which objects are recognised.
    trials : Trials
    by_fraction : float64 (scenes,)
        Score of all views with both norms, decided by the explained fraction.
    explained : Tried or None
        Trials of the settings, decided by the explained fraction; of the default configuration alone.
    baselines : float64 (scenes, baselines, counts, repetitions)
        Scores of simpler ways.
    weights : Weights
    information : float64 (scenes, views)
        Mutual information of each view and the object's reference, in bits.
    study : Layout
        Of the case study.
    study_weights : Weights
    shortest : int or None
        The reference of the smallest length; None where all are equally long.
    sizes : dict of str to int
        Columns of each modality.
    """

    design: Design
    layout: Layout
    trials: Trials
    by_fraction: Floats
    explained: Tried | None
    baselines: Floats
    weights: Weights
    information: Floats
    study: Layout
    study_weights: Weights
    shortest: int | None
    sizes: dict[str, int]

    @property
    def accuracy(self) -> Floats:
        """Mean score over the repetitions, shape (scenes, settings, counts)."""
        return np.asarray(self.trials.settings.scores.mean(axis=3))

    @property
    def cells(self) -> Floats:
        """Mean score on the grid, shape (scenes, values of lambda2, values of lambda3)."""
        return np.asarray(self.trials.grid.scores.mean(axis=3))

    def studied(self) -> NDArray[np.bool_]:
        """Which scenes have one fully and one partly obstructed view."""
        return np.array([scene.level == STUDIED for scene in self.layout.scenes])

    def obstructed(self) -> NDArray[np.bool_]:
        """Which views are obstructed, shape (scenes, views)."""
        kinds = [[view.obstruction for view in scene.views] for scene in self.layout.scenes]
        return np.asarray(np.array(kinds) != "none")

    def as_json(self) -> dict[str, Any]:
        """Plain data without the design and the layouts."""
        return {
            "settings": _tried(self.trials.settings),
            "grid": _tried(self.trials.grid),
            "by_fraction": packed(self.by_fraction),
            "explained": None if self.explained is None else _tried(self.explained),
            "baselines": packed(self.baselines),
            "weights": _weights(self.weights),
            "information": packed(self.information),
            "study_weights": _weights(self.study_weights),
            "shortest": self.shortest,
            "sizes": self.sizes,
        }

    @classmethod
    def from_json(cls, data: dict[str, Any], design: Design, layout: Layout, study: Layout) -> "Measured":
        """Read back what `as_json` gave."""
        explained = data["explained"]
        return cls(
            design,
            layout,
            Trials(_as_tried(data["settings"]), _as_tried(data["grid"])),
            unpacked(data["by_fraction"]),
            None if explained is None else _as_tried(explained),
            unpacked(data["baselines"]),
            _as_weights(data["weights"]),
            unpacked(data["information"]),
            study,
            _as_weights(data["study_weights"]),
            data["shortest"],
            data["sizes"],
        )


def _tried(found: Tried) -> dict[str, Any]:
    return {
        "kinds": packed(found.kinds.astype(np.int8)),
        "scores": packed(found.scores),
        "labels": packed(found.labels.astype(np.int16)),
    }


def _as_tried(data: dict[str, Any]) -> Tried:
    kinds, labels = (unpacked(data[name]).astype(np.int64) for name in ("kinds", "labels"))
    return Tried(kinds, unpacked(data["scores"]), labels)


def _weights(found: Weights) -> dict[str, Any]:
    return {"w": packed(found.w), "norms": packed(found.norms), "u": [packed(u) for u in found.u]}


def _as_weights(data: dict[str, Any]) -> Weights:
    return Weights(unpacked(data["w"]), unpacked(data["norms"]), tuple(unpacked(u) for u in data["u"]))
