"""Rules of the experiments: what is resampled, and what an interval says of a part."""

from collections.abc import Sequence
from itertools import product

import numpy as np
import pytest
from numpy.typing import NDArray

from verification.experiments.design import Design
from verification.experiments.record import bootstrap
from verification.experiments.record.bootstrap import Intervals, intervals, resamples, standard_error
from verification.experiments.record.verdicts import Comparisons, judge
from verification.experiments.scenes.pictures import Scene, View
from verification.ledger.claims import PROTOCOL
from verification.ledger.rules import NO_FACTOR, Bounds, Rule
from verification.ledger.surveys import Spread, SurveyOutcome, Tally

DESIGN = Design(seed=0, repetitions=4, resamples=4000)
Floats = NDArray[np.float64]


def scenes(objects: int, each: int, levels: int = 1) -> list[Scene]:
    """Scenes that share no photograph, object by object, level by level."""
    chosen = product(range(objects), range(levels), range(each))
    return [
        Scene(f"{k}-{level}-{number}", f"object {k}", f"level {level}", (View("robot", 1.0),))
        for k, level, number in chosen
    ]


def photographed(
    photographs: int, count: int, views: int = 6, objects: int = 1, seed: int = 0
) -> list[Scene]:
    """Scenes that are each made of some photographs of their object."""
    rng = np.random.default_rng(seed)
    return [
        Scene(
            f"{k}-{number}",
            f"object {k}",
            "none",
            tuple(
                View(f"robot-{v}", 1.0, photograph=f"{k}/{each}")
                for v, each in enumerate(rng.choice(photographs, views, replace=False))
            ),
        )
        for k in range(objects)
        for number in range(count)
    ]


def spread(values: Floats, given: Sequence[Scene]) -> float:
    """Standard deviation of the resampled means."""
    weights = resamples(tuple(given), DESIGN.resamples, DESIGN.seed)
    return float((weights @ values / weights.sum(axis=1)).std())


# ---------- what is resampled


def coverage(given: Sequence[Scene], between: float, within: float) -> float:
    """How often an interval contains the mean that objects and scenes are drawn around."""
    rng = np.random.default_rng(1)
    objects = np.unique([scene.object for scene in given], return_inverse=True)[1]
    effects = between * rng.standard_normal((objects.max() + 1, 400))
    samples = effects[objects] + within * rng.standard_normal((len(given), 400))
    found = intervals(samples, given, DESIGN)
    return float(((found.lower <= 0.0) & (found.upper >= 0.0)).mean())


def test_intervals_cover_at_their_rate_where_objects_differ() -> None:
    given = scenes(objects=30, each=4)
    assert 0.90 <= coverage(given, between=1.0, within=1.0) <= 0.98
    apart = [Scene(each.name, each.name, each.level, each.views) for each in given]
    wrong = intervals(np.repeat(np.arange(30.0) % 2, 4)[:, None], apart, DESIGN)
    right = intervals(np.repeat(np.arange(30.0) % 2, 4)[:, None], given, DESIGN)
    ratio = (right.upper - right.lower) / (wrong.upper - wrong.lower)
    assert ratio == pytest.approx(2.0, abs=0.25), "four scenes of one object are no four objects"


@pytest.mark.parametrize(
    ("objects", "within", "percentiles"),
    [(3, 1.0, (0.7, 0.8)), (8, 1.0, (0.85, 0.92)), (8, 20.0, (0.985, 1.0))],
)
def test_intervals_of_few_objects_cover_at_their_rate(
    objects: int, within: float, percentiles: tuple[float, float], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Percentiles alone are too close where objects differ, and too far apart where scenes do."""
    given = scenes(objects, each=30)
    assert 0.925 <= coverage(given, between=1.0, within=within) <= 0.985
    monkeypatch.setattr(bootstrap.Resampled, "intervals", percentiles_alone)
    least, most = percentiles
    assert least <= coverage(given, between=1.0, within=within) <= most


def percentiles_alone(found: bootstrap.Resampled, count: int) -> Intervals:
    lower, upper = np.quantile(found.means, [0.025 / count, 1.0 - 0.025 / count], axis=0)
    return Intervals(found.mean, lower, upper)


@pytest.mark.parametrize(("objects", "each", "chance"), [(3, 8, 0.1), (8, 30, 0.01), (8, 30, 0.99)])
def test_intervals_of_rare_scores_cover_at_their_rate(objects: int, each: int, chance: float) -> None:
    """Where hardly a scene differs, none may have been seen by chance."""
    given = scenes(objects, each)
    samples = (np.random.default_rng(1).random((len(given), 400)) < chance).astype(float)
    covered = {}
    for scored in (True, False):
        found = intervals(samples, given, DESIGN, scored=scored)
        covered[scored] = float(((found.lower <= chance) & (found.upper >= chance)).mean())
    assert covered[True] >= 0.95
    assert covered[False] < covered[True]


def test_scores_that_never_differ_decide_nothing_where_scenes_are_few() -> None:
    def of(value: float, objects: int, each: int, scored: bool = True) -> str:
        given = scenes(objects, each)
        claim = Comparisons({"a": np.full(len(given), value)}, given, scored=scored)
        return judge(claim, rule(), DESIGN).outcome

    assert of(0.0, 8, 30) == "open", "240 scenes do not exclude a difference of one in a hundred"
    assert of(0.0, 8, 60) == "no effect"
    assert of(0.0, 8, 30, scored=False) == "no effect", "a weight that is 0 in every scene is no chance"
    assert of(-0.1, 3, 8) == "open", "none of 24 scenes, where one in ten would be chance"
    assert of(-0.1, 8, 30) == "opposite"
    assert of(0.9, 3, 8) == "reproduced"


def test_the_standard_error_is_that_of_the_means_of_the_objects() -> None:
    values = np.random.default_rng(6).standard_normal((40, 3)) + np.repeat(np.arange(8.0), 5)[:, None]
    by_object = values.reshape(8, 5, 3).mean(axis=1)
    found = standard_error(values, scenes(8, 5))
    assert found == pytest.approx(by_object.std(axis=0, ddof=1) / np.sqrt(8))
    alike = values - np.repeat(by_object, 5, axis=0)
    wanted = np.sqrt(alike.reshape(8, 5, 3).var(axis=1, ddof=1).sum(axis=0) / 5) / 8
    assert standard_error(alike, scenes(8, 5)) == pytest.approx(wanted), "objects alike by chance"


def test_one_object_has_no_interval() -> None:
    with pytest.raises(ValueError, match="1 objects: an interval needs at least two"):
        intervals(np.zeros((5, 1)), scenes(1, 5), DESIGN)
    found = judge(Comparisons({"a": np.ones(5)}, scenes(1, 5), left_out=2), rule(), DESIGN)
    assert (found.outcome, found.statistic, found.units, found.left_out) == ("open", None, 5, 2)


def test_scenes_as_the_unit_would_cover_too_rarely(monkeypatch: pytest.MonkeyPatch) -> None:
    """The fault that the tests above are there to catch."""
    monkeypatch.setattr(bootstrap, "objects", lambda given: {str(k): [k] for k in range(len(given))})
    resamples.cache_clear()
    try:
        assert coverage(scenes(objects=30, each=4), between=1.0, within=0.2) < 0.75
    finally:
        resamples.cache_clear()


def test_levels_of_obstruction_keep_their_shares() -> None:
    given = scenes(objects=1, each=5, levels=4)
    by_level = np.array([float(scene.level[-1]) for scene in given])
    assert spread(by_level, given) == 0.0, "each level is resampled for itself"
    mixed = [Scene(each.name, each.object, "any", each.views) for each in given]
    assert spread(by_level, mixed) == pytest.approx(by_level.std() / np.sqrt(20), rel=0.1)


def test_photographs_are_resampled_where_scenes_share_them() -> None:
    given = photographed(photographs=15, count=60)
    worth = np.random.default_rng(5).standard_normal(15)
    used = [[int(str(view.photograph).split("/")[1]) for view in scene.views] for scene in given]
    values = np.array([worth[each].mean() for each in used])
    found = spread(values, given)
    assert found == pytest.approx(worth.std() / np.sqrt(15), rel=0.2), "as a mean over 15 photographs moves"
    apart = [Scene(each.name, each.object, each.level, (View("robot", 1.0),)) for each in given]
    assert spread(values, apart) < 0.45 * found, "60 scenes of 15 photographs are no 60 scenes"


def test_what_every_scene_shares_does_not_move() -> None:
    for given in (scenes(8, 6, 5), photographed(15, 30, objects=8)):
        assert spread(np.full(len(given), 0.7), given) == pytest.approx(0.0, abs=1e-12)
        found = intervals(np.full((len(given), 1), 0.7), given, DESIGN)
        assert np.array(found) == pytest.approx(0.7)


def test_scenes_that_are_left_out_leave_the_rest_a_positive_weight() -> None:
    given = scenes(3, 1)[:1] + scenes(3, 4)[8:]
    weights = resamples(tuple(given), 1000, 0)
    assert weights.shape == (1000, 5)
    assert (weights.sum(axis=1) > 0.0).all()
    assert (resamples(tuple(given), 1000, 0) == weights).all()
    assert not (resamples(tuple(given), 1000, 1) == weights).all()


def test_joint_intervals_contain_those_by_themselves() -> None:
    given = scenes(20, 3)
    values = np.random.default_rng(3).standard_normal((60, 10))
    each, joint = (intervals(values, given, DESIGN, count) for count in (1, 10))
    assert (joint.lower < each.lower).all()
    assert (joint.upper > each.upper).all()


# ---------- what one configuration says


def rule(comparisons: int = 1, smallest: float = 0.01) -> Rule:
    return Rule("all scenes", "a mean", comparisons, smallest)


def paired(gain: float, noise: float, seed: int = 2) -> Comparisons:
    """Differences of two settings on the same 240 scenes of 40 objects, six numbers of views."""
    rng = np.random.default_rng(seed)
    values = gain + noise * rng.standard_normal((240, 6))
    return Comparisons({f"n = {k + 1}": column for k, column in enumerate(values.T)}, scenes(40, 6))


def test_the_four_outcomes_of_a_part() -> None:
    assert judge(paired(0.05, 0.1), rule(6), DESIGN).outcome == "reproduced"
    assert judge(paired(-0.05, 0.1), rule(6), DESIGN).outcome == "opposite"
    assert judge(paired(0.0, 0.01), rule(6), DESIGN).outcome == "no effect"
    assert judge(paired(0.01, 0.3), rule(6), DESIGN).outcome == "open"
    assert judge(paired(0.005, 0.01), rule(6), DESIGN).outcome == "reproduced", "a small gain is a gain"


def test_a_tie_is_no_effect_and_never_the_opposite() -> None:
    tied = Comparisons({"a": np.zeros(50)}, scenes(10, 5))
    found = judge(tied, rule(), DESIGN)
    assert (found.outcome, found.lower, found.upper, found.above) == ("no effect", 0.0, 0.0, 0)
    assert judge(tied, rule(smallest=0.0), DESIGN).outcome == "open", (
        "without a smallest effect nothing is told"
    )


def test_a_bound_is_compared_as_it_is_not_rounded_to_a_few_decimals() -> None:
    def of(value: float) -> str:
        return judge(Comparisons({"a": np.full(50, value)}, scenes(10, 5)), rule(), DESIGN).outcome

    assert of(1e-8) == "reproduced"
    assert of(-1e-8) == "opposite"
    assert of(0.3 - 0.1 - 0.2) == "no effect", "a float's rounding is no difference"


def test_the_comparison_that_decides_is_told() -> None:
    values = {"good": np.full(50, 0.2), "small": np.full(50, 0.01), "bad": np.full(50, -0.1)}
    values["flat"] = np.zeros(50)
    found = judge(Comparisons(values, scenes(10, 5)), rule(4), DESIGN)
    assert (found.outcome, found.name, found.units, found.above) == ("opposite", "bad", 50, 2)
    del values["bad"]
    with pytest.raises(ValueError, match="the ledger fixes 4"):
        judge(Comparisons(values, scenes(10, 5)), rule(4), DESIGN)
    with pytest.raises(ValueError, match="50 units of 20 scenes"):
        judge(Comparisons(values, scenes(10, 2)), rule(3), DESIGN)
    found = judge(Comparisons(values, scenes(10, 5)), rule(3), DESIGN)
    assert (found.outcome, found.name) == ("no effect", "flat")
    del values["flat"]
    found = judge(Comparisons(values, scenes(10, 5), left_out=3), rule(2), DESIGN)
    assert (found.outcome, found.name, found.left_out) == ("reproduced", "small", 3)
    nothing = judge(Comparisons({"none": np.zeros(0)}, [], left_out=9), rule(), DESIGN)
    assert (nothing.outcome, nothing.statistic, nothing.units) == ("open", None, 0)


def test_a_conjunction_needs_no_correction_and_its_failure_does() -> None:
    """An intersection-union test; the opposite of some comparison is a union, which Bonferroni corrects."""
    each, joint = Bounds([0.01, 0.02], [0.3, 0.3]), Bounds([-0.02, -0.01], [0.4, 0.4])
    assert rule(2).decide(each, joint) == (0, Bounds([0.01], [0.3]))
    each, joint = Bounds([-0.3, -0.3], [-0.01, 0.2]), Bounds([-0.4, -0.4], [0.01, 0.3])
    k, ((lower,), (upper,)) = rule(2).decide(each, joint)
    assert (k, rule(2).outcome(lower, upper)) == (0, "open"), "below 0 by itself alone is not enough"
    joint = Bounds([-0.4, -0.4], [-0.001, 0.3])
    assert rule(2).decide(each, joint) == (0, Bounds([-0.4], [-0.001]))


@pytest.mark.parametrize(
    ("lower", "upper", "outcome"),
    [
        (0.001, 0.009, "reproduced"),
        (0.0, 0.02, "open"),
        (-0.01, 0.01, "no effect"),
        (-0.011, 0.01, "open"),
        (-0.01, 0.011, "open"),
        (-0.02, 0.0, "open"),
        (-0.02, -0.001, "opposite"),
    ],
)
def test_what_an_interval_says(lower: float, upper: float, outcome: str) -> None:
    assert rule().outcome(lower, upper) == outcome
    mirrored = {"reproduced": "opposite", "opposite": "reproduced"}.get(outcome, outcome)
    assert rule().outcome(-upper, -lower) == mirrored, "the rule favours no side"


# ---------- what all configurations say


@pytest.mark.parametrize(
    ("counts", "wanted"),
    [
        ((122, 6, 0, 0), "reproduced"),
        ((121, 7, 0, 0), "depends on"),
        ((121, 0, 0, 7), "reproduced where decided"),
        ((7, 3, 3, 115), "reproduced where decided"),
        ((7, 3, 4, 114), "depends on"),
        ((0, 0, 122, 6), "opposite found"),
        ((0, 0, 121, 7), "not reproduced"),
        ((6, 0, 121, 1), "not reproduced"),
        ((7, 0, 121, 0), "depends on"),
        ((0, 128, 0, 0), "not reproduced"),
        ((0, 6, 0, 122), "inconclusive"),
        ((6, 32, 32, 58), "inconclusive"),
        ((6, 32, 33, 57), "not reproduced"),
        ((7, 0, 0, 121), "reproduced where decided"),
        ((0, 0, 0, 0), "not testable here"),
        ((64, 0, 64, 0), "depends on"),
    ],
)
def test_the_rule_over_the_configurations(counts: tuple[int, int, int, int], wanted: str) -> None:
    assert PROTOCOL.verdict(Tally(*counts)) == wanted
    of_figure = "not reproduced" if wanted == "opposite found" else wanted
    assert PROTOCOL.verdict(Tally(*counts), figure=True) == of_figure, (
        "a figure that is missed has no opposite"
    )


def test_the_factor_that_decides_is_named() -> None:
    def level(reproduced: int, total: int = 32) -> Tally:
        return Tally(reproduced, 0, total - reproduced, 0)

    levels = {
        "hog": {"8": level(32, 64), "16": level(40, 64)},
        "normalisation": {"one": level(31), "two": level(30), "three": level(11), "untried": level(0, 0)},
    }
    found = Spread.widest(levels)
    assert found is not None
    assert (found.factor, found.most, found.least, found.size) == ("normalisation", "one", "three", 20 / 32)
    told = PROTOCOL.deciding_factor(levels)
    assert told == "the normalisation: reproduced in 31 of 32 with one; reproduced in 11 of 32 with three"
    assert PROTOCOL.deciding_factor({"hog": levels["hog"]}) == NO_FACTOR
    assert PROTOCOL.deciding_factor({}) == NO_FACTOR
    assert Spread.widest({"hog": {"8": level(3, 8)}}) is None


def test_the_words_of_a_tally() -> None:
    assert Tally.of([SurveyOutcome.OPEN, SurveyOutcome.REPRODUCED, SurveyOutcome.OPEN]) == (1, 0, 0, 2)
    assert Tally(1, 0, 0, 2).told == "of 3 configurations: reproduced in 1, open in 2"
