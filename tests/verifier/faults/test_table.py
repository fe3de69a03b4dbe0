"""The table of faults: its schema, its width, the committed one, and the command that writes it."""

import io
import json
from pathlib import Path

import jsonschema
import pytest
from rich.console import Console
from typer.testing import CliRunner

from verification.__main__ import app
from verification.faults import table as tables
from verification.faults.hunt import Caught
from verification.faults.own import FAULTS
from verification.faults.table import SCHEMA, WIDTH, as_json, as_markdown, planted, table
from verification.ledger.claims import PARTS
from verification.problems.families import FAMILIES
from verification.provenance import stamp

LARGEST = 6
"""n d of the largest counterexample: two views and three features."""
REPORT = Path(__file__).parents[3] / "reports" / "faults.json"
TEXTS, COUNTS = ("fault", "check", "detail"), ("families", "n", "d", "bits", "problems")
ESCAPED = Caught("a fault", "B1/dual", "bounds", (), False, 0, "", 0, 0, 0, 80, "no failure was seen", 0.5)

TABLE_SCHEMA = {
    "type": "object",
    "additionalProperties": False,
    "required": ["schema", "made", "note", "seed", "planted", "caught", "faults"],
    "properties": {
        "schema": {"const": SCHEMA},
        "made": {"type": "object"},
        "note": {"type": "string"},
        "seed": {"type": "integer"},
        "planted": {"type": "integer"},
        "caught": {"type": "integer"},
        "faults": {
            "type": "array",
            "items": {
                "type": "object",
                "additionalProperties": False,
                "required": [*TEXTS, "part", "parts", "caught", *COUNTS, "family", "seconds"],
                "properties": {
                    "part": {"enum": list(PARTS)},
                    "parts": {"type": "array", "items": {"enum": list(PARTS)}},
                    "family": {"enum": ["", *FAMILIES]},
                    **{name: {"type": "integer", "minimum": 0} for name in COUNTS},
                    **{name: {"type": "string", "minLength": 1} for name in TEXTS},
                    "seconds": {"type": "number", "minimum": 0},
                    "caught": {"type": "boolean"},
                },
            },
        },
    },
}


@pytest.fixture(scope="module")
def outcomes() -> list[Caught]:
    seen: list[tuple[int, int]] = []
    chosen = [fault for fault in FAULTS if fault.part == "B1/objective"][:2]
    two = planted(lambda done, total: seen.append((done, total)), chosen)
    assert seen == [(0, 2), (2, 2)], f"faults of one check end together: {seen}"
    return [*two, ESCAPED]


def test_the_committed_table_has_every_fault_and_none_escaped():
    found = json.loads(REPORT.read_text(encoding="utf-8"))
    jsonschema.validate(found, TABLE_SCHEMA)
    assert [(each["fault"], each["part"]) for each in found["faults"]] == [(f.name, f.part) for f in FAULTS]
    assert all(each["caught"] and each["part"] in each["parts"] for each in found["faults"])
    allowed = {fault.name: {fault.part, *fault.also, *fault.may} for fault in FAULTS}
    assert all(set(each["parts"]) <= allowed[each["fault"]] for each in found["faults"])
    assert all(each["n"] * each["d"] <= LARGEST for each in found["faults"])


def test_the_table_has_its_schema_and_its_width(outcomes):
    found = as_json(outcomes, {"code": "0"})
    jsonschema.validate(found, TABLE_SCHEMA)
    assert (found["planted"], found["caught"]) == (3, 2), found
    console = Console(file=io.StringIO(), width=200)
    console.print(table(outcomes))
    lines = console.file.getvalue().splitlines()
    assert max(map(len, lines)) <= WIDTH, max(lines, key=len)
    assert any("escaped bounds" in line for line in lines), lines
    text = as_markdown(outcomes)
    assert text.startswith("# 3 planted faults, 1 escaped\n"), text
    assert "| a fault | escaped bounds | B1/dual |" in text, text
    assert [line.count(" | ") for line in text.splitlines() if line.startswith("| ")] == [9] * 4, text


@pytest.mark.parametrize(("escaped", "code"), [(0, 0), (1, 1)])
def test_the_command_writes_the_table_and_fails_where_one_escaped(
    outcomes, escaped, code, monkeypatch, tmp_path
):
    chosen = outcomes[: 2 + escaped]
    monkeypatch.setattr(tables, "planted", lambda progress, jobs: chosen)
    files = [tmp_path / "f.json", tmp_path / "f.md"]
    done = CliRunner().invoke(app, ["faults", "--json", str(files[0]), "--markdown", str(files[1])])
    assert done.exit_code == code, done.output
    assert json.loads(files[0].read_text()) == as_json(chosen, stamp("faults"))
    assert files[1].read_text() == as_markdown(chosen)
