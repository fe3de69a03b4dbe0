"""What differs between two reports: verdicts, counts, counterexamples, settings."""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from convexperc.errors import FileFormatError
from verification.provenance import record_digest
from verification.report.contents import SCHEMA

Record = Mapping[str, Any]
OUTCOMES = ("held", "failed", "undecided", "skipped")
ABSENT = "absent"


@dataclass(frozen=True)
class Difference:
    """What differs, a line each.

    Attributes
    ----------
    verdicts : tuple of str
        Claims and parts whose verdict differs.
    counts : tuple of str
        Parts whose numbers of cases differ.
    counterexamples : tuple of str
        Those that one report has confirmed and the other has not.
    settings : tuple of str
    """

    verdicts: tuple[str, ...]
    counts: tuple[str, ...]
    counterexamples: tuple[str, ...]
    settings: tuple[str, ...]

    @property
    def code(self) -> int:
        """Exit code: 0 if all verdicts are equal, else 1."""
        return 1 if self.verdicts else 0

    @property
    def text(self) -> str:
        """All of it, under headings, for a terminal."""
        named = {
            "Verdicts": self.verdicts,
            "Counterexamples": self.counterexamples,
            "Counts": self.counts,
            "Settings": self.settings,
        }
        blocks = [[f"{title}:", *(f"  {line}" for line in lines)] for title, lines in named.items() if lines]
        if not self.verdicts:
            blocks.insert(0, ["All verdicts are equal."])
        return "\n".join(line for block in blocks for line in block)


def read_report(path: Path) -> dict[str, Any]:
    """Read a report.json and check that it is whole.

    Raises
    ------
    FileFormatError
        It cannot be read, is no report of this schema, or was changed after it was written.
    """
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except OSError as problem:
        raise FileFormatError(path.name, value=problem.strerror, must="must be readable") from None
    except ValueError as problem:
        raise FileFormatError(path.name, value=str(problem), must="must be JSON in UTF-8") from None
    schema = data.get("schema") if isinstance(data, dict) else type(data).__name__
    if schema != SCHEMA:
        remedy = "Name the report.json of a report; one of an older schema is to be made again."
        raise FileFormatError(
            f"schema of {path.name}", value=schema, must=f"must be {SCHEMA!r}", remedy=remedy
        )
    if data.get("digest") != (found := record_digest(data)):
        remedy = "The file was changed after it was written: make the report again."
        raise FileFormatError(
            f"digest of {path.name}", value=data.get("digest"), must=f"must be {found}", remedy=remedy
        )
    return dict(data)


def diff(before: Record, after: Record) -> Difference:
    """Compare two reports, as `read_report` gives them.

    Returns
    -------
    Difference
    """
    old, new = _parts(before), _parts(after)
    keys = dict.fromkeys([*old, *new])
    return Difference(
        tuple(_changed(_verdicts(before), _verdicts(after))),
        tuple(line for key in keys for line in _counts(key, old.get(key), new.get(key))),
        tuple(line for key in keys for line in _examples(key, old.get(key), new.get(key))),
        tuple(_changed(_flat(before["settings"]), _flat(after["settings"]))),
    )


def _parts(record: Record) -> dict[str, Record]:
    return {part["key"]: part for claim in record["claims"] for part in claim["parts"]}


def _verdicts(record: Record) -> dict[str, str]:
    claims = {claim["id"]: claim["verdict"] for claim in record["claims"]}
    return claims | {key: part["verdict"] for key, part in _parts(record).items()}


def _counts(key: str, old: Record | None, new: Record | None) -> Iterator[str]:
    before = dict.fromkeys(OUTCOMES, 0) if old is None else old["cases"]
    after = dict.fromkeys(OUTCOMES, 0) if new is None else new["cases"]
    told = [f"{name} {before[name]:,} -> {after[name]:,}" for name in OUTCOMES if before[name] != after[name]]
    if told:
        yield f"{key}: {', '.join(told)}"


def _examples(key: str, old: Record | None, new: Record | None) -> Iterator[str]:
    before, after = _confirmed(old), _confirmed(new)
    yield from (f"{key}: {name} appeared" for name in after if name not in before)
    yield from (f"{key}: {name} disappeared" for name in before if name not in after)


def _confirmed(part: Record | None) -> list[str]:
    return [] if part is None else [each["id"] for each in part["counterexamples"] if each["confirmed"]]


def _changed(before: Mapping[str, Any], after: Mapping[str, Any]) -> Iterator[str]:
    for key in dict.fromkeys([*before, *after]):
        old, new = before.get(key, ABSENT), after.get(key, ABSENT)
        if old != new:
            yield f"{key}: {old} -> {new}"


def _flat(values: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    flat: dict[str, Any] = {}
    for name, value in values.items():
        flat |= _flat(value, f"{prefix}{name}.") if isinstance(value, Mapping) else {f"{prefix}{name}": value}
    return flat
