"""All configurations together: how many say what of a part of a claim, in all and by level of each factor."""

from collections.abc import Mapping, Sequence
from typing import Any

from verification.experiments.record.entries import Counts, Entry
from verification.ledger.claims import PROTOCOL
from verification.ledger.surveys import SurveyOutcome, Tally

Tallies = dict[str, dict[str, Tally]]
"""By factor and level."""


def tallies(
    entries: Sequence[Entry],
    outcomes: Sequence[SurveyOutcome],
    factors: Mapping[str, Sequence[Any]],
) -> Tallies:
    """Count outcomes by level.

    Parameters
    ----------
    entries : sequence of mapping
        Configurations as the record has them: with "levels".
    outcomes : sequence of SurveyOutcome
        One of each.
    factors : mapping of str to sequence
        Levels by factor.
    """
    return {
        factor: {
            level_name(level): Tally.of(
                outcome
                for each, outcome in zip(entries, outcomes, strict=True)
                if each["levels"][factor] == level
            )
            for level in levels
        }
        for factor, levels in factors.items()
    }


def survey(entries: Sequence[Entry], part: str, factors: Mapping[str, Sequence[Any]]) -> Counts:
    """The record's counts of a part of a claim, with the verdict of the ledger's rule."""
    outcomes = [SurveyOutcome(each["claims"][part]["outcome"]) for each in entries]
    counts = Tally.of(outcomes)
    by_level = tallies(entries, outcomes, factors)
    return {
        "verdict": PROTOCOL.verdict(counts).value,
        "readings": counts.total,
        "factors": {name: {level: list(n) for level, n in each.items()} for name, each in by_level.items()},
        "holds": counts.holds,
        "refuted": counts.refuted,
        "inconclusive": counts.inconclusive,
    }


def level_name(level: object) -> str:
    """A level as a key of the record."""
    return f"{level:g}" if isinstance(level, (int, float)) else str(level)
