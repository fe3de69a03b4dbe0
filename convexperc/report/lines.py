"""One line of JSON for each moment of a stream."""

import json
import math
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from typing import Any

from convexperc.errors import InputError, check_type
from convexperc.files import check_json
from convexperc.recognition.calibration import Judgement
from convexperc.recognition.recognition import Ranked, Recognition
from convexperc.report.records import judgement_record, rules_record

SCHEMA = "convexperc/recognition-line/1"


def recognition_line(
    time: float,
    nanoseconds: int,
    times: Mapping[str, float],
    missing: Mapping[str, str],
    found: Recognition | None,
    judgement: Judgement | None = None,
) -> dict[str, Any]:
    """Return what is known at one moment as plain JSON values; a number is finite, or None.

    The keys are the same for every moment; those of a moment without any view have the value None, or hold
    nothing.

    Parameters
    ----------
    time : float
        Of the moment, in seconds.
    nanoseconds : int
        The same, exactly that of the time stamp where the source gives nanoseconds.
    times : mapping of str to float
        Each robot that has a view, and the time of it.
    missing : mapping of str to str
        Each other robot, and why it has none.
    found : Recognition or None
        From these views; None if there is none.
    judgement : Judgement, optional
        Of `found`, by a calibration.
    """
    check_type(found, (Recognition, type(None)), "found")
    check_type(judgement, (Judgement, type(None)), "judgement")
    for what, value in (("times", times), ("missing", missing)):
        check_type(value, Mapping, what)
    for each in (time, *times.values()):
        check_type(each, (int, float), "a time")
        if isinstance(each, int) and each.bit_length() > 1000:
            raise InputError("a time", value=each, must="must be a number of seconds that float64 holds")
    record: dict[str, Any] = {
        "schema": SCHEMA,
        "time": _finite(time),
        "nanoseconds": nanoseconds,
        "decision": None,
        "verdict": None,
        "label": None,
        "certified": None,
        "acceptance": None,
        "candidates": [],
        "best": None,
        "optimum": None,
        "runner_up": None,
        "margin": None,
        "explained": None,
        "views": {name: _finite(each) for name, each in times.items()},
        "missing": dict(missing),
        "ranked_views": [],
        "ranked_modalities": [],
        "rules": None,
        "reason": "no robot has a view",
        "warnings": [],
        "milliseconds": None,
    }
    return record if found is None else record | _recognised(found, judgement)


def line_text(record: Mapping[str, Any]) -> str:
    """Return one line of ASCII, without its end.

    Raises
    ------
    InputError
        It is no mapping of str to JSON values, or a number in it is not finite.
    """
    check_type(record, dict, "record")
    check_json(record, "record")
    return json.dumps(record, allow_nan=False, separators=(", ", ": "))


def _recognised(found: Recognition, judgement: Judgement | None) -> dict[str, Any]:
    best = found.template()
    record: dict[str, Any] = {
        "decision": found.decision.value,
        "verdict": found.statement,
        "label": found.label,
        "certified": found.certified,
        "candidates": list(found.candidates),
        "best": best.name,
        "optimum": _interval(best.interval),
        "runner_up": found.runner_up,
        "margin": None if found.margin is None else _interval(found.margin),
        "explained": _interval(found.explained),
        "ranked_views": _ranked(found.ranked_views()),
        "ranked_modalities": _ranked(found.ranked_modalities()),
        "rules": rules_record(found),
        "reason": found.reason,
        "warnings": list(found.warnings),
    }
    if judgement is not None:
        record["acceptance"] = judgement_record(judgement)
    return record


def _ranked(ranking: Iterable[Ranked]) -> list[dict[str, Any]]:
    return [asdict(each) | {"weight": _finite(each.weight)} for each in ranking]


def _interval(ends: tuple[float, float]) -> dict[str, float | None]:
    return {"lower": _finite(ends[0]), "upper": _finite(ends[1])}


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
