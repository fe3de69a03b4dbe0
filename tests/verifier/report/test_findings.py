"""Whatever a run finds is told by the terminal and by every file of the report: a finding of each kind."""

import html
import json
import re
from dataclasses import dataclass, field
from typing import Any
from xml.etree import ElementTree

import pytest
from made_up import SETTINGS, evidence, refutation, verdicts
from typer.testing import CliRunner

from convexperc.files import write_json
from verification.__main__ import app
from verification.ledger.evidence import Count, Evidence
from verification.problems.families import FAMILIES
from verification.run.stages import Run

CLAIMS = ("F2", "D1", "B2", "B4")
CASES = 250 * len(FAMILIES)
"""Of one part in the made-up evidence."""
BASE: Evidence = evidence(
    settings=SETTINGS | {"claims": list(CLAIMS)},
    counts=[count for count in evidence().counts if count.part.startswith(CLAIMS)],
    series={},
    surveys=[],
)
SKIPPED = sum(at % 3 for at in range(len(FAMILIES)))
FAILED = f"{CASES + 2 + SKIPPED:,} cases: {CASES:,} held, 2 failed and {SKIPPED} skipped."


@dataclass(frozen=True)
class Finding:
    """A planted finding and what must be told of it."""

    changes: dict[str, Any]
    code: int
    message: str
    junit: str
    part: str
    evidence: tuple[str, ...] = ()
    reason: str = ""
    cases: dict[str, int] = field(default_factory=dict)


def failing(part: str) -> dict[str, Any]:
    return {"counts": [*BASE.counts, Count(part, "random", failed=2)]}


def refuted(part: str, confirmed: bool, name: str) -> dict[str, Any]:
    return {"refutations": [*BASE.refutations, refutation(part, confirmed, name)]}


FINDINGS = {
    "a failed promise": Finding(
        failing("B2/true"),
        1,
        f"B2/true: 2 of {CASES + 2:,} cases failed",
        "no promise of the library fails",
        "B2/true",
        (FAILED,),
        f"2 failures in {CASES + 2:,} cases, none confirmed exactly",
        {"failed": 2},
    ),
    "a refuted promise": Finding(
        refuted("B4/tie", True, "found-tie"),
        1,
        "B4/tie: 1 > 0",
        "no promise of the library fails",
        "B4/tie",
        ("Counterexample found-tie", "1 > 0", "python -m verification replay found-tie"),
        "counterexample found-tie: 1 > 0",
    ),
    "a changed verdict": Finding(
        failing("F2/conic") | refuted("F2/conic", True, "found-conic"),
        1,
        "F2/conic: refuted, the baseline says supported",
        "every verdict is the baseline's",
        "F2/conic",
        (FAILED, "Counterexample found-conic", "1 > 0", "python -m verification replay found-conic"),
        "counterexample found-conic: 1 > 0",
        {"failed": 2},
    ),
    "a stale record": Finding(
        refuted("D1/corrected", False, "old"),
        1,
        "D1/corrected: record old no longer fails",
        "every stored counterexample still fails",
        "D1/corrected",
        ("Stale record, counts as nothing", "old"),
    ),
    "something missing": Finding(
        {"missing": ["conic was not tried on one view"]},
        3,
        "missing: conic was not tried on one view",
        "nothing that is required is missing or open",
        "F2/conic",
    ),
    "a part that was not run": Finding(
        {"counts": [count for count in BASE.counts if count.part != "F2/conic"]},
        3,
        "F2/conic: inconclusive, the baseline says supported",
        "nothing that is required is missing or open",
        "F2/conic",
        ("No cases were drawn for it.",),
        "no case was decided and no argument passed",
        {"held": 0},
    ),
}


@dataclass(frozen=True)
class Told:
    """What a report says of a finding, as plain text."""

    code: int
    terminal: str
    page: str
    markdown: str
    json: dict[str, Any]
    junit: ElementTree.Element


def words_of(text: str) -> str:
    """In lower case, without signs that mark in Markdown, and without line ends."""
    return " ".join(re.sub(r"[\\`*]", "", html.unescape(text)).split()).lower()


def words_on(page: str) -> str:
    """The same of HTML, without tags."""
    return words_of(re.sub(r"<[^>]*>", "", page))


@pytest.fixture(scope="module", params=FINDINGS)
def found(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[Finding, Told]:
    """A finding, and all that `report` tells of it."""
    finding, folder = FINDINGS[request.param], tmp_path_factory.mktemp("report")
    kept = Run(Evidence(**vars(BASE) | finding.changes))
    write_json(folder / "kept.json", json.loads(json.dumps(kept.as_json())))
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr("verification.ledger.baseline.read_baseline", lambda: verdicts(BASE))
        runner = CliRunner(env={"COLUMNS": "200", "TERM": "dumb", "NO_COLOR": "1"})
        result = runner.invoke(app, ["report", "--evidence", str(folder / "kept.json"), "--out", str(folder)])
    page, text = ((folder / name).read_text(encoding="utf-8") for name in ("report.html", "report.md"))
    data = json.loads((folder / "report.json").read_text(encoding="utf-8"))
    root = ElementTree.fromstring((folder / "junit.xml").read_bytes())
    return finding, Told(result.exit_code, result.stdout, page, text, data, root)


def test_the_message_is_told_by_the_exit_code_and_the_terminal(found: tuple[Finding, Told]) -> None:
    finding, told = found
    assert told.code == finding.code, told.terminal
    assert finding.message in told.terminal.splitlines(), told.terminal


def test_the_message_stands_at_the_top_of_the_page_and_of_the_text(found: tuple[Finding, Told]) -> None:
    finding, told = found
    on_page = words_on(told.page.partition('<div class="first">')[0])
    for top in (on_page, words_of(told.markdown.partition("\n## ")[0])):
        assert finding.message.lower() in top, top
        assert "every verdict is the one that the baseline expects" not in top, top


def test_the_message_is_told_to_machines(found: tuple[Finding, Told]) -> None:
    finding, told = found
    assert told.json["outcome"]["code"] == finding.code
    lists = {name: lines for name, lines in told.json["outcome"].items() if name != "code"}
    assert [name for name, lines in lists.items() if finding.message in lines], lists
    case = told.junit.find(f'.//testcase[@name="{finding.junit}"]/failure')
    assert case is not None, ElementTree.tostring(told.junit, encoding="unicode")
    assert finding.message in (case.text or "").splitlines(), case.text
    assert int(told.junit.get("failures", "0")) > 0


def test_cases_and_counterexamples_stand_with_the_part(found: tuple[Finding, Told]) -> None:
    finding, told = found
    anchor = finding.part.replace("/", "-")
    on_page = words_on(told.page.partition(f'<div class="part" id="{anchor}">')[2].partition("</div>")[0])
    for needed in (*finding.evidence, finding.reason):
        assert needed.lower() in on_page, (needed, on_page)
    part = next(
        part for claim in told.json["claims"] for part in claim["parts"] if part["key"] == finding.part
    )
    assert finding.reason in part["reason"], part
    assert {name: part["cases"][name] for name in finding.cases} == finding.cases, part["cases"]
    names = " ".join(each["id"] for each in part["counterexamples"])
    assert all(word in names for word in re.findall("found-[a-z]+", " ".join(finding.evidence))), part


def test_a_server_sees_the_part_fail_for_its_reason(found: tuple[Finding, Told]) -> None:
    finding, told = found
    case = told.junit.find(f'.//testcase[@name="{finding.part}"]')
    assert case is not None
    failure = case.find("failure")
    assert (failure is not None) == bool(finding.reason), ElementTree.tostring(case)
    if failure is not None:
        assert finding.reason in (failure.text or ""), failure.text
        assert "the baseline says supported" in failure.get("message", ""), failure.attrib
