"""The rule over all readings: supported, refuted, or dependent on the reading, and by which factor."""

from collections.abc import Mapping, Sequence
from typing import Any

from verification.experiments.measure.readings import FACTORS
from verification.experiments.measure.verdicts import HOLDS, INCONCLUSIVE, OUTCOMES, REFUTED

SUPPORTED = "supported"
SUPPORTING = 0.95
"""Share of readings in which a claim must hold, with none against it, to be called supported."""


def verdict(outcomes: Sequence[str]) -> str:
    """Supported, refuted or inconclusive, from the outcome of every reading."""
    holds, refuted = outcomes.count(HOLDS), outcomes.count(REFUTED)
    if holds >= SUPPORTING * len(outcomes) and not refuted:
        return SUPPORTED
    return REFUTED if 2 * refuted > len(outcomes) else INCONCLUSIVE


def survey(readings: Sequence[Mapping[str, Any]], part: str) -> dict[str, Any]:
    """Count the outcomes of a part of a claim, in all and for each level of each factor.

    Parameters
    ----------
    readings : sequence of mapping
        As the record has them: with "levels" and "claims".
    part : str
    """
    outcomes = [each["claims"][part]["outcome"] for each in readings]
    factors: dict[str, dict[str, list[int]]] = {}
    for factor, levels in FACTORS.items():
        factors[factor] = {}
        for level in levels:
            pairs = zip(readings, outcomes, strict=True)
            chosen = [outcome for each, outcome in pairs if each["levels"][factor] == level]
            factors[factor][level_name(level)] = [chosen.count(kind) for kind in OUTCOMES]
    counts = {kind: outcomes.count(kind) for kind in OUTCOMES}
    return {"verdict": verdict(outcomes), "readings": len(outcomes), "factors": factors} | counts


def level_name(level: Any) -> str:
    """A level as a key of the record."""
    return f"{level:g}" if isinstance(level, float) else str(level)
