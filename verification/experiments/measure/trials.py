"""Every trial of a set under one configuration: who is recognised, by proof, and what it scores."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from convexperc import recognize_path
from convexperc.recognition.decision import Decision
from convexperc.recognition.recognition import Recognition, Verdict
from verification.experiments.design import BOTH, GRID, SETTINGS, Design, Pair
from verification.experiments.measure.subsets import Subset, drawn, of_grid
from verification.experiments.scenes.pictures import Layout

Floats = NDArray[np.float64]

KINDS = ("right", "wrong", "tie", "undecided")
TOLERANCE = 1e-6
"""Relative gap to which the best template is certified.
A label is proved by disjoint intervals, whatever this is."""
LENGTH_ROUNDING = 1e-9
"""Relative difference of lengths that rounding explains."""
RIGHT, WRONG, TIE, UNDECIDED = range(4)


@dataclass(frozen=True, slots=True)
class Known:
    """The references under one configuration, and how they are compared.

    Attributes
    ----------
    names : tuple of str
    O : float64 (d, p)
    sizes : dict of str to int
        Columns of each modality.
    lambda1 : float
    """

    names: tuple[str, ...]
    O: Floats  # noqa: E741 - the paper's symbol
    sizes: dict[str, int]
    lambda1: float

    @property
    def shortest(self) -> int | None:
        """The reference of the smallest length; None where all are equally long."""
        lengths = np.linalg.norm(self.O, axis=0)
        return None if lengths.max() <= lengths.min() * (1.0 + LENGTH_ROUNDING) else int(lengths.argmin())


@dataclass(frozen=True, slots=True)
class TrialOutcome:
    """What came of one trial.

    Attributes
    ----------
    kind : int
        Index into `KINDS`.
    score : float
        The chance that a fair draw among the candidates is right.
    label : int
        The proved label, -1 without.
    """

    kind: int
    score: float
    label: int


@dataclass(frozen=True, slots=True, eq=False)
class Tried:
    """Outcomes as arrays of one shape.

    Attributes
    ----------
    kinds, labels : int (...)
    scores : float64 (...)
    """

    kinds: NDArray[np.int64]
    scores: Floats
    labels: NDArray[np.int64]

    @classmethod
    def of(cls, outcomes: Iterable[TrialOutcome], shape: tuple[int, ...]) -> "Tried":
        """Arrange outcomes, the last axis fastest."""
        found = list(outcomes)
        return cls(
            np.array([each.kind for each in found], dtype=np.int64).reshape(shape),
            np.array([each.score for each in found], dtype=np.float64).reshape(shape),
            np.array([each.label for each in found], dtype=np.int64).reshape(shape),
        )

    @property
    def open(self) -> NDArray[np.bool_]:
        """Where no label is proved."""
        return self.labels < 0


@dataclass(frozen=True, slots=True, eq=False)
class Trials:
    """All trials of a set.

    Attributes
    ----------
    settings : Tried
        Shape (scenes, settings, counts, repetitions).
    grid : Tried
        Shape (scenes, values of lambda2, values of lambda3, 2): the first three views, then all.
    """

    settings: Tried
    grid: Tried


def scored(found: Recognition, truth: int) -> TrialOutcome:
    """Score a recognition so that the order of the objects does not matter.

    Parameters
    ----------
    found : Recognition
    truth : int
        The object's number among the templates.
    """
    if found.verdict is Verdict.PROVED:
        label = found.names.index(found.candidates[0])
        return TrialOutcome(RIGHT if label == truth else WRONG, float(label == truth), label)
    chance = 1.0 / len(found.candidates) if found.names[truth] in found.candidates else 0.0
    return TrialOutcome(TIE if found.verdict is Verdict.TIE else UNDECIDED, chance, -1)


def run_trials(layout: Layout, X: Floats, known: Known, design: Design) -> Trials:
    """Recognise every subset of every scene under every choice of the lambdas.

    Parameters
    ----------
    layout : Layout
    X : float64 (pictures, d)
        A row a picture, in the layout's order.
    known : Known
    design : Design
    """
    settings: list[TrialOutcome] = []
    grid: list[TrialOutcome] = []
    for scene, rows in layout.rows():
        subsets = drawn(design, layout.name, scene)
        two = of_grid(subsets)
        wanted = {s: SETTINGS for each in subsets for s in each}
        wanted |= {s: tuple(dict.fromkeys([*SETTINGS, *design.pairs])) for s in two}
        found = _outcomes(X[rows], known, layout.truth(scene), wanted, Decision.OBJECTIVE)
        settings += [found[s, pair] for pair in SETTINGS for each in subsets for s in each]
        grid += [found[s, pair] for pair in design.pairs for s in two]
    side = len(GRID)
    return Trials(
        Tried.of(settings, _shape(layout, design)), Tried.of(grid, (len(layout.scenes), side, side, 2))
    )


def run_explained(layout: Layout, X: Floats, known: Known, design: Design) -> Tried:
    """Decide the trials of the settings by F* / ||o||^2 in place of F*; see `run_trials`."""
    settings: list[TrialOutcome] = []
    for scene, rows in layout.rows():
        subsets = drawn(design, layout.name, scene)
        wanted = {s: SETTINGS for each in subsets for s in each}
        found = _outcomes(X[rows], known, layout.truth(scene), wanted, Decision.EXPLAINED_FRACTION)
        settings += [found[s, pair] for pair in SETTINGS for each in subsets for s in each]
    return Tried.of(settings, _shape(layout, design))


def scored_by_fraction(layout: Layout, X: Floats, known: Known) -> Floats:
    """Score of all views with both norms, decided by F* / ||o||^2, shape (scenes,)."""
    scores = []
    for scene, rows in layout.rows():
        (found,) = recognitions(X[rows], known, [BOTH], Decision.EXPLAINED_FRACTION)
        scores.append(scored(found, layout.truth(scene)).score)
    return np.array(scores)


def _shape(layout: Layout, design: Design) -> tuple[int, ...]:
    return len(layout.scenes), len(SETTINGS), len(design.counts), design.repetitions


def _outcomes(
    views: Floats, known: Known, truth: int, wanted: Mapping[Subset, Sequence[Pair]], decision: Decision
) -> dict[tuple[Subset, Pair], TrialOutcome]:
    """Each subset and choice of the lambdas once."""
    found: dict[tuple[Subset, Pair], TrialOutcome] = {}
    for subset, pairs in wanted.items():
        results = recognitions(views[list(subset)], known, pairs, decision)
        found |= {(subset, pair): scored(each, truth) for pair, each in zip(pairs, results, strict=True)}
    return found


def recognitions(
    X: Floats, known: Known, pairs: Iterable[Pair], decision: Decision = Decision.OBJECTIVE
) -> Iterator[Recognition]:
    """Recognise one set of views under each (lambda2, lambda3); the data are read once."""
    grid = ((known.lambda1, lambda2, lambda3) for lambda2, lambda3 in pairs)
    return recognize_path(
        X,
        known.O,
        grid,
        modalities=known.sizes,
        names=known.names,
        decision=decision,
        relative_tolerance=TOLERANCE,
    )
