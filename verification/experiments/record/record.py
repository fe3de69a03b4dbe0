"""The record of a run: what was tried, every configuration, the counts over all, and a digest of it all."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, cast

from convexperc.files import json_bytes, write_atomic
from verification.experiments.design import Design
from verification.experiments.measure.configurations import FACTORS
from verification.experiments.record.claims import CLAIMS
from verification.experiments.record.collection import Collection
from verification.experiments.record.contents import ExperimentsData, Plan, SetData
from verification.experiments.record.entries import Entry, Ranking
from verification.experiments.record.limits import summary
from verification.experiments.record.sensitivity import survey
from verification.provenance import machine, record_digest, versions

FORMAT: Literal[2] = 2
NAME = "experiments.json"
SCHEMA = Path(__file__).with_name("record.schema.json")


def record(
    collections: Sequence[Collection],
    judged: Mapping[str, Sequence[Mapping[str, Any]]],
    ranked: Mapping[str, list[Ranking]],
    design: Design,
    volatile: Mapping[str, Any],
) -> ExperimentsData:
    """Join everything.

    Parameters
    ----------
    collections : sequence of Collection
    judged : mapping of str to sequence of mapping
        By the collection's name: what `judged` gave for each configuration, the default first.
    ranked : mapping of str to sequence of mapping
        By the collection's name: its `rankings`.
    design : Design
    volatile : mapping
        What may differ between two runs of the same seed; it is not part of the digest.
    """
    factors = {name: list(levels) for name, levels in FACTORS.items()}
    found: ExperimentsData = {
        "format": FORMAT,
        "design": cast("Plan", design.as_json() | {"factors": factors}),
        "sets": [_set(each, judged[each.name], ranked[each.name]) for each in collections],
        "digest": "",
        "volatile": dict(volatile) | {"environment": {"machine": machine(), "versions": versions()}},
    }
    return {**found, "digest": record_digest(found)}


def write_record(folder: Path, data: Mapping[str, Any]) -> Path:
    """Write ``experiments.json`` into a folder that is there; keys are sorted."""
    place = folder / NAME
    write_atomic(place, json_bytes(_sorted(data)))
    return place


def _set(collection: Collection, judged: Sequence[Mapping[str, Any]], ranked: list[Ranking]) -> SetData:
    entries: list[Entry] = [each["reading"] for each in judged]
    return {
        **collection.as_json(),
        "claims": {part: survey(entries, part, FACTORS) for part in CLAIMS},
        "readings": entries,
        "default": judged[0]["default"],
        "rankings": ranked,
        "limits": summary(entries, [each["limits"] for each in judged]),
    }


def _sorted(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {name: _sorted(value[name]) for name in sorted(value)}
    return [_sorted(each) for each in value] if isinstance(value, list) else value
