"""The table of the lasso family: data sets, promises kept and broken, packages that fail."""

import json
import sys
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from verification.conformance import lasso_fits
from verification.conformance.lasso_fits import FITTED, KINDS, SETS, ask, data_set, markdown, rows
from verification.conformance.lasso_runner import PEERS

SKLEARN = tuple(each for each in FITTED if each.package == "scikit-learn")
needs_sklearn = pytest.mark.skipif(find_spec("sklearn") is None, reason="scikit-learn is not installed")


def test_the_data_sets_have_every_kind_with_and_without_an_intercept():
    sets = [data_set(k) for k in range(SETS)]
    assert {(each.kind, each.intercept) for each in sets} == {
        (kind, x) for kind in KINDS for x in (True, False)
    }
    assert all(each.X.shape[1] == sum(each.sizes) and each.alpha > 0.0 for each in sets)
    assert data_set(3).line == sets[3].line
    assert json.loads(sets[2].line)["id"] == "lasso-02"


def test_every_row_has_its_fit_and_a_name_of_its_own():
    assert {each.runner for each in FITTED} == set(PEERS)
    assert len({(each.name, each.tolerance) for each in FITTED}) == len(FITTED)


@needs_sklearn
def test_a_promise_is_kept_at_its_own_tolerance_and_proved_broken_at_another():
    default, tight = SKLEARN
    bold = replace(default, name="as if it had promised 1e-10", gap=1e-10)
    sets = [data_set(k) for k in range(0, SETS, 3)]
    kept, narrow, broken = rows({}, (default, tight, bold), sets)
    assert kept["promise"]["broken"] == narrow["promise"]["broken"] == 0
    assert len(sets) / 2 < kept["promise"]["kept"] <= kept["answered"] == len(sets)
    assert broken["promise"]["broken"] > 0
    assert broken["smallest"]["id"] in {each.id for each in sets}
    assert narrow["near"] >= kept["near"]
    page = "\n".join(markdown([kept, broken]))
    assert f"{kept['promise']['kept']}, 0" in page
    assert broken["smallest"]["id"] in page


@needs_sklearn
def test_a_wrong_objective_shows():
    """Judged by twice its strength, a right answer is far from optimal."""
    (row,) = rows({}, (replace(SKLEARN[1], factor=2.0),), [data_set(k) for k in range(6)])
    assert row["near"] == 0
    assert row["worst"] > 1e-3


def test_a_package_that_ends_or_never_answers_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    sets = [data_set(0), data_set(1)]
    for body, why in (
        ("import sys; sys.exit(3)", "ended with 3"),
        ("import time; time.sleep(60)", "no answer"),
    ):
        program = tmp_path / "fit.py"
        program.write_text(f'print(\'{{"version": "1"}}\', flush=True)\n{body}\n')
        monkeypatch.setattr(lasso_fits.lasso_runner, "__file__", str(program))
        monkeypatch.setattr(lasso_fits, "SECONDS", 3.0)
        version, answers = ask(sys.executable, "sklearn", "scikit-learn", sets)
        assert version == "1"
        assert len(answers) == 2
        assert all(why in answer["error"] for answer in answers)


def test_a_package_that_is_not_there_is_not_run():
    (row,) = rows({}, (replace(SKLEARN[0], module="no_such_module"),), [data_set(0)])
    assert row["absent"] == "no_such_module is not installed"
    assert "Not run: scikit-learn, Lasso" in "\n".join(markdown([row]))


@needs_sklearn
def test_an_answer_that_is_no_number_is_no_answer(monkeypatch: pytest.MonkeyPatch):
    broken = [{"coef": [np.nan] * data_set(0).X.shape[1], "intercept": 0.0}]
    monkeypatch.setattr(lasso_fits, "ask", lambda *given: ("1", broken))
    (row,) = rows({}, SKLEARN[:1], [data_set(0)])
    assert row["answered"] == 0
    assert row["worst"] is None
