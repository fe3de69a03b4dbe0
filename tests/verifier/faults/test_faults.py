"""Planted faults: each is named by its check on a small problem, the true code by none; all are taken out."""

import io
import json
from dataclasses import replace
from pathlib import Path

import jsonschema
import pytest
from rich.console import Console

from convexperc.problem import formulation as objective
from convexperc.solvers.paper import trace as paper_trace
from verification.faults.fault import Fault, Patcher, everywhere, replaced
from verification.faults.hunt import Caught, explored, hunt, hunts
from verification.faults.own import COST, FAULTS
from verification.faults.table import SCHEMA, WIDTH, as_json, as_markdown, planted, table
from verification.ledger.claims import PARTS
from verification.ledger.evidence import Outcome
from verification.problems.families import FAMILIES

FAULT = {fault.name: fault for fault in FAULTS}
SHRUNK = ("u is not updated", "lambda3 halved in the objective", "coupling term left out of the gap")
"""Some faults whose counterexample has one view and one feature."""
LARGEST = 6
"""n d of the largest counterexample: two views and three features."""
REPORT = Path(__file__).parents[3] / "reports" / "faults.json"
HUNTS = hunts(FAULTS)

TABLE_SCHEMA = {
    "type": "object",
    "additionalProperties": False,
    "required": ["schema", "note", "seed", "planted", "caught", "faults"],
    "properties": {
        "schema": {"const": "convexperc/faults/1"},
        "note": {"type": "string"},
        "seed": {"type": "integer"},
        "planted": {"type": "integer"},
        "caught": {"type": "integer"},
        "faults": {
            "type": "array",
            "items": {
                "type": "object",
                "additionalProperties": False,
                "required": [
                    "fault", "part", "check", "family", "n", "d", "bits", "problems", "detail", "seconds",
                    "caught",
                ],
                "properties": {
                    "part": {"enum": list(PARTS)},
                    "family": {"enum": ["", *FAMILIES]},
                    **{name: {"type": "integer", "minimum": 0} for name in ("n", "d", "bits", "problems")},
                    **{name: {"type": "string", "minLength": 1} for name in ("fault", "check", "detail")},
                    "seconds": {"type": "number", "minimum": 0},
                    "caught": {"type": "boolean"},
                },
            },
        },
    },
}  # fmt: skip


def test_names_are_different_and_parts_are_those_of_the_ledger():
    names = [fault.name for fault in FAULTS + COST]
    assert len(set(names)) == len(names), sorted(name for name in names if names.count(name) > 1)
    assert {fault.part for fault in FAULTS} <= set(PARTS), "a part is not in the ledger"
    assert len(FAULTS) >= 36, len(FAULTS)


@pytest.mark.parametrize("fault", FAULTS, ids=list(FAULT))
def test_a_planted_fault_is_caught_on_a_small_problem_and_taken_out(fault: Fault):
    with fault.planted() as patcher:
        places = list(patcher.before)
        assert all(vars(target)[name] is not before for target, name, before in places), fault.name
    found = hunt(fault, shrink=False)
    assert found.caught, f"{fault.name!r} escaped {found.check!r}: {found.detail}"
    assert found.n * found.d <= LARGEST, (found.n, found.d)
    assert all(vars(target)[name] is before for target, name, before in places), fault.name


@pytest.mark.parametrize("key", HUNTS, ids=["|".join(map(str, key[:3])) for key in HUNTS])
def test_the_same_hunt_finds_nothing_in_the_true_code(key):
    fault, family = HUNTS[key]
    found = explored(fault, family)
    assert not found.broken, found.broken
    assert found.problems > 0, key
    tally = found.tallies[fault.part]
    assert tally.outcomes[Outcome.FAILED.value] == 0, tally.smallest


@pytest.mark.parametrize("name", SHRUNK)
def test_counterexamples_are_shrunk(name):
    found = hunt(FAULT[name])
    assert (found.n, found.d) == (1, 1), found
    assert found == replace(hunt(FAULT[name]), seconds=found.seconds), "two hunts differ"


def test_the_report_has_every_fault_and_none_escaped():
    found = json.loads(REPORT.read_text(encoding="utf-8"))
    jsonschema.validate(found, TABLE_SCHEMA)
    assert [(each["fault"], each["part"]) for each in found["faults"]] == [(f.name, f.part) for f in FAULTS]
    assert all(each["caught"] and each["n"] * each["d"] <= LARGEST for each in found["faults"]), found[
        "caught"
    ]


def test_a_fault_is_taken_out_after_an_exception():
    fault = Fault("half of F", "B1/objective", replaced(objective, "objective", lambda p, w, u: 0.0))
    true = objective.objective

    def interrupted():
        with fault.planted():
            assert objective.objective is not true
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        interrupted()
    assert objective.objective is true


def test_a_fault_that_cannot_be_planted_leaves_nothing_behind():
    true = objective.objective

    def half_planted(setter):
        setter.setattr(objective, "objective", None)
        setter.setattr(objective, "no such name", None)

    with pytest.raises(KeyError), Fault("half", "B1/objective", half_planted).planted():
        pytest.fail("planted")
    assert objective.objective is true


def test_everywhere_means_every_module_that_holds_the_function():
    patcher, true = Patcher(), objective.residuals
    everywhere(true, len)(patcher)
    try:
        assert objective.residuals is len
        assert paper_trace.residuals is len
    finally:
        patcher.undo()
    assert objective.residuals is paper_trace.residuals is true


def test_a_fault_that_changes_nothing_is_said_to_have_escaped():
    fault = Fault("no fault", "B1/objective", lambda setter: None, families=("random",), problems=10)
    found = hunt(fault)
    assert not found.caught, found
    assert (found.n, found.d, found.problems) == (0, 0, 10), found
    assert as_json([found])["caught"] == 0


def test_a_check_that_breaks_has_not_named_the_fault():
    plant = replaced(objective, "terms", lambda problem, w, u: 1 / 0)
    found = hunt(Fault("broken", "B1/objective", plant, families=("random",), problems=10))
    assert not found.caught, found
    assert "ZeroDivisionError" in found.detail, found.detail


def test_the_table_has_its_schema_and_its_width():
    seen: list[tuple[int, int]] = []
    outcomes = planted(lambda done, total: seen.append((done, total)), FAULTS[1:3])
    assert seen == [(0, 2), (1, 2), (2, 2)], seen
    escaped = Caught("a fault", "B1/dual", "bounds", "", 0, 0, 0, 80, "no failure was seen", 0.5)
    found = as_json([*outcomes, escaped])
    jsonschema.validate(found, TABLE_SCHEMA)
    assert (found["schema"], found["planted"], found["caught"]) == (SCHEMA, 3, 2), found
    console = Console(file=io.StringIO(), width=200)
    console.print(table([*outcomes, escaped]))
    lines = console.file.getvalue().splitlines()
    assert max(map(len, lines)) <= WIDTH, max(lines, key=len)
    assert any("escaped bounds" in line for line in lines), lines
    text = as_markdown([*outcomes, escaped])
    assert text.startswith("# 3 planted faults, 1 escaped\n"), text
    assert "| a fault | escaped bounds | B1/dual |" in text, text
    assert [line.count(" | ") for line in text.splitlines() if line.startswith("| ")] == [7] * 4, text
