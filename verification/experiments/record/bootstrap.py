"""The bootstrap of means over scenes: objects are drawn first, then what was drawn at random for each.

Scenes that share no photograph are drawn themselves, within their object and level of obstruction.
Photographs serve several scenes each; there they are drawn, and a scene has the first-order weight
1 + sum over its views of (times the photograph was drawn - 1), which may be negative: a mean over scenes is
then moved by a photograph's multiplicity as the mean over all the scenes that could be made of the
photographs would be, to first order.

The resamples have the shape of the distribution, but not its width: with few objects they are too close
together, and drawing scenes as well counts their noise twice. So their distances from the mean are
multiplied by (t/z) s/r: with the quantiles t of Student's distribution, one degree of freedom less than
objects, and z of the normal one; s the standard error of the mean as the means of the objects show it, at
least that from scenes alone; and r the standard deviation of the resamples. For scores s is at least
sqrt(2)/(number of scenes + 4), times the largest distance of a scene's score from the mean if they are not
all equal: that hardly a scene differs may be chance.

Sources: A. C. Davison and D. V. Hinkley, Bootstrap Methods and their Application, 1997, section 3.8 (objects,
then scenes); W. Hoeffding, A class of statistics with asymptotically normal distribution, Ann. Math. Stat. 19
(1948) (the first-order part of a mean over subsets); T. C. Hesterberg, What teachers should know about the
bootstrap, American Statistician 69 (2015) (percentile intervals of few units are too short, and how t widens
them); A. Agresti and B. A. Coull, Approximate is better than "exact", American Statistician 52 (1998) (of n
trials none succeeded: as if of n + 4 two had).
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm, t

from verification.experiments.design import Design, key
from verification.experiments.scenes.pictures import Scene
from verification.ledger.claims import PROTOCOL

Floats = NDArray[np.float64]

TINY = 1e-12
"""Standard deviation of resamples below which it is rounding; scores and shares are of the order of 1."""


class Intervals(NamedTuple):
    """Means with their bounds, each of shape (k,)."""

    mean: Floats
    lower: Floats
    upper: Floats


def intervals(
    values: Floats, scenes: Sequence[Scene], design: Design, comparisons: int = 1, *, scored: bool = False
) -> Intervals:
    """Mean over the scenes and its interval, for several columns on the same resamples.

    Parameters
    ----------
    values : float64 (scenes, k)
    scenes : sequence of Scene
        Of at least two objects; that of each row.
    design : Design
        Its `resamples` and `seed`.
    comparisons : int
        Each interval is at 1 - 0.05 / comparisons: the level at which so many hold together at 0.95.
    scored : bool
        Whether the values are scores, or differences of scores.

    Raises
    ------
    ValueError
        There are fewer than two objects.
    """
    return resampled(values, scenes, design, scored=scored).intervals(comparisons)


@dataclass(frozen=True, slots=True, eq=False)
class Resampled:
    """What intervals at any level are made of.

    Attributes
    ----------
    mean : float64 (k,)
    means : float64 (resamples, k)
        Of the resamples.
    error : float64 (k,)
        Standard error of the mean.
    objects : int
    """

    mean: Floats
    means: Floats
    error: Floats
    objects: int

    def intervals(self, comparisons: int) -> Intervals:
        """See the function of this name."""
        tail = (1.0 - PROTOCOL.confidence) / (2 * comparisons)
        distances, apart = (
            np.quantile(self.means, [tail, 1.0 - tail], axis=0) - self.mean,
            self.means.std(axis=0),
        )
        shape = np.where(
            apart > TINY, distances / np.where(apart > TINY, apart, 1.0), norm.ppf([[tail], [1.0 - tail]])
        )
        few = t.ppf(tail, self.objects - 1) / norm.ppf(tail)
        return Intervals(self.mean, *(self.mean + few * self.error * shape))


def resampled(values: Floats, scenes: Sequence[Scene], design: Design, *, scored: bool) -> Resampled:
    """Resample the mean; for the parameters and errors see `intervals`."""
    weights = resamples(tuple(scenes), design.resamples, design.seed)
    error = standard_error(values, scenes)
    error = np.maximum(error, least_error(values)) if scored else error
    means = np.asarray(weights @ values / weights.sum(axis=1, keepdims=True))
    return Resampled(values.mean(axis=0), means, error, len(objects(scenes)))


def least_error(values: Floats) -> Floats:
    """Least standard error of mean scores, shape (k,), see above."""
    furthest = np.abs(values - values.mean(axis=0)).max(axis=0)
    return np.where(furthest > TINY, furthest, 1.0) * math.sqrt(2.0) / (len(values) + 4)


def standard_error(values: Floats, scenes: Sequence[Scene]) -> Floats:
    """Of the mean, shape (k,): from the means of the objects, or from scenes within them if that is more.

    Raises
    ------
    ValueError
        There are fewer than two objects: nothing shows how they differ.
    """
    groups = list(objects(scenes).values())
    if len(groups) < 2:
        raise ValueError(f"{len(groups)} objects: an interval needs at least two")
    mean = values.mean(axis=0)
    sums = np.array([(values[own] - mean).sum(axis=0) for own in groups])
    between = (sums**2).sum(axis=0) * len(groups) / (len(groups) - 1)
    strata = [values[each] for own in groups for each in _strata(scenes, own) if len(each) > 1]
    within = sum((len(each) * each.var(axis=0, ddof=1) for each in strata), np.zeros_like(mean))
    return np.asarray(np.sqrt(np.maximum(between, within)) / len(values))


def objects(scenes: Sequence[Scene]) -> dict[str, list[int]]:
    """Numbers of scenes by their object."""
    found: dict[str, list[int]] = {}
    for k, scene in enumerate(scenes):
        found.setdefault(scene.object, []).append(k)
    return found


@lru_cache(maxsize=8)
def resamples(scenes: tuple[Scene, ...], count: int, seed: int) -> Floats:
    """What each scene weighs in each resample, shape (count, scenes); the sum of a row is above 0.

    Raises
    ------
    ValueError
        Hardly any resample gives the scenes a positive weight.
    """
    rng = np.random.default_rng([seed, key("bootstrap"), len(scenes)])
    kept: list[Floats] = []
    for _ in range(8):
        drawn = _drawn(scenes, count, rng)
        kept.append(drawn[drawn.sum(axis=1) > 0.5])
        if sum(map(len, kept)) >= count:
            found = np.concatenate(kept)[:count]
            found.flags.writeable = False
            return found
    raise ValueError(f"{len(scenes)} scenes: too few resamples with a positive weight")


def _drawn(scenes: tuple[Scene, ...], count: int, rng: np.random.Generator) -> Floats:
    """Objects with replacement; then, for each time that an object was drawn, what it consists of."""
    by_object = objects(scenes)
    number = len(by_object)
    times = rng.multinomial(number, np.full(number, 1.0 / number), size=count)
    weights = np.zeros((count, len(scenes)))
    for name, drawn in zip(sorted(by_object), times.T, strict=True):
        own = by_object[name]
        if _photographed(scenes[k] for k in own):
            weights[:, own] = _by_photograph([scenes[k] for k in own], drawn, rng)
        else:
            for stratum in _strata(scenes, own):
                weights[:, stratum] = _multiplicities(len(stratum), drawn, rng)
    return weights


def _strata(scenes: Sequence[Scene], own: Iterable[int]) -> list[list[int]]:
    """Numbers of scenes by their level of obstruction."""
    found: dict[str, list[int]] = {}
    for k in own:
        found.setdefault(scenes[k].level, []).append(k)
    return list(found.values())


def _photographed(scenes: Iterable[Scene]) -> bool:
    return all(view.photograph is not None for scene in scenes for view in scene.views)


def _by_photograph(scenes: Sequence[Scene], drawn: NDArray[np.int64], rng: np.random.Generator) -> Floats:
    """First-order weights of one object's scenes, shape (resamples, scenes)."""
    shown = [[str(view.photograph) for view in scene.views] for scene in scenes]
    names = sorted({name for each in shown for name in each})
    uses = np.array([[each.count(name) for name in names] for each in shown], dtype=np.float64)
    excess = _multiplicities(len(names), drawn, rng) - drawn[:, None]
    return np.asarray(drawn[:, None] + excess @ uses.T)


def _multiplicities(units: int, drawn: NDArray[np.int64], rng: np.random.Generator) -> Floats:
    """How often each unit is drawn where all are drawn `drawn` times, shape (resamples, units)."""
    return rng.multinomial(drawn * units, np.full(units, 1.0 / units)).astype(np.float64)
