"""Shares with their intervals, and how well a number tells two kinds of scenes apart.

Intervals of shares and of their differences are those of `verification.experiments.record.bootstrap`: objects
are drawn, then their photographs, and the width is at least that of Student's t for the means of the objects.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from verification.experiments.design import Design, key
from verification.experiments.record.bootstrap import intervals
from verification.experiments.scenes.pictures import Scene
from verification.ledger.claims import PROTOCOL

Floats = NDArray[np.float64]
Figure = list[float | None]
"""A value with the lower and the upper end of its interval at 95 %; the ends are null where there is none."""
DIGITS = 4


def figures(values: Floats, scenes: Sequence[Scene], design: Design) -> list[Figure]:
    """Mean of each column over the scenes, with its interval.

    Parameters
    ----------
    values : float64 (scenes, k)
        In [0, 1], or differences of such.
    scenes : sequence of Scene
        Of one object there is no interval.
    design : Design
    """
    if len({scene.object for scene in scenes}) < 2:
        return [[_rounded(mean), None, None] for mean in values.mean(axis=0)]
    found = intervals(values, scenes, design, scored=True)
    return [[_rounded(each) for each in row] for row in zip(*found, strict=True)]


def separation(high: Any, low: Any, above: Sequence[str], below: Sequence[str], design: Design) -> Figure:
    """Chance that a number of one kind of scene exceeds one of the other: the area under the ROC curve.

    Its interval is the percentile interval over resamples of the objects.

    Parameters
    ----------
    high, low : array_like (r,), (s,)
        The numbers of the kind that is expected to have the higher ones, and of the other.
    above, below : sequence of r and of s str
        The objects of their scenes.
    design : Design
        Its `seed` and `resamples`.
    """
    first, second = np.asarray(high, dtype=np.float64), np.asarray(low, dtype=np.float64)
    if not first.size or not second.size:
        return [None, None, None]
    names = sorted({*above, *below})
    owners = [np.array([names.index(each) for each in part]) for part in (above, below)]
    wins, pairs = np.zeros((len(names), len(names))), np.zeros((len(names), len(names)))
    more = (first[:, None] > second) + 0.5 * (first[:, None] == second)
    at = np.broadcast_arrays(owners[0][:, None], owners[1])
    np.add.at(wins, tuple(at), more)
    np.add.at(pairs, tuple(at), 1.0)
    rng = np.random.default_rng([design.seed, key("separation"), len(names)])
    times = rng.multinomial(len(names), np.full(len(names), 1.0 / len(names)), size=design.resamples)
    number = np.einsum("bi,ij,bj->b", times, pairs, times, optimize=True)
    drawn = np.einsum("bi,ij,bj->b", times, wins, times, optimize=True)[number > 0] / number[number > 0]
    tail = (1.0 - PROTOCOL.confidence) / 2.0
    ends = np.quantile(drawn, [tail, 1.0 - tail]).tolist() if len(names) > 1 else [None, None]
    return [_rounded(wins.sum() / pairs.sum()), *(None if end is None else _rounded(end) for end in ends)]


def quartiles(margins: Any, right: Any) -> list[float]:
    """Share of right labels in each quarter of the scenes, that of the smallest margins first."""
    order = np.argsort(np.asarray(margins), kind="stable")
    shares = np.asarray(right, dtype=np.float64)[order]
    return [_rounded(part.mean()) for part in np.array_split(shares, 4) if part.size]


def _rounded(value: Any) -> float:
    return round(float(value), DIGITS)
