"""The sensitivity analysis: how many configurations say what of a part of a claim, in all and by level."""

from collections.abc import Mapping, Sequence
from typing import Any

from verification.experiments.record.entries import Counts, Entry
from verification.experiments.record.verdicts import rule_of
from verification.ledger.claims import PROTOCOL
from verification.ledger.surveys import SurveyOutcome, Tally


def survey(entries: Sequence[Entry], part: str, factors: Mapping[str, Sequence[Any]]) -> Counts:
    """The record's counts of a part of a claim, with the verdict of the ledger's rule.

    Configurations count that are as the paper states, and in which some scene defines the statistic. Of a
    factor that the paper states, all levels are counted.
    """
    defined = [each for each in entries if each["claims"][part]["units"]]
    judged = _as_stated(defined)
    counts = _tally(judged, part)

    def with_level(factor: str, level: object) -> list[Entry]:
        counted = defined if factor in PROTOCOL.stated else judged
        return [each for each in counted if each["levels"][factor] == level]

    return {
        "verdict": PROTOCOL.verdict(counts, figure=rule_of(part).figure).value,
        "counts": list(counts),
        "undefined": len(_as_stated(entries)) - len(judged),
        "agreeing": sum(_agrees(each, part) for each in judged),
        "factors": {
            factor: {level_name(level): list(_tally(with_level(factor, level), part)) for level in levels}
            for factor, levels in factors.items()
        },
    }


def _tally(entries: Sequence[Entry], part: str) -> Tally:
    return Tally.of(SurveyOutcome(each["claims"][part]["outcome"]) for each in entries)


def _as_stated(entries: Sequence[Entry]) -> list[Entry]:
    """Those whose factors that the paper states have the level that it states."""
    chosen = PROTOCOL.stated.items()
    return [each for each in entries if all(each["levels"][name] == level for name, level in chosen)]


def _agrees(entry: Entry, part: str) -> bool:
    """Whether every mean is on the claim's side of 0, whatever its interval."""
    found = entry["claims"][part]
    return found["above"] == found["comparisons"]


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
