"""Calibrated acceptance: thresholds by hand, coverage by simulation, and what does not fit."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from convexperc import TemplateLibrary, recognize
from convexperc.errors import CalibrationError, DecisionError
from convexperc.recognition.calibration import Acceptance, Calibration, fewest_scenes, scores

LAMBDAS = {"lambda1": 0.1, "lambda2": 0.1, "lambda3": 0.1}
SIZES = [6, 6]
OBJECTS = np.random.default_rng(5).random((12, 6))
"""The true look of six objects; the last one is not in the library."""
LIBRARY = TemplateLibrary(OBJECTS[:, :5], names=list("abcde"), modalities=SIZES)


def scene(rng: np.random.Generator, truth: int, noise: float = 0.25):
    """Four noisy views of an object."""
    X = np.abs(OBJECTS[:, truth] + noise * rng.standard_normal((4, 12)))
    return recognize(X, LIBRARY, prune=False, escalate=False, **LAMBDAS)


def labelled(seed: int, count: int):
    rng = np.random.default_rng(seed)
    truths = rng.integers(0, 5, count).tolist()
    return [(scene(rng, truth), "abcde"[truth]) for truth in truths]


def test_the_scores_are_what_their_definitions_say():
    found = scene(np.random.default_rng(0), 2)
    optima, squares = found.answers.upper, (OBJECTS[:, :5] ** 2).sum(axis=0)
    every = scores(found)
    assert list(every) == ["abcde"[j] for j in np.argsort(optima)]
    for j, name in enumerate("abcde"):
        excess, share = optima[j] / optima.min() - 1.0, optima[j] / squares[j]
        for (lower, upper), true in ((every[name].excess, excess), (every[name].share, share)):
            assert lower <= true * (1 + 1e-9) + 1e-9
            assert upper >= true * (1 - 1e-9)
            assert upper - lower <= 1e-8


def test_the_thresholds_are_order_statistics_and_none_where_there_are_too_few_scenes():
    given = labelled(1, 19)
    excess, share = (
        sorted(getattr(scores(found)[truth], name)[1] for found, truth in given)
        for name in ("excess", "share")
    )
    made = Calibration.of(given, 0.8)
    assert (made.excess, made.share, made.scenes) == (excess[17], share[17], 19)  # ceil(20 * 0.9) = 18
    assert Calibration.of(given, 0.9).excess == excess[18]
    few = Calibration.of(given, 0.95)
    assert (few.excess, few.share) == (math.inf, math.inf)
    assert few.judge(given[0][0]).acceptance is Acceptance.AMBIGUOUS


def test_the_true_object_is_accepted_as_often_as_is_promised_and_an_unknown_one_is_refused():
    rng, coverage, hits, sizes = np.random.default_rng(2), 0.8, [], []
    for seed in range(6):
        made = Calibration.of(labelled(10 + seed, 40), coverage)
        for found, truth in labelled(100 + seed, 40):
            accepted = made.judge(found).accepted
            hits.append(truth in accepted)
            sizes.append(len(accepted))
    assert np.mean(hits) >= coverage - 3 * math.sqrt(coverage * (1 - coverage) / 240), np.mean(hits)
    assert np.mean(sizes) < 1.5, np.mean(sizes)
    unknown = [made.judge(scene(rng, 5)).acceptance for _ in range(40)]
    assert unknown.count(Acceptance.UNKNOWN) >= 20, unknown


def test_every_verdict_and_its_reason():
    given = labelled(3, 30)
    made = Calibration.of(given, 0.8)
    kinds = {made.judge(found).acceptance for found, _ in given}
    assert Acceptance.RECOGNISED in kinds
    strict = replace(made, excess=0.0, share=0.0)
    refused = strict.judge(given[0][0])
    assert (refused.acceptance, refused.accepted) == (Acceptance.UNKNOWN, ())
    assert "of the best template unexplained" in refused.reason
    loose = replace(made, excess=math.inf, share=math.inf).judge(given[0][0])
    assert "too few scenes to refuse any" in loose.reason
    assert set(loose.accepted) == set("abcde")
    assert loose.accepted[0] == given[0][0].label


def test_another_library_or_number_of_views_is_no_silent_matter():
    made = Calibration.of(labelled(1, 19))
    X = OBJECTS[:, :3].T.copy()
    assert made.views == (4, 4)
    fewer = made.judge(recognize(X, LIBRARY, prune=False, **LAMBDAS))
    assert fewer.reason.endswith("; calibrated with 4 views, these are 3")
    for other in (
        TemplateLibrary(OBJECTS[:, :5], names=list("abcdx"), modalities=SIZES),
        TemplateLibrary(OBJECTS[:, :5] * 2.0, names=list("abcde"), modalities=SIZES),
        TemplateLibrary(OBJECTS[:, :5], names=list("abcde"), modalities=[5, 7]),
        TemplateLibrary(OBJECTS[:, :5], names=list("abcde"), objects=list("aacde"), modalities=SIZES),
    ):
        found = recognize(X, other, prune=False, **LAMBDAS)
        with pytest.raises(CalibrationError, match="as the calibration was"):
            made.judge(found)
        with pytest.raises(CalibrationError, match="as the first one"):
            Calibration.of([*labelled(1, 2), (found, "a")])
    for order in ([0, 1, 2, 3, 4], [3, 1, 4, 2, 0]):
        names = ["abcde"[j] for j in order]
        same = TemplateLibrary(OBJECTS[:, order], names=names, modalities=SIZES)
        again = made.judge(recognize(X, same, prune=False, **LAMBDAS))
        assert set(again.accepted) == set(fewer.accepted)


@pytest.mark.parametrize("coverage", [0.5, 0.8, 0.9, 0.95, 0.99])
def test_as_few_scenes_as_said_set_thresholds(coverage):
    count = fewest_scenes(coverage)
    assert count == round(2.0 / (1.0 - coverage)) - 1
    found = labelled(1, 1) * count
    assert Calibration.of(found, coverage).share < math.inf
    assert Calibration.of(found[1:], coverage).share == math.inf if count > 1 else True


@pytest.mark.parametrize("digits", [6, 9, 12, 15])
def test_how_many_scenes_a_high_coverage_takes_is_known_at_once(digits):
    wanted = 2 * 10**digits - 1
    assert fewest_scenes(1.0 - 10.0**-digits) == pytest.approx(wanted, rel=10.0 ** (digits - 15))
    assert fewest_scenes(math.nextafter(1.0, 0.0)) > 10**15


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("excess", 10**400), ("share", -1.0), ("share", math.inf), ("lambdas", [0.1, 0.1, 10**400]),
        ("lambdas", [0.1, 0.1, math.inf]),
        ("library", 3), ("views", [4]), ("views", [0, 4]), ("views", [True, 4]), ("origin", "dream"),
    ],
)  # fmt: skip
def test_a_record_that_holds_something_else_is_refused(name, value):
    record = Calibration.of(labelled(1, 3)).to_dict()
    with pytest.raises(CalibrationError):
        Calibration.from_dict({**record, name: value})


@pytest.mark.parametrize("coverage", [0.8, 0.95])
def test_a_calibration_is_kept_as_json(coverage):
    made = Calibration.of(labelled(1, 19), coverage)
    assert Calibration.from_dict(json.loads(json.dumps(made.to_dict()))) == made


def test_what_does_not_fit_is_refused():
    given = labelled(4, 3)
    for coverage in (0.0, 1.0, 90, True, "0.9", math.nan):
        with pytest.raises(CalibrationError, match="coverage"):
            Calibration.of(given, coverage)
    with pytest.raises(CalibrationError, match="at least one"):
        Calibration.of([])
    with pytest.raises(CalibrationError, match="one of the known objects"):
        Calibration.of([(given[0][0], "f")])
    made, X = Calibration.of(given), np.ones((2, 12))
    other = recognize(X, LIBRARY, lambda1=1.0, lambda2=0.1, lambda3=0.1)
    with pytest.raises(CalibrationError, match="as the first one"):
        Calibration.of([*given, (other, "a")])
    with pytest.raises(CalibrationError, match="as the calibration was"):
        made.judge(other)
    with pytest.raises(CalibrationError, match="as the calibration was"):
        made.judge(recognize(X, LIBRARY, decision="explained fraction", **LAMBDAS))


@pytest.mark.parametrize(
    "change",
    [
        {"schema": "x"}, {"scenes": 0}, {"scenes": True}, {"coverage": 1.0}, {"coverage": None},
        {"excess": -1.0}, {"share": "0.1"}, {"lambdas": [1.0, 2.0]}, {"lambdas": [1.0, 2.0, -3.0]},
        {"lambdas": None}, {"more": 1},
    ],
)  # fmt: skip
def test_a_record_that_is_no_calibration_is_refused(change):
    record = Calibration.of(labelled(1, 19), 0.8).to_dict() | change
    with pytest.raises(CalibrationError):
        Calibration.from_dict(record)
    with pytest.raises(CalibrationError):
        Calibration.from_dict({key: record[key] for key in list(record)[1:]})


def test_a_record_with_another_decision_is_refused():
    with pytest.raises(DecisionError):
        Calibration.from_dict(Calibration.of(labelled(1, 19), 0.8).to_dict() | {"decision": "dice"})
