"""Every interval is over objects and scenes; every number stands under the name of what it is a number of.

The trials are replaced by ones whose outcome is known, so that no table can show another row than it says.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
import pytest
from made_up_pictures import measured, picture_set
from numpy.typing import NDArray
from scipy.stats import binom, norm, t

from verification.experiments.design import (
    BOTH,
    FEATURES_ALONE,
    GRID,
    NOTHING,
    SETTINGS,
    VIEWS_ALONE,
    Design,
    Pair,
)
from verification.experiments.measure import trials
from verification.experiments.measure.baselines import BASELINES
from verification.experiments.measure.configurations import FACTORS, fraction
from verification.experiments.measure.measured import Measured
from verification.experiments.measure.subsets import Subset
from verification.experiments.measure.trials import (
    KINDS,
    RIGHT,
    TIE,
    UNDECIDED,
    WRONG,
    Known,
    TrialOutcome,
    Tried,
    run_explained,
    run_trials,
)
from verification.experiments.record.bootstrap import intervals
from verification.experiments.record.claims import CLAIMS, PEAK
from verification.experiments.record.detail import detail
from verification.experiments.record.judged import recorded
from verification.experiments.record.limits import limits, summary
from verification.experiments.record.sensitivity import level_name, survey
from verification.experiments.record.verdicts import judge, rule_of
from verification.experiments.scenes.pictures import Layout, Scene

DESIGN = Design(seed=3, repetitions=20)
OBJECTS = ("red", "green", "blue")
KNOWN = Known(OBJECTS, np.diag([1.0, 2.0, 3.0]), {"color": 1, "hog": 1, "lbp": 1}, 0.1)


# ---------- the unit of the bootstrap


def repeated(by_scene: NDArray[np.bool_], shape: tuple[int, int], chosen: Sequence[tuple[int, int]]) -> Tried:
    """Every repetition of a scene has the same outcome; 0 but in the chosen cells."""
    scores = np.zeros((len(by_scene), *shape, DESIGN.repetitions))
    for i, j in chosen:
        scores[:, i, j] = by_scene[:, None]
    return Tried(np.zeros(scores.shape, dtype=np.int64), scores, np.zeros(scores.shape, dtype=np.int64))


def width(count: int, units: int, comparisons: int) -> float:
    """Of the interval for a mean of 0s and 1s: resampled sums are binomial, and few units widen it."""
    tail = 0.05 / (2 * comparisons)
    low, high = binom.ppf([tail, 1.0 - tail], units, count / units)
    widened = np.sqrt(units / (units - 1)) * t.ppf(tail, units - 1) / norm.ppf(tail)
    return float(widened * (high - low) / units)


RIGHT_SCENES = np.arange(15) < 10
"""All scenes of two of the three objects."""


BETTER = {"X2/stated": (VIEWS_ALONE, FEATURES_ALONE, BOTH), "X3/stated": (BOTH,), "X4/stated": (VIEWS_ALONE,)}
"""Settings in which the right scenes are recognised; the gain is then the same in every comparison."""


@pytest.mark.parametrize("part", [*BETTER, "X8/zero", "X8/ten", "X8/peak"])
def test_trials_and_scenes_of_one_object_move_together_in_the_interval_of_a_claim(part: str) -> None:
    better = [(SETTINGS.index(pair), n) for pair in BETTER.get(part, ()) for n in range(6)]
    peak = [(GRID.index(a), GRID.index(b)) for a, b in PEAK]
    given = measured(repeated(RIGHT_SCENES, (4, 6), better), repeated(RIGHT_SCENES, (5, 5), peak), DESIGN)
    found = judge(CLAIMS[part](given), rule_of(part), DESIGN)
    assert found.statistic == pytest.approx(2 / 3)
    assert found.units == 15, "a trial was taken for a scene"
    wanted = width(2, 3, rule_of(part).comparisons)
    assert found.upper - found.lower == pytest.approx(wanted, rel=0.02), "an interval of the wrong width"
    for trials_or_scenes in (15, 300):
        other = width(trials_or_scenes * 2 // 3, trials_or_scenes, rule_of(part).comparisons)
        assert wanted > 1.2 * other, "else the test could not tell them apart"


def test_trials_and_scenes_of_one_object_move_together_in_the_intervals_that_are_shown() -> None:
    everywhere = repeated(RIGHT_SCENES, (4, 6), list(product(range(4), range(6))))
    given = measured(everywhere, repeated(RIGHT_SCENES, (5, 5), []), DESIGN, explained=everywhere)
    baselines = np.tile(everywhere.scores[:, :1], (1, len(BASELINES), 1, 1))
    shown = detail(replace(given, baselines=baselines))
    cells = [cell for name in ("accuracy", "explained") for row in shown[name] for cell in row]
    cells += [cell for row in shown["baselines"].values() for cell in row]
    assert len(cells) == 2 * 24 + 3 * 6
    for cell in cells:
        assert cell["score"] == pytest.approx(2 / 3)
        assert (cell["lower"], cell["upper"]) == (0.0, 1.0), "two right of three objects say little"
    scores = np.linspace(0.4, 0.6, 15)
    mean, lower, upper = np.ravel(intervals(scores[:, None], given.layout.scenes, DESIGN))
    assert 0.0 < lower < mean < upper < 1.0
    shown = detail(replace(given, baselines=np.broadcast_to(scores[:, None, None, None], baselines.shape)))
    for row in shown["baselines"].values():
        for cell in row:
            assert [cell[key] for key in ("score", "lower", "upper")] == pytest.approx([mean, lower, upper])


# ---------- names of rows and columns


def score(pair: Pair, n: int, scene: Scene, explained: bool = False) -> float:
    """What a trial scores here: different for every setting, number of views, object, level and decision."""
    by_scene = 0.001 * OBJECTS.index(scene.object) + 0.004 * len(scene.level)
    return 0.2 + 0.03 * pair[0] + 0.007 * pair[1] + 0.01 * n + by_scene + 0.0003 * explained


CODE = {"right": RIGHT, "wrong": WRONG, "tie": TIE, "undecided": UNDECIDED}
KIND = {NOTHING: "wrong", VIEWS_ALONE: "tie", FEATURES_ALONE: "right", BOTH: "undecided"}


@pytest.fixture
def layout(monkeypatch: pytest.MonkeyPatch) -> Layout:
    """Scenes whose trials have the outcome that `score` and `KIND` say; views carry the scene's number."""
    found = picture_set(OBJECTS, levels=True).layout

    def known_outcomes(
        views: NDArray[np.float64],
        known: Known,
        truth: int,
        wanted: Mapping[Subset, Sequence[Pair]],
        decision: Any,
    ) -> dict[tuple[Subset, Pair], TrialOutcome]:
        scene = found.scenes[int(views[0, 0])]
        assert found.truth(scene) == truth
        explained = decision is trials.Decision.EXPLAINED_FRACTION
        return {
            (subset, pair): TrialOutcome(
                CODE[KIND.get(pair, "right")],
                score(pair, len(subset), scene, explained),
                -1 if KIND.get(pair) in ("tie", "undecided") else (truth + 1) % 3,
            )
            for subset, pairs in wanted.items()
            for pair in pairs
        }

    monkeypatch.setattr(trials, "_outcomes", known_outcomes)
    return found


@pytest.fixture
def tried(layout: Layout) -> Measured:
    X = np.zeros((len(OBJECTS) + 6 * len(layout.scenes), 3))
    for number, (_, rows) in enumerate(layout.rows()):
        X[rows, 0] = number
    done = run_trials(layout, X, KNOWN, DESIGN)
    explained = run_explained(layout, X, KNOWN, DESIGN)
    return measured(done.settings, done.grid, DESIGN, explained=explained)


def mean(scenes: Sequence[Scene], pair: Pair, n: int, explained: bool = False) -> float:
    return float(np.mean([score(pair, n, scene, explained) for scene in scenes]))


def test_numbers_by_setting_and_views_are_those_of_their_lambdas(tried: Measured) -> None:
    scenes, told = tried.layout.scenes, DESIGN.as_json()
    baselines = np.zeros((len(scenes), len(BASELINES), 6, DESIGN.repetitions))
    baselines += np.arange(3.0)[:, None, None] / 10 + np.arange(6.0)[:, None] / 100
    given = replace(tried, baselines=baselines)
    entry, shown = recorded(given, fraction()[0]), detail(given)
    for (s, setting), (k, n) in product(enumerate(told["settings"]), enumerate(told["counts"])):
        pair = tuple(setting)
        wanted = mean(scenes, pair, n)
        assert entry["accuracy"][s][k] == pytest.approx(wanted, rel=1e-5), (setting, n)
        assert shown["accuracy"][s][k]["score"] == pytest.approx(wanted, rel=1e-5), (setting, n)
        assert shown["explained"][s][k]["score"] == pytest.approx(mean(scenes, pair, n, True), rel=1e-5)
        counts = {name: shown["accuracy"][s][k][name] for name in KINDS}
        assert counts == dict.fromkeys(KINDS, 0) | {KIND[pair]: len(scenes) * DESIGN.repetitions}, setting
        assert entry["open"][s][k] == (KIND[pair] in ("tie", "undecided")), setting
    for (i, a), (j, b) in product(enumerate(told["grid"]), repeat=2):
        wanted = (mean(scenes, (a, b), 3) + mean(scenes, (a, b), 6)) / 2
        assert entry["grid"][i][j] == pytest.approx(wanted, rel=1e-5), (a, b)
        assert shown["grid"][i][j]["score"] == pytest.approx(wanted, rel=1e-5), (a, b)
    for (b, name), (k, _) in product(enumerate(BASELINES), enumerate(told["counts"])):
        assert entry["baselines"][name][k] == pytest.approx(b / 10 + k / 100), name
        assert shown["baselines"][name][k]["score"] == pytest.approx(b / 10 + k / 100), name
    for s, setting in enumerate(told["settings"]):
        for key, what in (("by_level", "level"), ("by_object", "object")):
            for name, row in shown[key].items():
                chosen = [scene for scene in scenes if getattr(scene, what) == name]
                assert row[s] == pytest.approx(mean(chosen, tuple(setting), 6), rel=1e-5), (setting, name)


def test_counts_of_failures_are_those_of_their_lambdas_and_objects(tried: Measured) -> None:
    found = limits(tried)
    assert found["explained"] == 0.5
    per_setting = len(tried.layout.scenes) * 6 * DESIGN.repetitions
    assert found["wrong"] == [per_setting * (KIND[pair] == "wrong") for pair in SETTINGS]
    assert found["shortest"] == [each // 3 for each in found["wrong"]], (
        "red is the shortest, the label of blue"
    )
    for (i, a), (j, b) in product(enumerate(GRID), repeat=2):
        assert found["grid open"][i][j] == (KIND.get((a, b)) in ("tie", "undecided")), (a, b)
    assert found["confusion"] == {"objects": list(OBJECTS), "counts": [[0] * 3] * 3, "open": [5, 5, 5]}
    labels = np.zeros((15, 4, 6, DESIGN.repetitions), dtype=np.int64)
    labels[:, SETTINGS.index(BOTH), 5, 0] = 2
    settings = replace(tried.trials.settings, labels=labels)
    labelled = replace(tried, trials=replace(tried.trials, settings=settings))
    assert limits(labelled)["confusion"]["counts"] == [[0, 0, 5]] * 3, "all views, both norms"


def test_comparisons_are_named_by_the_lambdas_and_views_that_they_compare(
    tried: Measured,
) -> None:
    given = tried
    scene = given.layout.scenes[0]

    def numbers(name: str) -> list[float]:
        return [float(each) for each in re.findall(r"[\d.]+", name)]

    for part in ("X2/stated", "X3/stated"):
        for name, gain in CLAIMS[part](given).differences.items():
            n, *pairs = numbers(name)
            high, low = (score((a, b), int(n), scene) for a, b in (pairs[:2], pairs[2:]))
            assert gain[0] == pytest.approx(high - low), name
    ((name, gain),) = CLAIMS["X4/stated"](given).differences.items()
    high, low = (np.mean([score(pair, n, scene) for n in range(2, 7)]) for pair in SETTINGS[1:3])
    assert numbers(name) == [0.1, 0.0, 0.0, 0.1]
    assert gain[0] == pytest.approx(high - low), name
    peak = max(np.mean([score(pair, n, scene) for n in (3, 6)]) for pair in PEAK)
    compared = []
    for part in ("X8/zero", "X8/ten", "X8/peak"):
        for name, gain in CLAIMS[part](given).differences.items():
            a, b = numbers(name)
            compared.append((a, b))
            assert gain[0] == pytest.approx(peak - np.mean([score((a, b), n, scene) for n in (3, 6)])), name
    assert sorted([*compared, *PEAK]) == list(product((0.0, 0.1, 1.0, 10.0), (0.0, 0.1, 10.0))), (
        "each cell once"
    )


def test_means_over_the_configurations_are_those_of_their_levels() -> None:
    tried = fraction()
    values = np.random.default_rng(4).random((len(tried), 4, 6)).round(3)
    entries = [
        {
            "levels": each.as_json(),
            "accuracy": v.tolist(),
            "open": (v / 2).tolist(),
            "grid": np.eye(5).tolist(),
        }
        for each, v in zip(tried, values, strict=True)
    ]
    counts = [{"explained": v[3][5] / 3, "visible": v[1][1], "shortest": [1, 2, 3, 4], "wrong": [5, 6, 7, 8],
               "grid open": np.zeros((5, 5)), "confusion": k} for k, v in enumerate(values)]  # fmt: skip
    found, both = summary(entries, counts), SETTINGS.index(BOTH)

    def by(factor: str, numbers: NDArray[np.float64]) -> dict[str, float]:
        return {
            level_name(level): float(
                np.mean([x for each, x in zip(tried, numbers, strict=True) if each[factor] == level])
            )
            for level in FACTORS[factor]
        }

    for factor in FACTORS:
        assert found["accuracy"][factor] == pytest.approx(by(factor, values[:, both].mean(axis=1)), rel=1e-5)
        assert found["open"][factor] == pytest.approx(by(factor, values[:, both].mean(axis=1) / 2), rel=1e-5)
    assert found["objective"] == pytest.approx(by("normalisation", values[:, both, 5]), rel=1e-5)
    assert found["explained"] == pytest.approx(by("normalisation", values[:, 3, 5] / 3), rel=1e-5)
    visible = by("lambda1", values[:, 1, 1]) | {"default": values[0, 1, 1]}
    assert found["visible"] == pytest.approx(visible, rel=1e-5)
    assert found["settings"] == pytest.approx(values.mean(axis=(0, 2)).tolist(), rel=1e-5)
    assert found["shortest"] == {
        level: {"wrong": 8 * 32, "shortest": 4 * 32} for level in FACTORS["normalisation"]
    }
    assert found["confusion"] == 0, "that of the default"


def test_outcomes_are_counted_by_the_level_that_they_were_found_with() -> None:
    tried = fraction()
    said = ["reproduced" if each["hog"] == "8-pixel cells" else "opposite" for each in tried]
    odds, there = [k % 4 == 0 for k in range(128)], [each["lambda1"] != 0.01 for each in tried]
    entries = [
        {
            "levels": each.as_json(),
            "claims": {
                "X2/stated": {
                    "outcome": outcome,
                    "above": 15 - odd,
                    "comparisons": 15,
                    "units": 240 * defined,
                }
            },
        }
        for each, outcome, odd, defined in zip(tried, said, odds, there, strict=True)
    ]
    found = survey(entries, "X2/stated", FACTORS)
    assert (found["counts"], found["undefined"], found["verdict"]) == ([24, 0, 24, 0], 16, "depends on")
    assert found["agreeing"] == sum(
        not odd and defined and each["background"] == "kept"
        for each, odd, defined in zip(tried, odds, there, strict=True)
    )
    assert found["factors"]["hog"] == {"16-pixel cells": [0, 0, 24, 0], "8-pixel cells": [24, 0, 0, 0]}
    by_lambda1 = {key: [8, 0, 8, 0] for key in ("0.1", "1", "10")} | {"0.01": [0, 0, 0, 0]}
    assert found["factors"]["lambda1"] == by_lambda1, "undefined is not open"
    assert found["factors"]["background"] == {"kept": [24, 0, 24, 0], "cut away": [24, 0, 24, 0]}, "beside it"
