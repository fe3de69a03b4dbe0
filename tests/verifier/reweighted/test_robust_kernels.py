"""Losses of libraries: what is known of the installed ones, those that are not, and the command."""

import json
import sys

import numpy as np
import pytest
from typer.testing import CliRunner

from verification.__main__ import app
from verification.reweighted import Word
from verification.reweighted.terms import kernels
from verification.reweighted.terms.kernels import judged

RUNNER = CliRunner(env={"COLUMNS": "140", "TERM": "dumb", "NO_COLOR": "1"})


def faults(library):
    rows = list(judged((library,)))
    assert all(row.answers is not None for row in rows), [row.reason for row in rows]
    assert all(row.answers["tangent"].word is Word.YES for row in rows)
    return len(rows), {
        row.name: [each.question for each in row.answers.faults] for row in rows if row.answers.faults
    }


def test_the_losses_of_scipy_are_sound_and_compared_with_its_cost():
    assert faults("scipy") == (5, {})


def test_the_norms_of_statsmodels():
    pytest.importorskip("statsmodels")
    assert faults("statsmodels") == (10, {"MQuantileNorm": ["majorises"]})


def test_the_estimators_of_gtsam():
    pytest.importorskip("gtsam")
    count, found = faults("gtsam")
    assert count >= 11
    assert set(found) == {"L2WithDeadZone", "AsymmetricCauchy", "AsymmetricTukey"}
    assert all(questions == ["majorises"] for questions in found.values())


def test_a_loss_of_scipy_that_is_not_the_documented_one_gets_no_verdict(monkeypatch):
    monkeypatch.setitem(kernels.LEAST_SQUARES, "cauchy", kernels.LEAST_SQUARES["arctan"])
    rows = {row.name: row for row in judged(("scipy",))}
    assert rows["cauchy"].answers is None
    assert "documented" in rows["cauchy"].reason
    assert rows["huber"].answers is not None


@pytest.mark.parametrize("library", ["statsmodels", "gtsam"])
def test_a_library_that_is_not_there_is_left_out_with_the_reason(library, monkeypatch):
    for name in [each for each in sys.modules if each.split(".")[0] == library]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, library, None)
    (row,) = judged((library,))
    assert (row.name, row.answers) == ("", None)
    assert row.reason.startswith("not installed")
    result = RUNNER.invoke(app, ["kernels", "--library", library])
    assert result.exit_code == 0, result.output
    assert f"{library}: left out, not installed" in result.output


class Norms:
    """A stand-in for statsmodels.robust.norms, with a fault and a class that nobody knows how to make."""

    class RobustNorm:
        pass

    class Doubled(RobustNorm):
        def rho(self, z):
            return np.asarray(z, dtype=float) ** 2 / 2

        def weights(self, z):
            return 2.0 + 0 * np.asarray(z, dtype=float)

    class Unknown(RobustNorm):
        def __init__(self, shape):
            self.shape = shape


def test_a_fault_of_a_library_is_printed_and_an_unknown_loss_left_out(monkeypatch, tmp_path):
    monkeypatch.setattr(kernels, "import_module", lambda name: Norms)
    place = tmp_path / "table.json"
    result = RUNNER.invoke(app, ["kernels", "--library", "statsmodels", "--json", str(place)])
    assert result.exit_code == 3, result.output
    assert "statsmodels Unknown: left out, no known way to make it" in result.output
    assert "statsmodels Doubled: The weight is 2 times the tangent one" in result.output
    data = json.loads(place.read_text(encoding="utf-8"))
    assert [each["kernel"] for each in data["kernels"]] == ["Doubled", "Unknown"]
    assert data["kernels"][0]["answers"][0]["fault"] is True


def test_the_table_has_the_words_and_calls_a_measurement_one(monkeypatch):
    with monkeypatch.context() as patched:
        patched.setattr(kernels, "import_module", lambda name: Norms)
        result = RUNNER.invoke(app, ["kernels", "--library", "statsmodels"])
    assert "yes (measured)" in result.output
    exact = RUNNER.invoke(app, ["kernels", "--library", "scipy"])
    assert exact.exit_code == 0, exact.output
    assert "(measured)" not in exact.output


@pytest.mark.parametrize("arguments", ["--library ceres", "--campaign 5 --library scipy", "--campaign -1"])
def test_misuse_of_the_command(arguments):
    assert RUNNER.invoke(app, ["kernels", *arguments.split()]).exit_code == 2
