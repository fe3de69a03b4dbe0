"""The comparison with simpler methods: who serves what, what is counted, and what the intervals hold."""

import importlib.util
from types import SimpleNamespace

import numpy as np
import pytest
from made_up_pictures import COLOURS, drawn

from convexperc import FeatureConfiguration
from convexperc.errors import InputError
from verification.accuracy import measure as measured
from verification.accuracy.methods import (
    METHODS,
    PAPER,
    Known,
    by_machine,
    mean_distances,
    name_by_all,
    nearest_margin,
)
from verification.accuracy.object_sets import Fold, category, groups, object_sets, unknown_sets
from verification.accuracy.scenes import (
    CLEAR,
    CONDITIONS,
    COVERED,
    INTRUDER,
    Described,
    Sizes,
    Split,
    Trial,
    compose,
    photograph,
)
from verification.accuracy.statistics import figures, quartiles, separation
from verification.experiments.design import Design
from verification.experiments.scenes.album import Album, Photo
from verification.experiments.scenes.pictures import Scene, View

SIZES = Sizes(seed=1, draws=1, scenes=2, references=2)
DESIGN = Design(0, 1, 500)
NEEDS_SKLEARN = pytest.mark.skipif(
    importlib.util.find_spec("sklearn") is None, reason="scikit-learn (extra `bench`) is not installed"
)


def album(name: str, colour: str, count: int = 14) -> Album:
    """Pictures of one object that differ by their noise."""
    rng = np.random.default_rng(list(name.encode()))
    photos = [Photo(f"{k:02d}", None, *drawn(colour, "none", rng)) for k in range(count)]
    return Album(name, photos[0], tuple(photos[1:]))


@pytest.fixture(scope="module")
def albums() -> list[Album]:
    return [album(colour, colour) for colour in COLOURS]


@pytest.fixture(scope="module")
def described(albums) -> Described:
    return Described.of(albums, FeatureConfiguration())


@pytest.fixture(scope="module")
def splits(albums) -> dict[str, Split]:
    return {each.object: Split.of(each, SIZES, 0) for each in albums}


@pytest.fixture(scope="module")
def own() -> Fold:
    names = {name: name for name in COLOURS}
    return Fold(names, names)


def names_of(photos) -> set[str]:
    return {photo.name for photo in photos}


def test_no_photograph_serves_two_ends(albums):
    first = [Split.of(albums[0], SIZES, draw) for draw in range(5)]
    for each in first:
        parts = [names_of(part) for part in (each.references, each.calibration, each.test)]
        assert [len(part) for part in parts] == [2, 6, 6]
        assert len(set.union(*parts)) == 14, "each serves once"
    assert len({frozenset(names_of(each.references)) for each in first}) > 1, "each draw divides anew"


def test_where_few_photographs_are_left_nothing_is_calibrated_and_where_fewer_are_nothing_is_drawn():
    few = Split.of(album("red", "red", 13), SIZES, 0)
    assert (len(few.calibration), len(few.test)) == (0, 11)
    with pytest.raises(InputError, match="photographs of red"):
        Split.of(album("red", "red", 7), SIZES, 0)


def test_scenes_of_all_conditions_are_of_the_same_photographs(splits, described):
    clear, covered, mixed = (
        compose(splits, described, each, SIZES, 0) for each in (CLEAR, COVERED, INTRUDER)
    )
    assert len(clear) == len(covered) == len(mixed) == len(COLOURS) * SIZES.scenes
    for one, two, three in zip(clear, covered, mixed, strict=True):
        assert one.scene.name == two.scene.name == three.scene.name
        assert len({view.photograph for view in one.scene.views}) == 6
        assert [v.photograph for v in one.scene.views] == [v.photograph for v in two.scene.views]
        kinds = [view.obstruction for view in two.scene.views]
        assert sorted(kinds) == ["full", "none", "none", "none", "none", "partial"]
        for k, kind in enumerate(kinds):
            assert (one.X[k] == two.X[k]).all() == (kind == "none"), "a covered view is described anew"
        foreign = [not str(v.photograph).startswith(f"{three.scene.object}/") for v in three.scene.views]
        assert foreign == [kind != "none" for kind in kinds], "the same views are changed"
        shown = [described.rows[str(view.photograph)] for view in three.scene.views]
        assert np.array_equal(three.X, shown)
        assert len({str(v.photograph).split("/")[0] for v in three.scene.views}) == 2, "of one other object"


def test_scenes_that_calibrate_and_scenes_that_test_share_no_photograph_with_each_other_or_references(
    splits, described
):
    seen = [
        {
            view.photograph
            for trial in compose(splits, described, each, SIZES, 0, calibration=kind)
            for view in trial.scene.views
        }
        for each in CONDITIONS
        for kind in (False, True)
    ]
    test, setting = set.union(*seen[::2]), set.union(*seen[1::2])
    known = {photograph(name, photo) for name, split in splits.items() for photo in split.references}
    assert test
    assert setting
    assert not test & setting
    assert not (test | setting) & known


def test_a_reference_in_view_is_refused(splits, described, own):
    known = Known.of(own, 2, splits, described, machine=False)
    (trial, *_) = compose(splits, described, CLEAR, SIZES, 0)
    known.recognise(trial, ((0.1, 1.0, 0.1),))
    reference = photograph("red", splits["red"].references[1])
    views = (*trial.scene.views[:5], View("robot-6", 1.0, photograph=reference))
    with pytest.raises(InputError, match=f"{reference}"):
        known.recognise(Trial(Scene("red, again", "red", CLEAR, views), trial.X), ((0.1, 1.0, 0.1),))


def test_groups_have_one_object_of_each_category():
    names = ["cup10", "cup2", "car1", "car14", "car3", "cup1"]
    assert groups(names) == [["cup1", "car1"], ["cup2", "car3"], ["cup10", "car14"]]
    assert groups(["cup1", "car"]) == [["cup1", "car"]], "one name without a number: no categories"
    assert groups(["cup1", "cup2"]) == [["cup1", "cup2"]], "one category is none"
    assert (category("cup10"), category("cup")) == ("cup", "cup")


def test_categories_are_recognised_by_other_objects_alone():
    names = [f"{kind}{k}" for kind in ("cup", "car") for k in (1, 2, 3)]
    sets = {each.name: each for each in object_sets(names, 5)}
    assert list(sets) == [
        "2 objects x 1 reference", "2 objects x 5 references",
        "6 objects x 1 reference", "6 objects x 5 references",
        "categories, 1 other object x 5 references", "categories, 2 other objects x 5 references",
    ]  # fmt: skip
    for each in sets.values():
        assert sorted(name for fold in each.folds for name in fold.tested) == sorted(names), (
            "each is shown once"
        )
        for fold in each.folds:
            assert set(fold.tested.values()) <= set(fold.known.values())
            assert bool(set(fold.tested) & set(fold.known)) == ("categories" not in each.name)
    assert [len(fold.known) for fold in sets["categories, 2 other objects x 5 references"].folds] == [4] * 3


@pytest.mark.parametrize("names", [["a", "b", "c", "d"], [f"{k}{n}" for k in "abcd" for n in (1, 2, 3, 4)]])
def test_every_object_is_unknown_once(names):
    for each in unknown_sets(names, 5):
        unknown = [name for fold in each.folds for name in fold.tested if name not in fold.known]
        assert sorted(unknown) == sorted(names), each.name
    if len(names) > 4:
        ours, others = unknown_sets(names, 5)
        for fold in ours.folds:
            assert {category(name) for name in fold.known} == set("abcd")
        for fold in others.folds:
            assert len({category(name) for name in fold.known}) == 2
            assert not {category(n) for n in fold.known} & {category(n) for n in names if n not in fold.known}


def test_decision_values_are_added_or_each_view_votes():
    class Machine:
        classes_ = np.array(["a", "b", "c"])
        values = np.array([[5.0, 0.0, 1.0], [0.0, 1.0, 0.5], [0.0, 1.0, 2.0], [-1.0, 2.0, 1.0]])

        def decision_function(self, X):
            return self.values

    assert by_machine(Machine(), np.zeros((4, 1))) == ("c", "b"), "sums 4, 4, 4.5; votes 1, 2, 1"
    tied = SimpleNamespace(
        classes_=np.array(["a", "b"]), decision_function=lambda X: np.array([-1.0, 3.0, -1.0, 0.5])
    )
    assert by_machine(tied, np.zeros((4, 1))) == ("b", "b"), "of equal votes the larger sum decides"


def test_the_nearest_object_to_the_mean_is_that_of_the_rules(splits, described, own):
    known = Known.of(own, 2, splits, described, machine=False)
    O, owners = np.asarray(known.library.O), known.library.owners
    for trial in compose(splits, described, INTRUDER, SIZES, 0):
        far = ((O - trial.X.mean(axis=0)[:, None]) ** 2).sum(axis=0)
        wanted = np.array([far[owners == k].min() for k in range(len(known.library.objects))])
        np.testing.assert_allclose(mean_distances(known.library, trial.X), wanted, rtol=1e-9)
        (found,) = known.recognise(trial, ((0.1, 1.0, 0.1),))
        assert found.rules.mean == known.library.objects[int(wanted.argmin())]
        first, second = sorted(wanted)[:2]
        assert nearest_margin(known.library, trial.X) == pytest.approx(1.0 - first / second, rel=1e-6)


@NEEDS_SKLEARN
@pytest.mark.parametrize("swapped", [False, True])
def test_wrong_labels_are_counted(splits, described, own, swapped):
    """Objects as easy as these are always named; by exchanged labels, never."""
    other = dict(zip(COLOURS, [*list(COLOURS)[1:], *list(COLOURS)[:1]], strict=True))
    fold = Fold(other, other) if not swapped else Fold(other, own.tested)
    known = Known.of(fold, 2, splits, described, machine=True)
    trials = compose(splits, described, CLEAR, SIZES, 0)
    found = [(t.scene, name_by_all(known, t, fold.tested[t.scene.object])) for t in trials]
    (chosen, *_) = object_sets(list(COLOURS), 2)
    told = measured._accuracy(chosen, CLEAR, found, DESIGN)
    assert told["scenes"] == told["proved"] == len(trials)
    assert told["proved and wrong"] == (len(trials) if swapped else 0)
    assert {name: figure[0] for name, figure in told["methods"].items()} == dict.fromkeys(
        METHODS, 0.0 if swapped else 1.0
    )
    assert {name: figure[0] for name, figure in told[f"{PAPER[0]} minus"].items()} == dict.fromkeys(
        METHODS[1:], 0.0
    )
    margin = measured._margin(chosen, CLEAR, found, DESIGN)[PAPER[0]]
    assert (margin["wrong"], margin["right"]) == ((6, 0) if swapped else (0, 6))
    assert margin["auc"] == [None, None, None]


@NEEDS_SKLEARN
def test_the_area_under_the_curve_is_that_of_scikit_learn():
    from sklearn.metrics import roc_auc_score  # noqa: PLC0415 - an optional package

    rng = np.random.default_rng(3)
    high, low = rng.integers(2, 9, 40) / 8.0, rng.integers(0, 6, 30) / 8.0
    objects = [f"{k % 7}" for k in range(70)]
    wanted = roc_auc_score([1] * 40 + [0] * 30, [*high, *low])
    mean, lower, upper = separation(high, low, objects[:40], objects[40:], DESIGN)
    assert mean == pytest.approx(wanted, abs=1e-4)
    assert lower < mean < upper


def synthetic(rng: np.random.Generator, objects: int = 20, each: int = 6):
    """Scores of scenes whose chance of being right differs by object, 0.7 on average; and their scenes."""
    chances = rng.beta(7.0, 3.0, objects)
    scenes = [
        Scene(f"{k}, {n}", f"{k}", CLEAR, (View("robot-1", 1.0, photograph=f"{k}/{n}"),))
        for k in range(objects)
        for n in range(each)
    ]
    return (rng.random(objects * each) < np.repeat(chances, each)).astype(np.float64), scenes


def test_intervals_contain_the_truth_about_as_often_as_they_say():
    inside = {"share": 0, "area": 0}
    trials, true_area = 120, 0.7602  # P(N(1, 1) > N(0, 1)) = Phi(1 / sqrt(2))
    for k in range(trials):
        rng = np.random.default_rng([5, k])
        scores, scenes = synthetic(rng)
        ((_, lower, upper),) = figures(scores[:, None], scenes, Design(k, 1, 300))
        inside["share"] += lower <= 0.7 <= upper
        objects = [f"{k}" for k in range(30) for _ in range(3)]
        found = separation(
            rng.normal(1.0, 1.0, 90), rng.normal(0.0, 1.0, 90), objects, objects, Design(k, 1, 300)
        )
        inside["area"] += found[1] <= true_area <= found[2]
    assert all(0.88 * trials <= count for count in inside.values()), inside
    assert all(count < trials for count in inside.values()), f"intervals that say nothing: {inside}"


def test_quarters_go_from_the_smallest_margin_to_the_largest():
    assert quartiles([0.4, 0.1, 0.3, 0.2, 0.8, 0.7, 0.6, 0.5], [1, 0, 0, 0, 1, 1, 1, 1]) == [
        0.0,
        0.5,
        1.0,
        1.0,
    ]


@NEEDS_SKLEARN
def test_everything_is_measured_and_adds_up():
    colours, sizes = list(COLOURS), Sizes(seed=1, draws=1, scenes=6, references=2)
    shown = [album(f"{colour}{k}", colour) for colour in colours for k in (1, 2)]
    steps: list[tuple[str, int, int]] = []
    found = measured.measure(shown, FeatureConfiguration(), sizes, DESIGN, lambda *step: steps.append(step))
    assert steps[-1][1] == steps[-1][2] == 5
    assert len(found["accuracy"]) == len(found["margin"]) == 5 * len(CONDITIONS)
    assert {each["scenes"] for each in found["accuracy"]} == {len(shown) * sizes.scenes}
    for each in found["accuracy"]:
        means = {name: figure[0] for name, figure in each["methods"].items()}
        less = {name: figure[0] for name, figure in each[f"{PAPER[0]} minus"].items()}
        assert less == pytest.approx({name: means[PAPER[0]] - means[name] for name in METHODS[1:]}, abs=2e-4)
    assert any(each[f"{PAPER[0]} minus"]["vote"][0] != 0.0 for each in found["accuracy"])
    first = {each["objects"]: each for each in found["accuracy"] if each["condition"] == CLEAR}
    assert first["3 objects x 2 references"]["methods"][PAPER[0]][0] == 1.0
    assert first["6 objects x 2 references"]["methods"][PAPER[0]][0] < 1.0, "two objects look the same"
    assert [each["objects"] for each in found["acceptance"]] == [
        "unknown objects of known categories",
        "unknown objects of unknown categories",
    ]
    for each in found["acceptance"]:
        assert each["known scenes"] == each["unknown scenes"] == len(shown) * sizes.scenes
        assert each["calibration scenes"] in (12, 18)
        first, *_ = each["after"]
        assert first["known"]["recognised and right"]["scenes"] > 0, "enough scenes for thresholds"
        for row in each["after"]:
            known, unknown = row["known"], row["unknown"]
            kinds = ("recognised and right", "recognised and wrong", "ambiguous", "refused")
            assert sum(known[kind]["scenes"] for kind in kinds) == each["known scenes"]
            assert sum(part["scenes"] for part in unknown.values()) == each["unknown scenes"]
            assert known["covered"]["scenes"] >= known["recognised and right"]["scenes"]
        assert each["before"]["unknown"]["proved"]["scenes"] == each["unknown scenes"]


@NEEDS_SKLEARN
def test_without_views_for_scenes_of_their_own_nothing_is_calibrated():
    shown = [album(colour, colour, 9) for colour in COLOURS]
    found = measured.measure(shown, FeatureConfiguration(), SIZES, DESIGN, lambda *step: None)
    assert not found["acceptance"]
    assert "too few photographs" in found["not calibrated"]
