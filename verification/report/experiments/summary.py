"""What the report shows of a record of the experiments: the default configuration, and counts of all."""

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np
from jaxtyping import Float

from verification.experiments.design import NOTHING
from verification.experiments.record.reading import Experiments
from verification.ledger.claims import PARTS, PROTOCOL
from verification.ledger.surveys import DECIDING, Survey
from verification.report.contents import SurveyCounts

QUANTILES = (0.0, 0.05, 0.5, 0.95, 1.0)
"""Of the accuracy over the configurations; the ends, nine tenths of them, and the middle."""
FINEST = 150
"""Strokes of the drawing of u within one modality; more columns share strokes."""
KEPT = (
    "name",
    "digest",
    "source",
    "objects",
    "scenes",
    "views",
    "levels",
    "case_study",
    "limits",
    "rankings",
)


def summary(found: Experiments) -> dict[str, Any]:
    """Plain data that tables and figures are made of.

    Raises
    ------
    KeyError, ValueError
        The record lacks something.
    """
    return {
        "record": found.digest,
        "command": found.command,
        "design": found.content["design"],
        "sets": [_set(each, found) for each in in_order(found.content["sets"])],
    }


def in_order(sets: list[Mapping[str, Any]]) -> list[Mapping[str, Any]]:
    """The set that decides first."""
    return sorted(sets, key=lambda each: each["name"] != DECIDING)


def _set(pictures: Mapping[str, Any], found: Experiments) -> dict[str, Any]:
    own = {each.part: each for each in found.surveys if each.pictures == pictures["name"]}
    claims = {
        key: asdict(SurveyCounts.of(own[key])) | {"levels": own[key].levels, "spread": _spread(own[key])}
        for key in PARTS
        if key in own
    }
    default = dict(pictures["default"])
    default["case"] = _case(default["case"])
    accuracy = np.array([each["accuracy"] for each in pictures["readings"]], dtype=np.float64)
    nothing = found.content["design"]["settings"].index(list(NOTHING))
    return {key: pictures[key] for key in KEPT if key in pictures} | {
        "readings": len(pictures["readings"]),
        "chance": pictures["readings"][0]["chance"],
        "claims": claims,
        "default": default,
        "spread": _quantiles(accuracy),
        "gain": _quantiles(accuracy - accuracy[:, [nothing]]),
        "best": first_places(accuracy),
    }


def _quantiles(values: Float[np.ndarray, "readings settings counts"]) -> list[Any]:
    """By setting and n: the quantiles over the configurations."""
    found = np.quantile(values, QUANTILES, axis=0)
    return [[[_short(each) for each in cell] for cell in row] for row in np.moveaxis(found, 0, -1).tolist()]


def first_places(accuracy: Float[np.ndarray, "readings settings counts"]) -> list[int]:
    """In how many configurations each setting has the highest mean over n; a tie counts for none.

    Means of shares are fractions that floats only approach: they are compared to nine decimals.
    """
    means = accuracy.mean(axis=2).round(9)
    first = means == means.max(axis=1, keepdims=True)
    return [int(count) for count in first[first.sum(axis=1) == 1].sum(axis=0)]


def _spread(survey: Survey) -> str:
    """The factor whose levels differ most in the share that reproduces the part."""
    found = PROTOCOL.widest(survey.levels)
    if found is None or not found.size:
        return "no level differs"
    return f"{PROTOCOL.factors.get(found.factor, found.factor)}: {found.told}"


def _case(case: Mapping[str, Any]) -> dict[str, Any]:
    """The case with u cut into modalities, as the lowest and highest entry of each stroke."""
    kept = {key: value for key, value in case.items() if key != "u"}
    if "u" not in case:
        return kept
    u, strokes, start = np.array(case["u"], dtype=np.float64), {}, 0
    if u.size != sum(case["modality_sizes"].values()):
        raise ValueError(f"u has {u.size} entries, its modalities {case['modality_sizes']}")
    for name, size in case["modality_sizes"].items():
        step = -(-size // FINEST)
        groups = [u[start + at : start + min(at + step, size)] for at in range(0, size, step)]
        ends = [[_short(float(group.min())), _short(float(group.max()))] for group in groups]
        strokes[name] = {"columns": step, "ends": ends}
        start += size
    return kept | {"u": strokes}


def _short(value: float) -> float:
    return float(f"{value:.4g}")
