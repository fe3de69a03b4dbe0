"""The committed report is whole, follows its schema, and says what the ledger and the baseline say."""

import hashlib
import json
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from verification import report
from verification.ledger.baseline import read_baseline
from verification.ledger.claims import CLAIMS, PARTS
from verification.report.diff import read_report

REPORTS = Path(__file__).parents[3] / "reports"
SCHEMA = Path(report.__file__).with_name("report.schema.json")


@pytest.fixture(scope="module")
def committed() -> dict[str, Any]:
    return read_report(REPORTS / "report.json")


def test_every_file_has_its_hash() -> None:
    lines = (REPORTS / "SHA256SUMS").read_text().splitlines()
    assert len(lines) > 40, lines
    for line in lines:
        digest, name = line.split(maxsplit=1)
        assert hashlib.sha256((REPORTS / name).read_bytes()).hexdigest() == digest, name


def test_it_follows_its_schema(committed: dict[str, Any]) -> None:
    jsonschema.Draft202012Validator(json.loads(SCHEMA.read_text())).validate(committed)


def test_its_verdicts_are_the_baseline(committed: dict[str, Any]) -> None:
    found = {claim["id"]: claim["verdict"] for claim in committed["claims"]}
    found |= {part["key"]: part["verdict"] for claim in committed["claims"] for part in claim["parts"]}
    expected = {key: verdict.value for key, verdict in read_baseline().items()}
    assert found == expected, {
        key: (found.get(key), each) for key, each in expected.items() if found.get(key) != each
    }


def test_it_is_about_the_ledger_as_it_is(committed: dict[str, Any]) -> None:
    claims = {claim["id"]: claim["statement"] for claim in committed["claims"]}
    assert claims == {key: claim.statement for key, claim in CLAIMS.items()}
    parts = {part["key"]: part["statement"] for claim in committed["claims"] for part in claim["parts"]}
    assert parts == {key: part.statement for key, part in PARTS.items()}


def test_the_page_is_one_small_file_without_scripts() -> None:
    page = (REPORTS / "report.html").read_text(encoding="utf-8")
    assert len(page.encode()) < 1_000_000, len(page)
    assert "<script" not in page.lower(), "a script"
    assert all(text not in page for text in ('src="http', "url(http", "@import")), "something from elsewhere"
