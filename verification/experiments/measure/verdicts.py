"""The rule of one reading: a claim holds, is refuted, or is left open, by all of its comparisons together."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from verification.experiments.design import Design
from verification.experiments.measure.bootstrap import intervals

Floats = NDArray[np.float64]

HOLDS, REFUTED, INCONCLUSIVE = "holds", "refuted", "inconclusive"
OUTCOMES = (HOLDS, REFUTED, INCONCLUSIVE)
DIGITS = 9
"""Decimals to which a bound is compared: differences of scores are fractions that floats only approach."""


@dataclass(frozen=True, slots=True, eq=False)
class Comparisons:
    """What a claim says: every mean is above 0.

    Attributes
    ----------
    differences : mapping of str to float64 (units,)
        By the comparison's name; of the same units.
    smallest : float
        The smallest effect of interest: a gain below it is no gain.
    left_out : int
        Units for which the difference is not defined.
    """

    differences: Mapping[str, Floats]
    smallest: float
    left_out: int = 0


@dataclass(frozen=True, slots=True)
class Judgement:
    """What one reading says of a part of a claim, with the comparison that decides.

    Attributes
    ----------
    outcome : str
        One of `OUTCOMES`.
    statistic, lower, upper : float or None
        Mean and bounds of the comparison that decides; None without a single unit.
    comparison : str
    comparisons : int
    units : int
    left_out : int
    """

    outcome: str
    statistic: float | None
    lower: float | None
    upper: float | None
    comparison: str
    comparisons: int
    units: int
    left_out: int

    def as_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return {name: getattr(self, name) for name in self.__dataclass_fields__}


def judge(claim: Comparisons, design: Design) -> Judgement:
    """Judge a claim.

    Refuted if some comparison's upper bound lies below the smallest effect of interest; else it holds if
    every comparison's lower bound lies above 0; else it is left open. The comparison that decides is the one
    of the smallest upper bound where it is refuted, else the one of the smallest lower bound.

    Parameters
    ----------
    claim : Comparisons
    design : Design
    """
    names = list(claim.differences)
    values = np.stack(list(claim.differences.values()), axis=1)
    units = len(values)
    if units == 0:
        return Judgement(INCONCLUSIVE, None, None, None, names[0], len(names), 0, claim.left_out)
    found = intervals(values, design)
    lower, upper = found.lower.round(DIGITS), found.upper.round(DIGITS)
    if (upper < claim.smallest).any():
        outcome, k = REFUTED, int(upper.argmin())
    else:
        outcome, k = HOLDS if (lower > 0.0).all() else INCONCLUSIVE, int(lower.argmin())
    bounds = float(found.mean[k]), float(lower[k]), float(upper[k])
    return Judgement(outcome, *bounds, names[k], len(names), units, claim.left_out)
