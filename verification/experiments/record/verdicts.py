"""What one configuration says of a part of a claim, by the ledger's rule for all comparisons together."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from convexperc.errors import InputError
from verification.experiments.design import Design
from verification.experiments.measure.numbers import rounded
from verification.experiments.record.bootstrap import objects, resampled
from verification.experiments.record.entries import Decided
from verification.experiments.scenes.pictures import Scene
from verification.ledger.claims import PARTS
from verification.ledger.rules import Bounds, Rule
from verification.ledger.surveys import Comparison, SurveyOutcome

Floats = NDArray[np.float64]

DIGITS = 9
"""Decimals to which a bound is compared: differences of scores are fractions that floats only approach."""


@dataclass(frozen=True, slots=True, eq=False)
class Comparisons:
    """What a claim says: every mean is above 0.

    Attributes
    ----------
    differences : mapping of str to float64 (units,)
        By the comparison's name.
    scenes : sequence of Scene
        That of each unit.
    left_out : int
        Scenes for which the difference is not defined.
    scored : bool
        Whether the values are scores, or differences of scores.
    """

    differences: Mapping[str, Floats]
    scenes: Sequence[Scene]
    left_out: int = 0
    scored: bool = False


def rule_of(part: str) -> Rule:
    """Find the rule of a part of a claim.

    Raises
    ------
    InputError
        The ledger has none.
    """
    rules = {key: each.rule for key, each in PARTS.items() if each.rule is not None}
    if part not in rules:
        must = f"must be a part of the ledger with a rule: {', '.join(rules)}"
        raise InputError("part of a claim", value=part, must=must)
    return rules[part]


def judge(claim: Comparisons, rule: Rule, design: Design) -> Comparison:
    """Find the comparison that decides, and what it says; without numbers where there are no two objects.

    Parameters
    ----------
    claim : Comparisons
    rule : Rule
        Of the part of the claim.
    design : Design

    Raises
    ------
    ValueError
        The rule fixes another number of comparisons, or units and scenes differ in number.
    """
    names = list(claim.differences)
    if len(names) != rule.comparisons:
        raise ValueError(f"{len(names)} comparisons, the ledger fixes {rule.comparisons}")
    values = np.stack(list(claim.differences.values()), axis=1)
    units = len(values)
    if units != len(claim.scenes):
        raise ValueError(f"{units} units of {len(claim.scenes)} scenes")
    if len(objects(claim.scenes)) < 2:
        return Comparison(SurveyOutcome.OPEN, None, None, None, names[0], 0, units, claim.left_out)
    found = resampled(values, claim.scenes, design, scored=claim.scored)
    ends = ([end.round(DIGITS) for end in found.intervals(count)[1:]] for count in (1, rule.comparisons))
    k, ((lower,), (upper,)) = rule.decide(*(Bounds(*map(rounded, each)) for each in ends))
    above = int((found.mean.round(DIGITS) > 0.0).sum())
    outcome = rule.outcome(lower, upper)
    return Comparison(outcome, float(found.mean[k]), lower, upper, names[k], above, units, claim.left_out)


def entry(found: Comparison, rule: Rule) -> Decided:
    """The record's entry of a comparison that decides."""
    return {
        "outcome": SurveyOutcome(found.outcome),
        "statistic": rounded(found.statistic),
        "lower": found.lower,
        "upper": found.upper,
        "comparison": found.name,
        "comparisons": rule.comparisons,
        "above": found.above,
        "units": found.units,
        "left_out": found.left_out,
    }


def from_entry(data: Decided) -> Comparison:
    """Read back what `entry` wrote."""
    bounds = data["statistic"], data["lower"], data["upper"]
    counts = data["above"], data["units"], data["left_out"]
    return Comparison(data["outcome"], *bounds, data["comparison"], *counts)
