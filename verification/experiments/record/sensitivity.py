"""The sensitivity analysis: how many configurations say what of a part of a claim, in all and by level."""

from collections.abc import Mapping, Sequence
from typing import Any

from verification.experiments.record.entries import Counts, Entry
from verification.experiments.record.verdicts import rule_of
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
    counts, rule = Tally.of(outcomes), rule_of(part)
    by_level = tallies(entries, outcomes, factors)
    return {
        "verdict": PROTOCOL.verdict(counts, figure=rule.figure).value,
        "counts": list(counts),
        "agreeing": agreeing(entries, part),
        "factors": {name: {level: list(n) for level, n in each.items()} for name, each in by_level.items()},
    }


def agreeing(entries: Sequence[Entry], part: str) -> int:
    """In how many configurations every mean is on the claim's side of 0, whatever its interval."""
    decided = (each["claims"][part] for each in entries)
    return sum(each["above"] == each["comparisons"] for each in decided)


def vacuous(entry: Entry) -> bool:
    """Whether no lambda makes a difference: equal accuracies of the settings from n = 2 on, and on the grid.

    Where the grid goes from 0 to 10 and nothing changes, the lambdas are not of the scale of the data.
    """
    rows = [row[1:] for row in entry["accuracy"]]
    cells = {cell for row in entry["grid"] for cell in row}
    return len(cells) == 1 and all(row == rows[0] for row in rows)


def level_name(level: object) -> str:
    """A level as a key of the record."""
    return f"{level:g}" if isinstance(level, (int, float)) else str(level)
