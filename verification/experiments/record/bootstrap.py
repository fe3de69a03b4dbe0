"""The paired bootstrap over scenes: percentile intervals that hold together for all comparisons of a claim.

Source: B. Efron and R. J. Tibshirani, An Introduction to the Bootstrap, 1993, chapter 13; joint by
Bonferroni's inequality.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from verification.experiments.design import Design, key
from verification.ledger.claims import PROTOCOL

Floats = NDArray[np.float64]


class Intervals(NamedTuple):
    """Means with their bounds, each of shape (k,)."""

    mean: Floats
    lower: Floats
    upper: Floats


@lru_cache(maxsize=8)
def resamples(units: int, count: int, seed: int) -> Floats:
    """How often each unit is drawn in each resample, shape (count, units); rows sum to `units`."""
    rng = np.random.default_rng([seed, key("bootstrap"), units])
    drawn = rng.multinomial(units, np.full(units, 1.0 / units), size=count).astype(np.float64)
    drawn.flags.writeable = False
    return drawn


def intervals(values: Floats, design: Design, comparisons: int | None = None) -> Intervals:
    """Mean over the units and a percentile interval, for several columns on the same resamples.

    Parameters
    ----------
    values : float64 (units, k)
        At least one unit.
    design : Design
        Its `resamples` and `seed`.
    comparisons : int, optional
        Each interval is at 1 - 0.05 / comparisons, so that all hold together at 0.95; default k.
    """
    units, columns = values.shape
    weights = resamples(units, design.resamples, design.seed)
    means = weights @ values / units
    tail = (1.0 - PROTOCOL.confidence) / (2 * (columns if comparisons is None else comparisons))
    lower, upper = np.quantile(means, [tail, 1.0 - tail], axis=0)
    return Intervals(values.mean(axis=0), lower, upper)
