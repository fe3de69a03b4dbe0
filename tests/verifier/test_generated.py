"""The generated files that are committed: which code made them, and whether it has changed since."""

import json
import re
from pathlib import Path
from typing import Any

import pytest

from verification.commands.reports import STEPS
from verification.provenance import DECIDING, is_current

REPORTS = Path(__file__).parents[2] / "reports"
SUBJECTS = {
    "report.json": "report",
    "faults.json": "faults",
}
"""By file: the code that it depends on."""


def content(name: str) -> dict[str, Any]:
    return dict(json.loads((REPORTS / name).read_text(encoding="utf-8")))


def stamp(name: str) -> dict[str, Any]:
    """What made a file; the versions of a report are among its settings."""
    data = content(name)
    return data.get("settings", {}) | dict(data.get("made") or data["volatile"]["made"])


def test_the_files_are_those_that_the_steps_write() -> None:
    written = {step.file: step.subject for step in STEPS.values()}
    assert SUBJECTS.items() <= written.items(), written


@pytest.mark.parametrize("name", SUBJECTS)
def test_a_generated_file_names_the_commit_and_the_versions_that_made_it(name: str) -> None:
    made = stamp(name)
    assert re.fullmatch("[0-9a-f]{40}", made["commit"]), f"made from no clean clone: {made['commit']}"
    assert set(DECIDING) <= set(made["versions"]), made["versions"]


@pytest.mark.parametrize("name", SUBJECTS)
def test_the_code_behind_a_generated_file_is_the_present_one(name: str) -> None:
    """Documentation may change; `python -m verification reports` makes what is out of date."""
    assert is_current(content(name), SUBJECTS[name]), f"{name} was made by other code"


@pytest.mark.parametrize("name", ["report.json"])
def test_no_family_is_unreached_and_nothing_differs_from_the_baseline(name: str) -> None:
    outcome = content(name)["outcome"]
    assert outcome["code"] == 0, outcome
