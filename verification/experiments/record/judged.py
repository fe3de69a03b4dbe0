"""What was measured under one configuration, judged and put into plain values."""

from typing import Any

from verification.experiments.measure.baselines import BASELINES
from verification.experiments.measure.configurations import Configuration
from verification.experiments.measure.measured import Measured
from verification.experiments.measure.numbers import rounded
from verification.experiments.record.claims import CLAIMS
from verification.experiments.record.detail import detail
from verification.experiments.record.entries import Entry
from verification.experiments.record.limits import limits
from verification.experiments.record.verdicts import entry, judge, rule_of


def judged(measured: Measured, configuration: Configuration) -> dict[str, Any]:
    """Judge every claim.

    Returns
    -------
    dict
        Plain JSON values: "reading" as the record has it, "limits", and "default" for the default one.
    """
    found = {"reading": recorded(measured, configuration), "limits": limits(measured)}
    return found if measured.explained is None else found | {"default": detail(measured)}


def recorded(measured: Measured, configuration: Configuration) -> Entry:
    """The record's entry of one configuration."""
    found = {part: judge(claim(measured), rule_of(part), measured.design) for part, claim in CLAIMS.items()}
    settings = measured.trials.settings
    return {
        "id": configuration.id,
        "levels": configuration.as_json(),
        "claims": {part: entry(each, rule_of(part)) for part, each in found.items()},
        "accuracy": rounded(settings.scores.mean(axis=(0, 3))),
        "open": rounded(settings.open.mean(axis=(0, 3))),
        "baselines": dict(zip(BASELINES, rounded(measured.baselines.mean(axis=(0, 3))), strict=True)),
        "grid": rounded(measured.cells.mean(axis=0)),
        "chance": rounded(1.0 / len(measured.layout.objects)),
    }
