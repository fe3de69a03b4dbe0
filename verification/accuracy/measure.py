"""Everything that is measured on one collection of photographs under one feature configuration."""

from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from convexperc.features import FeatureConfiguration
from convexperc.recognition import Acceptance, Calibration, Verdict
from verification.accuracy.methods import LAMBDAS, METHODS, PAPER, Known, Named, mean_distances, name_by_all
from verification.accuracy.object_sets import Fold, ObjectSet, groups, object_sets, unknown_sets
from verification.accuracy.scenes import CONDITIONS, COVERED, Described, Sizes, Split, Trial, compose
from verification.accuracy.statistics import figures, quartiles, separation
from verification.experiments.design import Design
from verification.experiments.scenes.album import Album
from verification.experiments.scenes.pictures import Scene

COVERAGES = (0.8, 0.9, 0.95)
Progress = Callable[[str, int, int], None]


def measure(
    albums: Sequence[Album], configuration: FeatureConfiguration, sizes: Sizes, design: Design, told: Progress
) -> dict[str, Any]:
    """Measure accuracy, margins and acceptance.

    Parameters
    ----------
    albums : sequence of Album
    configuration : FeatureConfiguration
    sizes : Sizes
    design : Design
        Its `seed` and `resamples`.
    told : callable
        Called with a stage, how much of it is done, and of how much.

    Returns
    -------
    dict
        Plain JSON values.

    Raises
    ------
    InputError
        An album has too few photographs, or a photograph is a reference and a view.
    """
    described = Described.of(albums, configuration)
    parts = groups([album.object for album in albums])
    grouped = {name for part in parts for name in part}
    others = {name: [each for each in part if each != name] for part in parts for name in part}
    chosen = object_sets([album.object for album in albums], sizes.references)
    unknown = unknown_sets([album.object for album in albums], sizes.references)
    named: dict[tuple[str, str], list[tuple[Scene, Named]]] = defaultdict(list)
    judged: dict[str, list[_Judged]] = defaultdict(list)
    calibrated = True
    for draw in range(sizes.draws):
        splits = {a.object: Split.of(a, sizes, draw) for a in albums if a.object in grouped}
        tests = {each: compose(splits, described, each, sizes, draw, others=others) for each in CONDITIONS}
        for place, each in enumerate(chosen):
            told("object sets", draw * len(chosen) + place, sizes.draws * len(chosen))
            _name(each, tests, splits, described, named)
        setting = compose(splits, described, COVERED, sizes, draw, calibration=True)
        calibrated = calibrated and {trial.scene.object for trial in setting} == grouped
        for each in unknown if calibrated else ():
            for fold in each.folds:
                known = Known.of(fold, each.references, splits, described, machine=False)
                judged[each.name] += _judge(known, fold, setting, tests[COVERED])
    told("object sets", sizes.draws * len(chosen), sizes.draws * len(chosen))
    pairs = [(each, of, named[each.name, of]) for each in chosen for of in CONDITIONS]
    return {
        "accuracy": [_accuracy(*pair, design) for pair in pairs],
        "margin": [_margin(*pair, design) for pair in pairs],
        "acceptance": [_acceptance(each, judged[each.name], design) for each in unknown if calibrated],
        "not calibrated": None if calibrated else "too few photographs for scenes of their own",
    }


def _name(
    chosen: ObjectSet,
    tests: Mapping[str, list[Trial]],
    splits: Mapping[str, Split],
    described: Described,
    named: dict[tuple[str, str], list[tuple[Scene, Named]]],
) -> None:
    """Name the object of every scene of a set, and note what the methods say."""
    for fold in chosen.folds:
        known = Known.of(fold, chosen.references, splits, described, machine=True)
        for condition, trials in tests.items():
            named[chosen.name, condition] += [
                (trial.scene, name_by_all(known, trial, fold.tested[trial.scene.object]))
                for trial in trials
                if trial.scene.object in fold.tested
            ]


def _ordered(
    found: list[tuple[Scene, Named]],
) -> tuple[list[Scene], list[Named]]:
    """Sort by the names of the scenes: the resamples of all sets are then the same."""
    ordered = sorted(found, key=lambda each: each[0].name)
    return [scene for scene, _ in ordered], [each for _, each in ordered]


def _accuracy(
    chosen: ObjectSet, condition: str, found: list[tuple[Scene, Named]], design: Design
) -> dict[str, Any]:
    """Share of right labels of each method, and the paper's share minus that of each other one."""
    scenes, named = _ordered(found)
    scores = np.array([each.scores for each in named])
    less = scores[:, :1] - scores[:, 1:]
    told = figures(np.hstack([scores, less]), scenes, design)
    proved = [each for each in named if each.proved]
    return {
        "objects": chosen.name,
        "condition": condition,
        "scenes": len(scenes),
        "templates": len(chosen.folds[0].known) * chosen.references,
        "methods": dict(zip(METHODS, told[: len(METHODS)], strict=True)),
        f"{PAPER[0]} minus": dict(zip(METHODS[1:], told[len(METHODS) :], strict=True)),
        "proved": len(proved),
        "proved and wrong": sum(not each.right for each in proved),
    }


def _margin(
    chosen: ObjectSet, condition: str, found: list[tuple[Scene, Named]], design: Design
) -> dict[str, Any]:
    """How well margins tell right labels from wrong ones: of the paper's rule, and of the nearest object."""
    scenes, named = _ordered(found)
    column = METHODS.index("nearest to mean")
    kinds = {
        PAPER[0]: ([each.margin for each in named], [each.right for each in named]),
        METHODS[column]: (
            [each.nearest_margin for each in named],
            [each.scores[column] == 1.0 for each in named],
        ),
    }
    told: dict[str, Any] = {"objects": chosen.name, "condition": condition}
    for name, (margins, right) in kinds.items():
        values, owners = np.array(margins), [scene.object for scene in scenes]
        good, bad = np.flatnonzero(right), np.flatnonzero(~np.array(right))
        auc = separation(
            values[good], values[bad], [owners[k] for k in good], [owners[k] for k in bad], design
        )
        told[name] = {
            "right": good.size,
            "wrong": bad.size,
            "auc": auc,
            "quartiles": quartiles(values, right),
        }
    return told


@dataclass(frozen=True, slots=True)
class _Judged:
    """A test scene by one library: what was proved, and what each calibration accepts.

    Attributes
    ----------
    scene : Scene
    known : bool
        Whether its object is.
    proved, right : bool
        Whether a label is proved, and whether the first candidate is the object.
    covered, alone : tuple of bool
        Whether the object is among those accepted, and the only one; one entry a coverage.
    kinds : tuple of Acceptance
    share : float
        The least F* / ||o||^2 of all templates.
    distance : float
        The least squared distance of the mean of the views from a reference.
    calibrated : int
        Scenes that set the thresholds.
    """

    scene: Scene
    known: bool
    proved: bool
    right: bool
    covered: tuple[bool, ...]
    alone: tuple[bool, ...]
    kinds: tuple[Acceptance, ...]
    share: float
    distance: float
    calibrated: int

    @classmethod
    def of(cls, known: Known, trial: Trial, truth: str, made: Sequence[Calibration]) -> "_Judged":
        """Recognise a scene, and judge it by each calibration."""
        (found,) = known.recognise(trial, LAMBDAS[:1])
        judgements = [each.judge(found) for each in made]
        return cls(
            trial.scene,
            truth in known.library.objects,
            found.verdict is Verdict.PROVED,
            found.candidates[0] == truth,
            tuple(truth in each.accepted for each in judgements),
            tuple(each.accepted == (truth,) for each in judgements),
            tuple(each.acceptance for each in judgements),
            float((found.answers.upper / known.library.lengths.squares).min()),
            float(mean_distances(known.library, trial.X).min()),
            made[0].scenes,
        )


def _judge(known: Known, fold: Fold, setting: list[Trial], tests: list[Trial]) -> list[_Judged]:
    """Set thresholds by the scenes of known objects, for each coverage, and judge all test scenes."""
    labelled = [
        (known.recognise(trial, LAMBDAS[:1])[0], fold.known[trial.scene.object])
        for trial in setting
        if trial.scene.object in fold.known
    ]
    made = [Calibration.of(labelled, coverage) for coverage in COVERAGES]
    return [_Judged.of(known, trial, fold.tested[trial.scene.object], made) for trial in tests]


def _acceptance(chosen: ObjectSet, judged: list[_Judged], design: Design) -> dict[str, Any]:
    """What is proved and what is accepted, of scenes of known and of unknown objects."""
    known, unknown = (
        sorted((each for each in judged if each.known == kind), key=lambda each: each.scene.name)
        for kind in (True, False)
    )

    def shares(of: list[_Judged], **columns: list[bool]) -> dict[str, Any]:
        values = np.array(list(columns.values()), dtype=np.float64).T
        told = figures(values, [each.scene for each in of], design)
        return {
            name.replace("_", " "): {"scenes": sum(column), "share": figure}
            for (name, column), figure in zip(columns.items(), told, strict=True)
        }

    rows = []
    for k, coverage in enumerate(COVERAGES):
        wrong = [each.kinds[k] is Acceptance.RECOGNISED and not each.alone[k] for each in known]
        rows.append({
            "coverage": coverage,
            "known": shares(
                known,
                covered=[each.covered[k] for each in known],
                recognised_and_right=[each.alone[k] for each in known],
                recognised_and_wrong=wrong,
                ambiguous=[each.kinds[k] is Acceptance.AMBIGUOUS for each in known],
                refused=[each.kinds[k] is Acceptance.UNKNOWN for each in known],
            ),
            "unknown": shares(
                unknown,
                refused=[each.kinds[k] is Acceptance.UNKNOWN for each in unknown],
                ambiguous=[each.kinds[k] is Acceptance.AMBIGUOUS for each in unknown],
                recognised=[each.kinds[k] is Acceptance.RECOGNISED for each in unknown],
            ),
        })  # fmt: skip
    objects = [[each.scene.object for each in of] for of in (unknown, known)]
    return {
        "objects": chosen.name,
        "condition": COVERED,
        "known scenes": len(known),
        "unknown scenes": len(unknown),
        "calibration scenes": min(each.calibrated for each in judged),
        "before": {
            "known": shares(
                known,
                proved_and_right=[each.proved and each.right for each in known],
                proved_and_wrong=[each.proved and not each.right for each in known],
            ),
            "unknown": shares(unknown, proved=[each.proved for each in unknown]),
        },
        "after": rows,
        "auc of unknown against known": {
            name: separation(
                [getattr(each, name) for each in unknown], [getattr(each, name) for each in known],
                objects[0], objects[1], design,
            )
            for name in ("share", "distance")
        },
    }  # fmt: skip
