"""The paper's claims about its experiments, each as comparisons whose means must lie above 0."""

from collections.abc import Callable, Sequence
from math import comb

import numpy as np
from numpy.typing import NDArray
from scipy.stats import kendalltau

from verification.experiments.design import (
    BOTH,
    FEATURES_ALONE,
    GOOD_VIEWS,
    GRID,
    NOTHING,
    SETTINGS,
    STUDY_VIEWS,
    VIEWS_ALONE,
    Pair,
)
from verification.experiments.measure.features import MODALITIES
from verification.experiments.measure.measured import Measured
from verification.experiments.measure.weights import chance_that_best_are_good
from verification.experiments.record.verdicts import Comparisons
from verification.experiments.scenes.pictures import Scene

Floats = NDArray[np.float64]

BEST_SHARE, NEAR_ZERO = 0.8, 0.05
"""The paper's 80 % of the weight, taken for the scenes of X1 as well; and what is called nearly 0 of a sum.
Smallest effects stand in the ledger."""
CHANCE = 1.0 / comb(STUDY_VIEWS, GOOD_VIEWS)
"""That three views drawn at random are the three good ones."""
FEWEST = 2
"""Views from which on accuracies are compared: with one, the label depends on no lambda (R1/one_view)."""
PEAK: tuple[Pair, Pair] = ((0.1, 0.1), (1.0, 0.1))
"""Where the paper saw the highest accuracy."""
NAMED: tuple[tuple[float, ...], tuple[float, ...]] = ((0.0, 0.1, 1.0, 10.0), (0.0, 0.1, 10.0))
"""Of the grid's values of lambda2 and lambda3, those that the paper's text names."""


def pair_name(pair: Pair) -> str:
    """(lambda2, lambda3) in words."""
    return f"({pair[0]:g}, {pair[1]:g})"


def _against(measured: Measured, better: tuple[Pair, ...], worse: tuple[Pair, ...]) -> Comparisons:
    """Accuracies of every pair of settings at every n >= 2."""
    found = {}
    for high in better:
        for low in worse:
            gain = _gain(measured, high, low)
            for k, n in enumerate(measured.design.counts[FEWEST - 1 :]):
                found[f"n = {n}, {pair_name(high)} against {pair_name(low)}"] = gain[:, k]
    return Comparisons(found, measured.layout.scenes, scored=True)


def _gain(measured: Measured, high: Pair, low: Pair) -> Floats:
    """Differences of accuracies, shape (scenes, counts from 2 on)."""
    accuracy = measured.accuracy[:, :, FEWEST - 1 :]
    return np.asarray(accuracy[:, SETTINGS.index(high)] - accuracy[:, SETTINGS.index(low)])


def _good_first(measured: Measured) -> Floats:
    """The chance that a scene's three best-ranked views are its three good ones, shape (scenes,)."""
    good = [np.array([view.good for view in scene.views]) for scene in measured.study.scenes]
    pairs = zip(measured.study_weights.w, good, strict=True)
    return np.array([chance_that_best_are_good(w, each) for w, each in pairs])


def good_views_first(measured: Measured) -> Comparisons:
    """X1: the three best-ranked views are the three good ones more often than by chance."""
    found = {"share of scenes - 0.1": _good_first(measured) - CHANCE}
    return Comparisons(found, measured.study.scenes, scored=True)


def good_views_mostly_first(measured: Measured) -> Comparisons:
    """X1: they are in over 80 % of the scenes."""
    found = {"share of scenes - 0.8": _good_first(measured) - BEST_SHARE}
    return Comparisons(found, measured.study.scenes, scored=True)


def nothing_is_worst(measured: Measured) -> Comparisons:
    """X2: lambda2 = lambda3 = 0 is worst at every n >= 2."""
    return _against(measured, tuple(pair for pair in SETTINGS if pair != NOTHING), (NOTHING,))


def both_are_best(measured: Measured) -> Comparisons:
    """X3: lambda2 = lambda3 = 0.1 is best at every n >= 2."""
    return _against(measured, (BOTH,), tuple(pair for pair in SETTINGS if pair != BOTH))


def views_beat_features(measured: Measured) -> Comparisons:
    """X4: with one norm only, that of w beats that of u."""
    gain = _gain(measured, VIEWS_ALONE, FEATURES_ALONE).mean(axis=1)
    name = f"mean over n, {pair_name(VIEWS_ALONE)} against {pair_name(FEATURES_ALONE)}"
    return Comparisons({name: gain}, measured.layout.scenes, scored=True)


def rank_follows_information(measured: Measured) -> Comparisons:
    """X5: views ranked higher share more information: Kendall's tau-b of |w| and the bits."""
    pairs = zip(np.abs(measured.weights.w), measured.information, strict=True)
    tau = np.array([kendalltau(w, bits).statistic for w, bits in pairs])
    return _defined("mean tau", tau, measured.layout.scenes)


def _defined(name: str, values: Floats, scenes: Sequence[Scene]) -> Comparisons:
    """One comparison, of the scenes that define it: NaN where one does not."""
    kept = ~np.isnan(values)
    chosen = [scene for scene, keep in zip(scenes, kept, strict=True) if keep]
    return Comparisons({name: values[kept]}, chosen, int((~kept).sum()))


def _studied(
    name: str, measured: Measured, weights: Floats, value: Callable[[Floats], Floats]
) -> Comparisons:
    """One comparison of shares of a sum of weights, over the scenes with two obstructed views."""
    chosen = measured.studied()
    size = np.abs(weights[chosen])
    total = size.sum(axis=1, keepdims=True)
    shares = np.divide(size, total, out=np.full_like(size, np.nan), where=total > 0.0)
    scenes = [scene for scene, keep in zip(measured.layout.scenes, chosen, strict=True) if keep]
    return _defined(name, value(shares), scenes)


def _hidden(measured: Measured) -> NDArray[np.bool_]:
    """Which views of those scenes are obstructed."""
    return measured.obstructed()[measured.studied()]


def obstructed_views_weigh_less(measured: Measured) -> Comparisons:
    """X6: an obstructed view has a smaller share than an unobstructed one."""
    hidden = _hidden(measured)

    def gain(shares: Floats) -> Floats:
        return np.asarray(
            np.where(hidden, 0.0, shares).sum(axis=1) / (~hidden).sum(axis=1)
            - np.where(hidden, shares, 0.0).sum(axis=1) / hidden.sum(axis=1)
        )

    return _studied("share of a clear view - of an obstructed one", measured, measured.weights.w, gain)


def obstructed_views_vanish(measured: Measured) -> Comparisons:
    """X6: nearly 0 on the two obstructed views."""
    hidden = _hidden(measured)

    def rest(shares: Floats) -> Floats:
        return np.asarray(NEAR_ZERO - np.where(hidden, shares, 0.0).sum(axis=1))

    return _studied("0.05 - share of the obstructed", measured, measured.weights.w, rest)


def two_views_dominate(measured: Measured) -> Comparisons:
    """X6: over 80 % of the weight on two views."""

    def excess(shares: Floats) -> Floats:
        return np.asarray(np.sort(shares, axis=1)[:, -2:].sum(axis=1) - BEST_SHARE)

    return _studied("share of the two largest - 0.8", measured, measured.weights.w, excess)


def texture_weighs_little(measured: Measured) -> Comparisons:
    """X7: LBP has less than an equal share."""
    return _texture_below("1/3", 1.0 / len(MODALITIES), measured)


def texture_vanishes(measured: Measured) -> Comparisons:
    """X7: the total weight of LBP is nearly 0."""
    return _texture_below("0.05", NEAR_ZERO, measured)


def _texture_below(told: str, share: float, measured: Measured) -> Comparisons:
    at, norms = list(MODALITIES).index("lbp"), measured.weights.norms
    return _studied(f"{told} - share of LBP", measured, norms, lambda shares: share - shares[:, at])


def shape_is_primary(measured: Measured) -> Comparisons:
    """X7: HOG has the largest weight."""
    at = list(MODALITIES).index("hog")

    def gain(shares: Floats) -> Floats:
        return np.asarray(shares[:, at] - np.delete(shares, at, axis=1).max(axis=1))

    return _studied("share of HOG - the larger other", measured, measured.weights.norms, gain)


def _below_peak(measured: Measured, wanted: Callable[[Pair], bool]) -> Comparisons:
    """How far cells of the grid, of values that the paper names, lie below the better cell of the peak."""
    cells = {(a, b): measured.cells[:, i, j] for i, a in enumerate(GRID) for j, b in enumerate(GRID)}
    peak = max((cells[pair] for pair in PEAK), key=lambda scores: float(scores.mean()))
    chosen = (pair for pair in cells if pair[0] in NAMED[0] and pair[1] in NAMED[1] and wanted(pair))
    found = {f"{pair_name(pair)} below the peak": peak - cells[pair] for pair in chosen}
    return Comparisons(found, measured.layout.scenes, scored=True)


def low_at_zero(measured: Measured) -> Comparisons:
    """X8: accuracy is low where lambda2 or lambda3 is 0."""
    return _below_peak(measured, lambda pair: 0.0 in pair)


def low_at_ten(measured: Measured) -> Comparisons:
    """X8: accuracy is low where both are 10."""
    return _below_peak(measured, lambda pair: pair == (10.0, 10.0))


def peak_elsewhere_lower(measured: Measured) -> Comparisons:
    """X8: every other cell lies below the peak."""
    return _below_peak(measured, lambda pair: 0.0 not in pair and pair != (10.0, 10.0) and pair not in PEAK)


CLAIMS: dict[str, Callable[[Measured], Comparisons]] = {
    "X1/direction": good_views_first,
    "X1/figure": good_views_mostly_first,
    "X2/stated": nothing_is_worst,
    "X3/stated": both_are_best,
    "X4/stated": views_beat_features,
    "X5/stated": rank_follows_information,
    "X6/direction": obstructed_views_weigh_less,
    "X6/zero": obstructed_views_vanish,
    "X6/two": two_views_dominate,
    "X7/lbp": texture_weighs_little,
    "X7/hog": shape_is_primary,
    "X7/figure": texture_vanishes,
    "X8/zero": low_at_zero,
    "X8/ten": low_at_ten,
    "X8/peak": peak_elsewhere_lower,
}
"""By the keys of the ledger's parts."""
