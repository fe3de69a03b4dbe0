"""The generated files that are committed: which code made them, and whether it has changed since."""

import json
import re
from pathlib import Path
from statistics import median
from typing import Any

import pytest

from verification.commands.reports import STEPS
from verification.provenance import DECIDING, is_current

REPORTS = Path(__file__).parents[2] / "reports"
SUBJECTS = {
    "report.json": "report",
    "ci/report.json": "report",
    "faults.json": "faults",
    "campaign.json": "campaign",
    "bench-S-M.json": "benchmark",
    "bench-L.json": "benchmark",
    "bench-XL-P.json": "benchmark",
}
"""By file: the code that it depends on."""
DECODERS = frozenset({"opencv-python-headless", "pillow", "simplejpeg"})
"""What pictures are decoded by: the campaign reads none."""
WITHOUT_A_STEP = {"accuracy.json", "conformance.json", "reweighted.json"}
"""Files that no step makes anew: of photographs that are not here, and of other people's solvers."""


def content(name: str) -> dict[str, Any]:
    return dict(json.loads((REPORTS / name).read_text(encoding="utf-8")))


def stamp(name: str) -> dict[str, Any]:
    """What made a file; the versions of a report are among its settings."""
    data = content(name)
    return data.get("settings", {}) | dict(data.get("made") or data["volatile"]["made"])


def test_the_files_are_those_that_the_steps_write() -> None:
    """And every file that is there is looked at."""
    written = {file: step.subject for step in STEPS.values() for file in step.commands if step.subject}
    names = {path.relative_to(REPORTS).as_posix() for path in REPORTS.rglob("*.json")}
    there = {name for name in names if ".journal/" not in name}
    assert {file: subject for file, subject in written.items() if file in there} == SUBJECTS, there
    assert not {file for file in there if "counterexamples/" not in file} - set(SUBJECTS) - WITHOUT_A_STEP


@pytest.mark.parametrize("name", SUBJECTS)
def test_a_generated_file_names_the_commit_and_the_versions_that_made_it(name: str) -> None:
    made = stamp(name)
    assert re.fullmatch("[0-9a-f]{40}", made["commit"]), f"made from no clean clone: {made['commit']}"
    unread = DECODERS if SUBJECTS[name] == "campaign" else frozenset()
    assert set(DECIDING) - unread <= set(made["versions"]), made["versions"]


@pytest.mark.parametrize("name", SUBJECTS)
def test_the_code_behind_a_generated_file_is_the_present_one(name: str) -> None:
    """Documentation may change; `python -m verification reports` makes what is out of date."""
    assert is_current(content(name), SUBJECTS[name]), f"{name} was made by other code"


@pytest.mark.parametrize("name", ["report.json", "ci/report.json"])
def test_no_family_is_unreached_and_nothing_differs_from_the_baseline(name: str) -> None:
    outcome = content(name)["outcome"]
    assert outcome["code"] == 0, outcome


def test_the_documentation_tells_the_counts_of_the_campaign() -> None:
    data = content("campaign.json")
    assert not data["failures"]
    assert not data["contradictions"]
    text = (REPORTS.parent / "docs" / "solvers.md").read_text(encoding="utf-8").replace("\n", " ")
    told = text[text.index("A [campaign]") :]
    counts = [sum(each[name] for each in data["families"].values()) for name in ("total", "certified")]
    counts += [counts[0] - counts[1], sum(each["refereed"] for each in data["families"].values())]
    names = ("total", "optimal", "above_1e_8", "above_1e_3")
    counts += [sum(each[name] for each in data["clarabel"].values()) for name in names]
    for count in counts:
        assert f"{count:,} " in told, count


BESIDE = {"S": "cvxpy+clarabel, dpp", "M": "cvxpy+clarabel, dpp"}
"""What the third column of times is of, where enough objects were finished."""


@pytest.mark.parametrize("instance", ["S", "M", "L", "XL", "P"])
def test_the_documentation_tells_the_times_of_the_benchmark(instance: str) -> None:
    """To three digits, or fewer where the table has fewer."""
    (data,) = (each for each in map(content, SUBJECTS) if instance in each.get("peers", {}))
    text = (REPORTS.parent / "docs" / "solvers.md").read_text(encoding="utf-8")
    (row,) = re.findall(rf"^\| {instance}: [^|]*\|(.*)\|$", text, re.MULTILINE)
    ours, others, beside, recognition, floor = (re.findall(r"[\d.,]+", each) for each in row.split("|"))
    times = {
        each["peer"]: median(sample["seconds"] for sample in each["samples"])
        for each in data["peers"][instance]
        if len(each["samples"]) > len(data["lambdas"])
    }
    frame = data["frames"][instance]
    wanted = [times["ours"], min(frame["recognition"]), max(frame["recognition"]), frame["floor"]]
    told = [*ours, *recognition, *floor]
    if others[:1] != []:
        told += others[:1]
        wanted.append(min(time for name, time in times.items() if not name.startswith("ours")))
    if BESIDE.get(instance) in times:
        told += beside
        wanted.append(times[BESIDE[instance]])
    else:
        assert not beside, "it did not finish enough objects for a median"
    assert len(told) == len(wanted), row
    for number, seconds in zip(told, wanted, strict=True):
        digits = number.replace(",", "")
        step = 10.0 ** -len(digits.partition(".")[2]) if "." in digits else 10.0 ** zeros(digits)
        assert abs(float(digits) - 1e3 * seconds) <= 0.5001 * step, (number, 1e3 * seconds)


def zeros(digits: str) -> int:
    """How many zeros a whole number ends with, which rounding may have made."""
    return len(digits) - len(digits.rstrip("0"))
