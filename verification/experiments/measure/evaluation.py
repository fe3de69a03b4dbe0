"""One set under one configuration: everything measured, judged, and put into plain values."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from verification.experiments.design import Design
from verification.experiments.measure.baselines import BASELINES, run_baselines
from verification.experiments.measure.claims import CLAIMS, Measured
from verification.experiments.measure.configurations import Configuration, first
from verification.experiments.measure.contents import Entry
from verification.experiments.measure.detail import detail
from verification.experiments.measure.features import Store, bits_name
from verification.experiments.measure.limits import limits
from verification.experiments.measure.numbers import rounded
from verification.experiments.measure.trials import Known, run_explained, run_trials, score_explained
from verification.experiments.measure.verdicts import entry, judge, rule_of
from verification.experiments.measure.weights import weigh
from verification.experiments.scenes.pictures import STUDIED, Layout

Floats = NDArray[np.float64]


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
        O = np.ascontiguousarray(X[: len(self.layout.objects)].T)  # noqa: E741 - the paper's symbol
        return X, Known(self.layout.objects, O, configuration.features.modality_sizes, configuration.lambda1)

    def information(self, configuration: Configuration) -> Floats:
        """Bits that each view shares with its object's reference, shape (scenes, views)."""
        bits = self.store.load(bits_name(configuration))
        return np.array([bits[rows] for _, rows in self.layout.rows()])


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
    """Measure and judge.

    Returns
    -------
    dict
        Plain JSON values: "reading" as the record has it, "limits", and "default" for the default one.
    """
    layout, design, configuration = task.physical.layout, task.design, task.configuration
    X, known = task.physical.described(configuration)
    views, references = task.study.described(configuration)
    default = configuration == first(1)[0]
    case = next((scene.name for scene in layout.scenes if scene.level == STUDIED), "")
    measured = Measured(
        design,
        layout,
        run_trials(layout, X, known, design),
        weigh(layout, X, known, frozenset([case] if default else [])),
        task.physical.information(configuration),
        task.study.layout,
        weigh(task.study.layout, views, references),
    )
    baselines = run_baselines(layout, X, known, design)
    found: dict[str, Any] = {
        "reading": recorded(measured, configuration, baselines),
        "limits": limits(measured, known, score_explained(layout, X, known)),
    }
    if default:
        found["default"] = detail(measured, run_explained(layout, X, known, design), baselines, known)
    return found


def recorded(measured: Measured, configuration: Configuration, baselines: Floats) -> Entry:
    """The record's entry of one configuration."""
    judged = {part: judge(claim(measured), rule_of(part), measured.design) for part, claim in CLAIMS.items()}
    settings = measured.trials.settings
    return {
        "id": configuration.id,
        "levels": configuration.as_json(),
        "claims": {part: entry(each, rule_of(part)) for part, each in judged.items()},
        "accuracy": rounded(settings.scores.mean(axis=(0, 3))),
        "open": rounded(settings.open.mean(axis=(0, 3))),
        "baselines": dict(zip(BASELINES, rounded(baselines.mean(axis=(0, 3))), strict=True)),
        "grid": rounded(measured.cells.mean(axis=0)),
        "chance": rounded(1.0 / len(measured.layout.objects)),
    }
