"""Generated code through the kit: what is left over from an earlier call is found, planted and real."""

import json
import shutil
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

from convexperc.problem.problem import Problem
from verification.conformance.answers import Answer, Refusal
from verification.conformance.doors import Command
from verification.conformance.generated import BACKENDS, Shape, main_program
from verification.conformance.judge import Level
from verification.conformance.profiles import FLOAT64
from verification.conformance.request import Request
from verification.conformance.searching import search
from verification.conformance.suite import Selection, run
from verification.conformance.vectors import Vectors, all_vectors
from verification.provenance import installed

NEEDED = [name for name in ("cmake", "cc") if shutil.which(name) is None]
if find_spec("cvxpygen") is None:
    NEEDED.append("cvxpygen")
GENERATED = (sys.executable, "-m", "verification.conformance.generated", "--folder", "built")

STALE = '''
"""A solver that keeps its parameters from call to call; one of them is never replaced after the first."""
from convexperc import Problem, solve
from verification.conformance.serve import serve, strictly

KEPT = {}


def stale(X, o, modalities, **weights):
    given = {"X": X, "o": o, **weights}
    kept = KEPT.setdefault((X.shape, tuple(modalities)), dict(given))
    given["PARAMETER"] = kept["PARAMETER"]
    found = solve(Problem(given.pop("X"), given.pop("o"), modalities=modalities, **given))
    return found.w, found.u


serve(stale, strictly)
'''


def planted(folder: Path, parameter: str) -> Command:
    (folder / "stale.py").write_text(STALE.replace("PARAMETER", parameter))
    return Command([sys.executable, "stale.py"], folder=folder)


def generated(folder: Path, backend: str, state: str) -> Command:
    words = ("--backend", backend, "--state", state, "--largest", "12")
    return Command([*GENERATED, *words], seconds=200.0, folder=folder)


@pytest.mark.parametrize("parameter", ["X", "o", "lambda1", "lambda2", "lambda3"])
def test_a_parameter_that_is_not_updated_is_found_by_the_vectors(tmp_path: Path, parameter: str):
    small = [each for each in all_vectors().problems if each.request.problem.X.size <= 4]
    of = Vectors(tuple(small), (), ())
    report = run(planted(tmp_path, parameter), Selection(FLOAT64), of=of)
    assert report.counts(Level.L0)["failed"] == 0
    assert report.counts(Level.L2)["failed"] > 0, f"{parameter} stays as it was, and nothing failed"


def test_a_parameter_that_is_not_updated_is_found_and_shrunk_by_the_search(tmp_path: Path):
    found = search(planted(tmp_path, "o"), FLOAT64, 100)
    (smallest,) = [each for each in found.found if each.level is Level.L2]
    request = json.loads(smallest.line)
    assert request["n"] * request["d"] <= 2, smallest.line
    assert not found.broken


def test_strict_reading_refuses_every_malformed_line(tmp_path: Path):
    report = run(planted(tmp_path, "X"), Selection(FLOAT64, "malformed"))
    assert report.counts(Level.L0) == {"held": len(report.findings)}


def test_the_program_writes_scalars_where_cvxpygen_has_no_arrays():
    text = main_program(BACKENDS["qoco"], Shape(1, (1,), norms=True))
    assert "cpg_update_X(given[3]);" in text
    assert "(&CPG_Result.prim->w)[k]" in text
    assert "cpg_update_lambda3(given[2]);" in text
    text = main_program(BACKENDS["osqp_tight"], Shape(2, (2,), norms=False))
    assert "lambda3" not in text
    assert "cpg_set_solver_eps_abs(1e-10);" in text


@pytest.mark.skipif(bool(NEEDED), reason=f"generated code needs {', '.join(NEEDED)}")
def test_generated_code_is_right_after_another_problem(tmp_path: Path):
    report = run(generated(tmp_path, "qocogen", "primed"), Selection(FLOAT64, "lambda1-zero-0[0-3]"))
    assert report.counts(Level.L0)["failed"] == report.counts(Level.L1)["failed"] == 0
    assert report.counts(Level.L1)["held"] > 0


@pytest.mark.skipif(bool(NEEDED), reason=f"generated code needs {', '.join(NEEDED)}")
@pytest.mark.skipif("cvxpygen" not in NEEDED and installed("cvxpygen") != "1.0.2", reason="faults of 1.0.2")
def test_two_faults_of_one_release_are_shown_by_one_request_each(tmp_path: Path):
    """QOCO's scaling of the last call stays in its matrix; QOCOGEN starts without settings."""
    zeros = Problem([[0.0], [0.0]], [0.0], modalities=[1], lambda1=1.0, lambda2=10.0, lambda3=1.0)
    request, answers = Request("zeros", zeros), {}
    for backend, state in (("qoco", "fresh"), ("qoco", "primed"), ("qocogen_example", "fresh")):
        with generated(tmp_path, backend, state) as door:
            answers[backend, state] = door.ask(request).answer
    assert isinstance(answers["qoco", "fresh"], Answer)
    assert answers["qoco", "primed"] == Refusal("error", "ArithmeticError: status 4")
    assert answers["qocogen_example", "fresh"] == Refusal("error", "ArithmeticError: status 4")


@pytest.mark.skipif(bool(NEEDED), reason=f"generated code needs {', '.join(NEEDED)}")
def test_what_is_too_large_or_no_quadratic_program_is_declined(tmp_path: Path):
    door = Command([*GENERATED, "--backend", "osqp", "--largest", "0"], folder=tmp_path)
    report = run(door, Selection(FLOAT64, "random-0[0-3]"))
    assert report.counts(Level.L0) == {"skipped": 4}
