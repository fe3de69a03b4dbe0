"""The experiments' parts: configurations, scores, claims, weights, baselines, bits."""

from dataclasses import replace
from itertools import combinations, product
from math import log2

import numpy as np
import pytest
from made_up_pictures import measured, picture_set

from convexperc import recognize
from convexperc.errors import InputError
from convexperc.features import FeatureConfiguration
from verification.experiments.design import GOOD_VIEWS, GRID, SETTINGS, Design
from verification.experiments.measure import configurations
from verification.experiments.measure.baselines import BASELINES, score
from verification.experiments.measure.configurations import FACTORS, GENERATORS, first, fraction, involved
from verification.experiments.measure.information import mutual_information
from verification.experiments.measure.numbers import rounded
from verification.experiments.measure.subsets import drawn, of_grid
from verification.experiments.measure.trials import (
    KINDS,
    RIGHT,
    TIE,
    Known,
    Tried,
    recognitions,
    scored,
)
from verification.experiments.measure.weights import by_rank, chance_that_best_are_good
from verification.experiments.record.claims import CLAIMS, Measured
from verification.experiments.record.verdicts import judge, rule_of
from verification.experiments.scenes.pictures import obstruction
from verification.ledger.claims import PARTS
from verification.ledger.surveys import Comparison

DESIGN = Design(seed=0, repetitions=4, resamples=2000)


# ---------- configurations


def test_the_default_reading_is_what_the_library_does() -> None:
    default = fraction()[0]
    assert default.features == FeatureConfiguration(), default
    assert (default.lambda1, default.background, default.id) == (0.1, True, "r000")


def balanced(chosen: tuple[configurations.Configuration, ...], size: int) -> bool:
    """Whether all combinations of the levels of any `size` factors are equally frequent."""
    for columns in combinations(range(len(FACTORS)), size):
        counts: dict[tuple[object, ...], int] = {}
        for each in chosen:
            key = tuple(each.levels[k] for k in columns)
            counts[key] = counts.get(key, 0) + 1
        wanted = np.prod([len(list(FACTORS.values())[k]) for k in columns])
        if len(counts) != wanted or len(set(counts.values())) != 1:
            return False
    return True


def test_the_fraction_is_of_resolution_four() -> None:
    chosen = fraction()
    assert len({each.levels for each in chosen}) == 128
    words = [np.bitwise_xor.reduce([g for g, on in zip(GENERATORS, pick, strict=True) if on] or [0])
             for pick in product((0, 1), repeat=3)]  # fmt: skip
    assert min(involved(int(word)) for word in words if word) == 4, words
    assert balanced(chosen, 3)
    assert not balanced(chosen, 4), "then the fraction would be better than it is said to be"


def test_a_worse_generator_would_be_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(configurations, "GENERATORS", (0b0001000101, *GENERATORS[1:]))
    fraction.cache_clear()
    try:
        assert not balanced(fraction(), 3)
    finally:
        monkeypatch.undo()
        fraction.cache_clear()


@pytest.mark.parametrize("count", [4, 8, 16, 64])
def test_a_beginning_of_the_readings_is_balanced(count: int) -> None:
    assert balanced(first(count), 1)
    assert first(count)[0] == fraction()[0]


@pytest.mark.parametrize("count", [0, 129])
def test_there_are_128_readings(count: int) -> None:
    with pytest.raises(InputError, match="from 1 to 128"):
        first(count)


# ---------- trials


def known_and_views(seed: int = 0) -> tuple[Known, np.ndarray]:
    rng = np.random.default_rng(seed)
    O = rng.random((12, 4))
    X = O.T[[1, 1, 2]] + 0.4 * rng.random((3, 12))
    return Known(("a", "b", "c", "d"), O, {"color": 4, "hog": 5, "lbp": 3}, 0.1), X


@pytest.mark.parametrize("seed", range(3))
def test_reading_the_data_once_gives_what_recognize_gives(seed: int) -> None:
    known, X = known_and_views(seed)
    pairs = list(DESIGN.pairs)
    for pair, found in zip(pairs, recognitions(X, known, pairs), strict=True):
        wanted = recognize(
            X,
            known.O,
            names=known.names,
            lambda1=0.1,
            lambda2=pair[0],
            lambda3=pair[1],
            modalities=known.sizes,
        )
        assert (found.verdict, found.label) == (wanted.verdict, wanted.label), pair
        assert scored(found, 1) == scored(wanted, 1), pair


@pytest.mark.parametrize("copies", [2, 3])
def test_a_tie_scores_the_chance_of_a_fair_draw_whatever_the_order(copies: int) -> None:
    known, X = known_and_views()
    O = np.column_stack([known.O] + [known.O[:, 1]] * (copies - 1))
    naive = set()
    for order in (np.arange(O.shape[1]), np.arange(O.shape[1])[::-1]):
        names = tuple("abcdefg"[k] for k in order)
        found = next(recognitions(X, Known(names, O[:, order], known.sizes, 0.1), [(0.1, 0.1)]))
        outcome = scored(found, names.index("b"))
        assert (outcome.kind, outcome.score, outcome.label) == (TIE, pytest.approx(1 / copies), -1), found
        assert scored(found, names.index("a")).score == 0.0
        naive.add(found.candidates[0] == "b")
    assert naive == {True, False}, "taking the first candidate would depend on the order, and be seen"


def test_where_nothing_is_explained_every_object_is_a_candidate() -> None:
    known, X = known_and_views()
    found = next(recognitions(X, known, [(1e6, 10.0)]))
    assert scored(found, 3).score == pytest.approx(1 / 4)
    assert KINDS[scored(found, 3).kind] == "tie"


def test_subsets_are_of_the_right_size_and_depend_on_seed_and_scene_alone() -> None:
    layout = picture_set(("red", "green"), levels=True).layout
    one, other = (drawn(DESIGN, "physical", scene) for scene in layout.scenes[:2])
    assert one == drawn(DESIGN, "physical", layout.scenes[0])
    assert one != other
    assert one != drawn(Design(1, 4, 10), "physical", layout.scenes[0])
    for n, each in enumerate(one, 1):
        assert len(each) == DESIGN.repetitions
        assert all(len(set(s)) == n and s == tuple(sorted(s)) and max(s) < 6 for s in each), each
    assert [len(s) for s in of_grid(one)] == [3, 6]


# ---------- the claims


def said(claim: str, given: Measured) -> Comparison:
    """What one configuration says of a part, by the rule of the ledger; made-up scores are no samples."""
    return judge(replace(CLAIMS[claim](given), scored=False), rule_of(claim), DESIGN)


def constant(scores: np.ndarray, grid: np.ndarray, w: np.ndarray, norms: np.ndarray) -> Measured:
    """Every scene has the same scores in every repetition."""
    wide = [np.tile(each[None, :, :, None], (15, 1, 1, 2)) for each in (scores, grid)]
    blank = [Tried(each.astype(np.int64), each, each.astype(np.int64)) for each in wide]
    return measured(*blank, DESIGN, w, norms)


def as_printed() -> Measured:
    """Everything as the paper says."""
    scores = np.tile(np.linspace(0.5, 0.8, 6), (4, 1)) + np.array([0.0, 0.1, 0.05, 0.15])[:, None]
    grid = np.full((5, 5), 0.5)
    grid[2, 2] = grid[3, 2] = 0.9
    grid[0], grid[:, 0], grid[4, 4] = 0.3, 0.3, 0.1
    # the made-up views: a partly obstructed one first, a fully obstructed one last
    return constant(scores, grid, np.array([0.0, 0.01, 0.02, 0.5, 0.4, 0.0]), np.array([0.2, 0.9, 0.01]))


def test_what_is_as_printed_is_reproduced_and_what_is_flat_has_no_effect() -> None:
    printed = as_printed()
    found = {part: said(part, printed) for part in CLAIMS if part != "X5/stated"}
    assert {each.outcome for each in found.values()} == {"reproduced"}, found
    sizes = {part: len(claim(printed).differences) for part, claim in CLAIMS.items()}
    assert sizes == {key: part.rule.comparisons for key, part in PARTS.items() if part.rule is not None}
    assert [sizes[part] for part in ("X2/stated", "X3/stated", "X4/stated")] == [15, 15, 1]
    assert [sizes[part] for part in ("X8/zero", "X8/ten", "X8/peak")] == [6, 1, 3]
    flat = constant(np.full((4, 6), 0.5), np.full((5, 5), 0.5), np.full(6, 0.1), np.array([0.3, 0.2, 0.4]))
    wrong = {part: said(part, flat).outcome for part in CLAIMS if not part.startswith("X1")}
    assert wrong.pop("X5/stated") == "open", "tau is not defined where all weigh the same"
    missed = {key for key, part in PARTS.items() if part.rule is not None and part.rule.figure}
    below = {"X7/lbp", "X7/hog"} | missed
    assert wrong == {part: "opposite" if part in below else "no effect" for part in wrong}


def test_what_is_turned_round_is_the_opposite() -> None:
    printed = as_printed()
    for part in ("X2/stated", "X3/stated", "X4/stated", "X8/zero", "X8/ten", "X8/peak", "X6/direction"):
        claim = CLAIMS[part](printed)
        turned = replace(
            claim, differences={name: -each for name, each in claim.differences.items()}, scored=False
        )
        assert judge(turned, rule_of(part), DESIGN).outcome == "opposite", part


def test_one_view_decides_nothing() -> None:
    """With one view the label depends on no lambda: a gain there counts neither way."""
    scores = np.full((4, 6), 0.5)
    scores[0, 0] = 1.0
    alone = constant(scores, np.full((5, 5), 0.5), np.full(6, 0.1), np.ones(3))
    assert {said(part, alone).outcome for part in ("X2/stated", "X3/stated", "X4/stated")} == {"no effect"}


def test_rank_and_information() -> None:
    agree = constant(np.zeros((4, 6)), np.zeros((5, 5)), np.arange(1.0, 7.0), np.ones(3))
    assert said("X5/stated", agree).statistic == pytest.approx(1.0)
    against = constant(np.zeros((4, 6)), np.zeros((5, 5)), -np.arange(7.0, 1.0, -1.0), np.ones(3))
    assert said("X5/stated", against).outcome == "opposite"


def test_scenes_without_weights_are_left_out_and_counted() -> None:
    nothing = constant(np.zeros((4, 6)), np.zeros((5, 5)), np.zeros(6), np.zeros(3))
    for part in ("X6/direction", "X6/zero", "X6/two", "X7/lbp", "X7/hog", "X7/figure"):
        found = said(part, nothing)
        assert (found.outcome, found.units, found.left_out) == ("open", 0, 3), part


def test_shares_of_the_weight_are_those_of_a_view() -> None:
    """The made-up views: a partly obstructed one first, a fully obstructed one last, four clear ones."""
    w = np.array([0.1, 0.3, -0.2, 0.1, 0.2, 0.1])
    found = said("X6/direction", constant(np.zeros((4, 6)), np.zeros((5, 5)), w, np.ones(3)))
    assert found.statistic == pytest.approx(0.8 / 4 - 0.2 / 2)
    norms = np.array([0.2, 0.5, 0.3])  # LBP has 0.3: a little less than an equal share
    shares = constant(np.zeros((4, 6)), np.zeros((5, 5)), w, norms)
    statistics = {part: said(part, shares).statistic for part in ("X7/lbp", "X7/hog", "X7/figure")}
    assert statistics == pytest.approx({"X7/lbp": 1 / 3 - 0.3, "X7/hog": 0.2, "X7/figure": -0.25})


# ---------- weights, baselines, information


def by_listing(w: np.ndarray, good: np.ndarray) -> float:
    """The chance by listing every choice of three views that has the largest weights."""
    best = np.sort(np.abs(w))[-GOOD_VIEWS:]
    choices = [list(c) for c in combinations(range(len(w)), GOOD_VIEWS)]
    choices = [c for c in choices if np.array_equal(np.sort(np.abs(w[c])), best)]
    return sum(bool(good[c].all()) for c in choices) / len(choices)


def test_the_chance_that_the_best_views_are_good_is_that_of_a_listing() -> None:
    seen = set()
    for values in product((0.0, -1.0, 2.0), repeat=5):
        for chosen in combinations(range(5), 3):
            good = np.isin(np.arange(5), chosen)
            found = chance_that_best_are_good(np.array(values), good)
            assert found == pytest.approx(by_listing(np.array(values), good)), (values, chosen)
            seen.add(round(found, 6))
    assert {0.0, 1.0, 0.1} < seen, seen


def test_equal_weights_share_what_their_ranks_have() -> None:
    found = by_rank(np.array([0.0, -3.0, 0.0, 1.0]), np.array([1.0, 5.0, 3.0, 4.0]))
    assert found.tolist() == [5.0, 4.0, 2.0, 2.0]


def test_baselines_are_what_their_formulas_say() -> None:
    known, X = known_and_views()
    G, C, squares = X @ X.T, X @ known.O, (known.O**2).sum(axis=0)
    found = {name: value(G, C, squares) for name, value in BASELINES.items()}
    for j, o in enumerate(known.O.T):
        assert found["best single view"][j] == pytest.approx(min(((x - o) ** 2).sum() for x in X))
        assert found["mean of the views"][j] == pytest.approx(((X.mean(axis=0) - o) ** 2).sum())
        w = np.linalg.lstsq(np.vstack([X.T, np.sqrt(0.1) * np.eye(3)]), np.r_[o, np.zeros(3)])[0]
        assert found["ridge"][j] == pytest.approx(((X.T @ w - o) ** 2).sum() + 0.1 * (w**2).sum())
    assert score(np.array([2.0, 1.0, 1.0 + 1e-14]), 1) == 0.5
    assert score(np.array([2.0, 1.0, 1.0 + 1e-9]), 1) == 1.0
    assert score(np.array([2.0, 1.0, 1.1]), 0) == 0.0


def test_bits_are_counted() -> None:
    rng = np.random.default_rng(3)
    halves = np.zeros((64, 64), dtype=np.uint8)
    halves[:, 32:] = 255
    assert mutual_information(halves, halves) == pytest.approx(1.0)
    assert mutual_information(halves, halves.T.copy()) == pytest.approx(0.0, abs=1e-12)
    quarters = np.repeat(np.array([0, 64, 128, 192], dtype=np.uint8), 1024).reshape(64, 64)
    assert mutual_information(quarters, quarters) == pytest.approx(log2(4))
    assert mutual_information(quarters, quarters + np.uint8(3)) == pytest.approx(2.0), "bins are eight wide"
    noise = [rng.integers(0, 256, (256, 256)).astype(np.uint8) for _ in range(2)]
    assert mutual_information(*noise) < 0.02


def test_obstruction_has_its_bounds() -> None:
    assert [obstruction(share) for share in (0.0, 0.05, 0.051, 0.899, 0.9, 1.0)] == [
        "full", "full", "partial", "partial", "none", "none",
    ]  # fmt: skip


def test_numbers_are_rounded_to_six_digits() -> None:
    assert rounded({"a": [1 / 3, -0.0, 7], "b": np.array([1e-9 / 3])}) == {
        "a": [0.333333, 0.0, 7],
        "b": [3.33333e-10],
    }
    with pytest.raises(ValueError, match="nan"):
        rounded([float("nan")])


def test_the_design_is_validated_and_the_grid_has_its_cells() -> None:
    assert len(DESIGN.pairs) == len(GRID) ** 2
    assert set(SETTINGS) < set(DESIGN.pairs)
    assert KINDS.index("right") == RIGHT
    for bad in ({"seed": -1}, {"repetitions": 0}, {"resamples": 0}, {"seed": True}):
        with pytest.raises(InputError, match="at least"):
            Design(**bad)
