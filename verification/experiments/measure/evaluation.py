"""One set under one configuration: everything that is measured."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from convexperc.features.configuration import UNIT_SUM
from verification.experiments.design import Design
from verification.experiments.measure.baselines import run_baselines
from verification.experiments.measure.configurations import Configuration, first
from verification.experiments.measure.features import Store, bits_name
from verification.experiments.measure.measured import Measured
from verification.experiments.measure.trials import Known, run_explained, run_trials, scored_by_fraction
from verification.experiments.measure.weights import weigh
from verification.experiments.scenes.pictures import STUDIED, Layout

Floats = NDArray[np.float64]
ANY_LENGTH = (UNIT_SUM, "none")
"""Of the levels of the normalisation, those with references of different lengths."""


@dataclass(frozen=True, slots=True)
class Part:
    """A set of pictures as a worker gets it.

    Attributes
    ----------
    layout : Layout
    store : Store
        Of the set's features.
    """

    layout: Layout
    store: Store

    def described(self, configuration: Configuration) -> tuple[Floats, Known]:
        """Features of all pictures, and the references."""
        X = self.store.matrix(configuration)
        if configuration.features.normalisation in ANY_LENGTH:
            X = to_unit_references(X, len(self.layout.objects))
        O = np.ascontiguousarray(X[: len(self.layout.objects)].T)  # noqa: E741 - the paper's symbol
        return X, Known(self.layout.objects, O, configuration.features.modality_sizes, configuration.lambda1)

    def information(self, configuration: Configuration) -> Floats:
        """Bits that each view shares with its object's reference, shape (scenes, views)."""
        bits = self.store.load(bits_name(configuration))
        return np.array([bits[rows] for _, rows in self.layout.rows()])


def to_unit_references(X: Floats, references: int) -> Floats:
    """Divide features by t, the root mean square of the references' lengths.

    F(w, u; X, o, t^2 lambda1, t^2 lambda2, t^3 lambda3) = t^2 F(w, t u; X/t, o/t, lambda1, lambda2, lambda3):
    features of any length are judged at lambdas that grow with it. At the lambdas meant for length 1, long
    features would make every setting nearly lambda2 = lambda3 = 0, and short ones would make w nearly 0.

    Parameters
    ----------
    X : float64 (pictures, d)
        The references first.
    references : int
        How many there are; at least one of them is not zero.
    """
    return np.asarray(X / np.sqrt((X[:references] ** 2).sum(axis=1).mean()))


@dataclass(frozen=True, slots=True)
class Task:
    """What a worker is to do.

    Attributes
    ----------
    collection : str
        "simulation" or "photographs".
    physical, study : Part
        The set in which objects are recognised, and the case study.
    configuration : Configuration
    design : Design
    """

    collection: str
    physical: Part
    study: Part
    configuration: Configuration
    design: Design

    @property
    def name(self) -> str:
        """Unlike that of any other task."""
        return f"{self.collection}-{self.configuration.id}"


def evaluate(task: Task) -> dict[str, Any]:
    """Measure, and judge nothing: see `Measured.as_json`."""
    layout, design, configuration = task.physical.layout, task.design, task.configuration
    X, known = task.physical.described(configuration)
    views, references = task.study.described(configuration)
    default = configuration == first(1)[0]
    case = next((scene.name for scene in layout.scenes if scene.level == STUDIED), "")
    return Measured(
        design,
        layout,
        run_trials(layout, X, known, design),
        scored_by_fraction(layout, X, known),
        run_explained(layout, X, known, design) if default else None,
        run_baselines(layout, X, known, design),
        weigh(layout, X, known, frozenset([case] if default else [])),
        task.physical.information(configuration),
        task.study.layout,
        weigh(task.study.layout, views, references),
        known.shortest,
        known.sizes,
    ).as_json()
