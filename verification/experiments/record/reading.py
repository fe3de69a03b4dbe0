"""A record of the experiments, read back: whole, of the ledger's parts, and judged by the ledger's rules.

`python -m verification experiments` writes it as experiments.json. Nothing of it is measured here; whatever
the verdicts rest on is counted again.
"""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from convexperc.errors import FileFormatError
from verification.experiments.measure.configurations import fraction
from verification.experiments.record.contact_sheets import read_sheets
from verification.experiments.record.contents import PHOTOGRAPHS, ExperimentsData, SetData
from verification.experiments.record.entries import Decided, Entry
from verification.experiments.record.record import FORMAT
from verification.experiments.record.sensitivity import survey
from verification.experiments.record.verdicts import from_entry, rule_of
from verification.ledger.claims import PROTOCOL
from verification.ledger.rules import Rule
from verification.ledger.surveys import COMMAND, DECIDING, Survey, SurveyOutcome, Tally
from verification.provenance import record_digest

PACKAGED = Path(__file__).with_name("record.json")
"""The record that comes with the verifier."""
SHEETS = "sheets"
"""Folder beside a record."""
SETS = (DECIDING, PHOTOGRAPHS)


@dataclass(frozen=True, slots=True)
class Experiments:
    """What a record says.

    Attributes
    ----------
    content : mapping
        The record without what may differ between two runs of one seed.
    surveys : tuple of Survey
        By set and part.
    command : str
        What makes it again.
    sheets : mapping of str to bytes
        Contact sheets, JPEG by name; see `verification.experiments.record.contact_sheets`.
    """

    content: Mapping[str, Any]
    surveys: tuple[Survey, ...]
    command: str
    sheets: Mapping[str, bytes] = field(default_factory=dict)

    @property
    def digest(self) -> str:
        """SHA-256 of the content."""
        return str(self.content["digest"])


def read_experiments(path: Path, with_sheets: bool = True) -> Experiments:
    """Read a record and check all that a verdict rests on.

    Parameters
    ----------
    path : Path
    with_sheets : bool
        Also read the contact sheets beside it, if there are some.

    Raises
    ------
    FileFormatError
        It cannot be read, was changed after it was written, follows other rules than the ledger's, or its
        verdicts do not follow from its configurations; or the sheets beside it belong to another record.
    """
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except OSError as problem:
        raise FileFormatError(path.name, value=problem.strerror, must="must be readable") from None
    except ValueError as problem:
        raise FileFormatError(path.name, value=str(problem), must="must be JSON in UTF-8") from None
    try:
        found = checked(data, path.name)
        sheets = read_sheets(path.parent / SHEETS, found.digest) if with_sheets else {}
        return replace(found, sheets=sheets)
    except (KeyError, TypeError, ValueError, IndexError, AttributeError) as problem:
        if isinstance(problem, FileFormatError):
            raise
        told = f"{type(problem).__name__}: {problem}"
        must = "must be a record of the experiments"
        raise FileFormatError(path.name, value=told, must=must, remedy=f"Make it by `{COMMAND}`.") from None


def packaged() -> Experiments | None:
    """The record that comes with the verifier; None if it comes without."""
    return read_experiments(PACKAGED) if PACKAGED.is_file() else None


def checked(data: ExperimentsData, name: str) -> Experiments:
    """Check a record that was read from a file of this name; see `read_experiments`."""
    _equal(f"format of {name}", data["format"], FORMAT, f"Make the record anew by `{COMMAND}`.")
    remedy = f"The file was changed after it was written: make it again by `{COMMAND}`."
    _equal(f"digest of {name}", data["digest"], record_digest(data), remedy)
    for key in ("resamples", "confidence"):
        _equal(f"{key} of {name}", data["design"][key], getattr(PROTOCOL, key), "The ledger fixes it.")
    names = [each["name"] for each in data["sets"]]
    if not names or len(set(names)) < len(names) or set(names) - set(SETS):
        raise FileFormatError(
            f"sets of {name}", value=names, must=f"must be among {', '.join(SETS)}, once each"
        )
    command = _command(data)
    surveys = tuple(survey for each in data["sets"] for survey in _surveys(each, data, command))
    content = {key: value for key, value in data.items() if key != "volatile"}
    return Experiments(content, surveys, command)


def _command(data: ExperimentsData) -> str:
    """What makes the record again, as far as it does not depend on places of files."""
    words = [COMMAND]
    if data["design"]["seed"]:
        words.append(f"--seed {data['design']['seed']}")
    fewest = min(len(each["readings"]) for each in data["sets"])
    if fewest < len(fraction()):
        words.append(f"--configurations {fewest}")
    if any(each["name"] != DECIDING for each in data["sets"]):
        words.append("--photos DIR")
    return " ".join(words)


def _surveys(pictures: SetData, data: ExperimentsData, command: str) -> Iterator[Survey]:
    """Count each part again, and see that the record's own counts and verdicts are the same."""
    factors, entries = data["design"]["factors"], pictures["readings"]
    default = _default(pictures, factors)
    for part, told in pictures["claims"].items():
        where = f"{part} on {pictures['name']}"
        for each in entries:
            _check(each["claims"][part], rule_of(part), where)
        counted = survey(entries, part, factors)
        stored, numbers = ([each["counts"], each["undefined"], each["agreeing"]] for each in (told, counted))
        _equal(f"counts of {where}", stored, numbers, RECOUNT)
        _equal(f"counts by level of {where}", told["factors"], counted["factors"], RECOUNT)
        _equal(f"verdict of {where}", told["verdict"], counted["verdict"], RECOUNT)
        levels = {
            factor: {level: Tally(*counts) for level, counts in by_level.items()}
            for factor, by_level in counted["factors"].items()
        }
        yield Survey(
            part, pictures["name"], Tally(*counted["counts"]), counted["undefined"], counted["agreeing"],
            from_entry(default["claims"][part]), levels, data["digest"], pictures["digest"], command,
        )  # fmt: skip


RECOUNT = "The record must follow from its own configurations by the rules of the ledger: make it again."


def _default(pictures: SetData, factors: Mapping[str, list[Any]]) -> Entry:
    """The library's own configuration: the first level of each factor."""
    first = {name: levels[0] for name, levels in factors.items()}
    found = [each for each in pictures["readings"] if each["levels"] == first]
    ids = [each["id"] for each in pictures["readings"]]
    if len(found) != 1 or len(set(ids)) < len(ids):
        must = "must be there once, with the first level of each factor, and every id once"
        raise FileFormatError(f"default configuration of {pictures['name']}", value=len(found), must=must)
    for each in pictures["readings"]:
        if set(each["claims"]) != set(pictures["claims"]):
            odd = sorted(set(each["claims"]) ^ set(pictures["claims"]))
            must = "must judge the parts that the set judges"
            raise FileFormatError(f"configuration {each['id']} of {pictures['name']}", value=odd, must=must)
    return found[0]


def _check(found: Decided, rule: Rule, where: str) -> None:
    """The outcome of a configuration must follow from its deciding comparison."""
    _equal(f"comparisons of {where}", found["comparisons"], rule.comparisons, "The ledger fixes it.")
    outcome = SurveyOutcome(found["outcome"])
    if not 0 <= found["above"] <= found["comparisons"]:
        raise FileFormatError(f"above of {where}", value=found["above"], must="must be at most comparisons")
    lower, upper = found["lower"], found["upper"]
    if lower is None and upper is None:
        _equal(f"outcome of {where} without bounds", outcome, SurveyOutcome.OPEN, RECOUNT)
        return
    if lower is None or upper is None or not lower <= upper:
        raise FileFormatError(
            f"bounds of {where}", value=(lower, upper), must="must be numbers", remedy=RECOUNT
        )
    expected = rule.outcome(lower, upper)
    if outcome is not expected:
        told = f"{outcome} at [{lower:g}, {upper:g}]"
        must = f"must follow from its bounds: {expected}"
        raise FileFormatError(f"outcome of {where}", value=told, must=must, remedy=RECOUNT)


def _equal(name: str, value: object, expected: object, remedy: str) -> None:
    if value != expected:
        raise FileFormatError(name, value=value, must=f"must be {expected!r}", remedy=remedy)
