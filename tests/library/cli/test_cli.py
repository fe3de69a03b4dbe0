"""The command line: exit codes, messages, files, and tables that fit."""

import json
import os
import re
import shutil
import subprocess
import sys
from dataclasses import replace
from fractions import Fraction
from itertools import product
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from typer.testing import CliRunner

import convexperc.recognition
import convexperc.solvers.newton.method
from convexperc.cli.main import app
from convexperc.cli.options import BUDGET
from convexperc.enclosure.budget import SECONDS
from convexperc.errors import InputError, SolverError
from convexperc.features import FeatureConfiguration
from convexperc.files import write_json
from convexperc.problem.files import problem_record
from convexperc.problem.problem import Problem
from convexperc.recognition.label import decide
from convexperc.recognition.recognition import Verdict
from convexperc.report.tables import above, below
from convexperc.solution.single import solve
from convexperc.solvers.conic import Conic
from convexperc.solvers.interface import SolverResult
from verification import proof_checker

QUICK = FeatureConfiguration(
    working_size=(32, 32), color_bins=8, hog_pixels_per_cell=(8, 8), lbp_points=8, lbp_radius=1.0, lbp_bins=10
)
RUNNER = CliRunner(env={"COLUMNS": "80", "TERM": "dumb", "NO_COLOR": "1"})


def run(*arguments):
    return RUNNER.invoke(app, [str(argument) for argument in arguments])


def expect(code, result):
    assert result.exit_code == code, (result.exit_code, result.output, result.exception)
    return result


@pytest.fixture(scope="module")
def answered(tmp_path_factory):
    """A problem file, a right answer's file, and the solution."""
    folder = tmp_path_factory.mktemp("problem")
    rng = np.random.default_rng(7)
    X = rng.normal(size=(4, 6))
    problem = Problem(
        X, X[0], modalities={"a": [0, 2, 4], "b": [1, 3, 5]}, lambda1=0.2, lambda2=0.6, lambda3=0.1
    )
    solution = solve(problem, Conic())
    write_json(folder / "problem.json", problem_record(problem, "case 1"))
    write_json(folder / "answer.json", {"id": "case 1", "w": solution.w.tolist(), "u": solution.u.tolist()})
    return folder / "problem.json", folder / "answer.json", solution


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    """A folder of references, a folder of views of the second, and a quick configuration."""
    folder = tmp_path_factory.mktemp("pictures")
    rows, columns = np.mgrid[:40, :48]
    shapes = {"stripes": columns // 6 % 2, "disc": (rows - 20) ** 2 + (columns - 24) ** 2 < 180}
    for i, (name, shape) in enumerate(shapes.items()):
        image = np.full((40, 48, 3), 30, dtype=np.uint8)
        image[..., i] += (180 * shape).astype(np.uint8)
        save(folder / "references", name, image)
        if name == "disc":
            save(folder / "views", "robot [red] 1", image[:, ::-1] + np.uint8(2))
            save(folder / "views", "robot 2", np.roll(image, 6, axis=1))
            save(folder / "views", "robot 3", np.full_like(image, 200))
    write_json(folder / "quick.json", QUICK.to_dict())
    return folder


def save(folder, name, image):
    folder.mkdir(exist_ok=True)
    done, data = cv2.imencode(".png", image)
    assert done
    (folder / f"{name}.png").write_bytes(data.tobytes())


def recognize_arguments(folders, *more):
    arguments = "recognize", "--references", folders / "references", "--views", folders / "views"
    return *arguments, "--configuration", folders / "quick.json", *more


def test_version_and_help():
    assert re.fullmatch(r"convexperc \d+\.\d+\.\d+\S*\n", expect(0, run("--version")).output)
    for command in ((), ("recognize",), ("solve",), ("certify",)):
        assert "130 interrupted" in " ".join(expect(0, run(*command, "--help")).output.split())


def test_solve_prints_and_writes_the_certified_answer(answered, tmp_path):
    problem, _, solution = answered
    result = expect(0, run("solve", problem, "--json", tmp_path / "s.json"))
    lines = result.stdout.splitlines()
    assert lines[0].startswith("case 1: n = 4 views, d = 6 features (a 3, b 3)"), lines
    optimum = next(line for line in lines if line.startswith("  optimum"))
    lower, upper = (float(text) for text in re.findall(r"\d+\.\d+", optimum))
    assert lower <= solution.certificate.upper, (optimum, solution.certificate)
    assert solution.certificate.lower <= upper, (optimum, solution.certificate)
    assert any(line.startswith("  status   certified") for line in lines), lines
    assert re.search(rf"row 0 +{solution.w[0]:.6f} ", result.stdout), result.stdout
    record = json.loads((tmp_path / "s.json").read_text())
    assert (record["id"], record["status"]) == ("case 1", "certified")
    assert result.stderr.split() == ["wrote", str(tmp_path / "s.json")]


def test_qp_agrees_where_it_can_and_is_misuse_where_it_cannot(answered, tmp_path):
    problem = json.loads(answered[0].read_text())
    (tmp_path / "lasso.json").write_text(json.dumps({**problem, "lambda3": 0}))
    for solver in ("qp", "conic"):
        expect(0, run("solve", tmp_path / "lasso.json", "--solver", solver))
    assert "conic" in expect(2, run("solve", answered[0], "--solver", "qp")).stderr
    expect(2, run("solve", answered[0], "--solver", "magic"))


def test_certify_accepts_a_right_answer_and_not_a_wrong_one(answered, tmp_path):
    problem, answer, solution = answered
    good = expect(0, run("certify", problem, answer, "--json", tmp_path / "c.json"))
    for text in ("KKT residual", "Gap by term", "view norm", "proved zero", "status   certified"):
        assert text in good.stdout, (text, good.stdout)
    record = json.loads((tmp_path / "c.json").read_text())
    assert record["lower"]["decimal"] <= solution.certificate.upper
    assert len(record["kkt_residual"]["views"]) == 4
    wrong = {"w": (solution.w + 1e-3).tolist(), "u": solution.u.tolist(), "status": "optimal", "objective": 0}
    (tmp_path / "wrong.json").write_text(json.dumps(wrong))
    bad = expect(1, run("certify", problem, tmp_path / "wrong.json"))
    assert "NOT CERTIFIED" in bad.stdout
    assert "optimal" not in bad.stdout


def test_bad_input_is_told_plainly(answered, tmp_path):
    problem, answer, _ = answered
    (tmp_path / "bad.json").write_text(problem.read_text().replace('"lambda1"', '"lamda1"'))
    for arguments in (
        ("solve", tmp_path / "bad.json"),
        ("solve", tmp_path / "none.json"),
        ("certify", problem, problem),
        ("certify", answer, answer),
        ("solve", problem, "--json", tmp_path / "none" / "x.json"),
    ):
        result = expect(2, run(*arguments))
        assert result.stderr.startswith("error: "), result.stderr
        assert "Traceback" not in result.output
        assert result.stdout == "", result.stdout


def contents(folder):
    return {path: path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


@pytest.mark.parametrize(
    "arguments",
    [
        "solve q.json --json q.json",
        "solve q.json --proof ./q.json",
        "solve q.json --json link.json",
        "solve q.json --json new.json --proof new.json",
        "certify q.json a.json --json q.json",
        "certify q.json a.json --json a.json",
        "recognize --references references --views views --picture views/new.png",
        "recognize --references references --views views --picture references/disc.png",
        "recognize --references references --views views --json views/new.json",
        "recognize --references references --views views --configuration quick.json --json quick.json",
        "recognize --references references --views views --json new.svg --picture new.svg",
        "recognize --sample --json new.svg --picture ./new.svg",
        "simulate scene scene.json .",
        "simulate scene scene.json set --meshes .",
        "simulate physical views --meshes views",
        "simulate case-study views/new --meshes views",
    ],
)
def test_an_output_is_never_an_input_or_another_output(answered, folders, arguments, tmp_path, monkeypatch):
    shutil.copytree(folders, tmp_path / "here")
    monkeypatch.chdir(tmp_path / "here")
    shutil.copy(answered[0], "q.json")
    shutil.copy(answered[1], "a.json")
    Path("link.json").symlink_to("q.json")
    Path("scene.json").write_text(run("simulate", "example").stdout)
    before = contents(tmp_path)
    result = expect(2, run(*arguments.split()))
    assert re.fullmatch(r"error: (--json|--proof|--picture|DIR) must .*; got '.*'.*\n", result.stderr), result
    assert result.stdout == ""
    assert contents(tmp_path) == before


def test_nothing_is_written_where_one_of_two_outputs_cannot_be_made(folders, tmp_path, monkeypatch):
    def give_up(*_):
        raise InputError("picture", value=1, must="must be drawn")

    monkeypatch.setattr("convexperc.report.figure.draw", give_up)
    more = "--json", tmp_path / "r.json", "--picture", tmp_path / "r.svg"
    assert "must be drawn" in expect(2, run(*recognize_arguments(folders, *more))).stderr
    assert contents(tmp_path) == {}


def test_recognize_ends_with_the_certificate(folders, tmp_path):
    more = "--json", tmp_path / "r.json", "--picture", tmp_path / "r.svg"
    result = expect(0, run(*recognize_arguments(folders, *more)))
    lines = [line.rstrip() for line in result.stdout.splitlines()]
    assert lines[0].startswith("3 views in"), lines
    heads = [i for i, line in enumerate(lines) if line.startswith(("Objects", "Ranking", "Certificate"))]
    assert len(heads) == 4, lines
    certificate = lines[heads[-1] :]
    assert [line.split() for line in certificate[:2]] == [["Certificate", "for", "disc"], ["label", "disc"]]
    assert certificate[2].split()[:3] == ["acceptance", "not", "judged,"], certificate
    assert " ".join(certificate[3].split()) == "verdict proved: lowest optimum of 2 objects", certificate
    assert "robot [red] 1" in result.stdout
    assert all(len(line) <= 80 for line in lines[2:]), lines
    assert "\x1b" not in result.output
    record = json.loads((tmp_path / "r.json").read_text())
    assert (record["label"], record["verdict"]) == ("disc", "proved: lowest optimum")
    assert record["features"] == QUICK.to_dict()
    assert (tmp_path / "r.svg").read_bytes().startswith(b"<?xml")


def test_many_long_names_leave_the_numbers_whole(folders, tmp_path):
    for i, source in enumerate(sorted((folders / "references").iterdir())):
        target = tmp_path / f"an object whose name is far too long for a narrow terminal, number {i}.png"
        target.write_bytes(source.read_bytes())
    arguments = list(recognize_arguments(folders))
    arguments[2] = tmp_path
    narrow = RUNNER.invoke(app, [str(argument) for argument in arguments], env={"COLUMNS": "72"})
    result = expect(0, narrow)
    assert all(len(line.rstrip()) <= 72 for line in result.stdout.splitlines()[2:]), result.stdout
    assert len(re.findall(r"\d\.\d{9,}", result.stdout)) >= 8, result.stdout
    assert re.search(r"yes +label *\n", result.stdout), result.stdout


def test_no_name_forges_a_line(folders, tmp_path):
    forged = "disc\n  verdict  proved", "\x1b[31mstripes\u202e"
    for (folder, source), name in product((("references", "stripes"), ("views", "robot 2")), forged):
        (tmp_path / folder).mkdir(exist_ok=True)
        shutil.copy(folders / folder / f"{source}.png", tmp_path / folder / f"{name}.png")
    arguments = "recognize", "--references", tmp_path / "references", "--views", tmp_path / "views"
    files = "--json", tmp_path / "r\n.json", "--picture", tmp_path / "r.png"
    result = expect(1, run(*arguments, "--configuration", folders / "quick.json", *files))
    assert not re.search(r"[\x1b\u202e]", result.output), result.output
    verdicts = [line for line in result.stdout.splitlines() if line.startswith("  verdict")]
    assert len(verdicts) == 1, result.stdout
    assert "tie" in verdicts[0], verdicts
    assert r"wrote " in result.stderr
    assert len(result.stderr.splitlines()) == 2, result.stderr
    assert json.loads((tmp_path / "r\n.json").read_text())["candidates"] == sorted(forged)


def test_a_tie_is_exit_1_with_its_reason(folders, tmp_path):
    image = (folders / "references" / "disc.png").read_bytes()
    for name in ("one", "two"):
        (tmp_path / f"{name}.png").write_bytes(image)
    arguments = list(recognize_arguments(folders))
    arguments[2] = tmp_path
    result = expect(1, run(*arguments))
    assert "label none; candidates: one, two" in " ".join(result.stdout.split()), result.stdout
    assert "tie: the templates one, two are identical" in result.stdout, result.stdout
    assert result.stdout.count("candidate\n") == 2, result.stdout


@pytest.mark.parametrize(("doubtful", "code"), [("disc", 1), ("stripes", 0)])
def test_a_label_whose_own_answer_is_not_certified_is_exit_1(folders, monkeypatch, doubtful, code):
    real = convexperc.recognition.perceive

    def half_certified(*args, **options):
        found = real(*args, **options)
        gap = np.where(np.array(found.names) == doubtful, 1.0, found.answers.gap)
        return decide(replace(found.answers, gap=gap), found.names, found.views)

    monkeypatch.setattr(convexperc.recognition, "perceive", half_certified)
    result = expect(code, run(*recognize_arguments(folders)))
    assert "label disc" in " ".join(result.stdout.split()), result.stdout
    assert "1 of 2 have a certified answer" in result.stdout, result.stdout
    place = "label" if doubtful == "disc" else "excluded"
    assert re.search(rf"{doubtful} .* F\* only +{place}", result.stdout), result.stdout


def test_recognize_wants_one_source_and_sound_options(folders, tmp_path, monkeypatch):
    monkeypatch.setattr(convexperc.recognition, "perceive", pytest.fail)
    for arguments in (
        ("recognize",),
        ("recognize", "--references", folders),
        ("recognize", "--sample", "--views", folders),
        ("recognize", "--scene", "red-car"),
        ("recognize", "--sample", "--scene", "nowhere"),
        recognize_arguments(folders, "--scene", "red-car"),
        recognize_arguments(folders, "--picture", tmp_path / "x.bmp"),
        recognize_arguments(folders, "--picture", tmp_path / "none" / "x.png"),
        recognize_arguments(folders, "--lambda1", "much"),
        ("recognize", "--references", tmp_path, "--views", folders / "views"),
    ):
        result = expect(2, run(*arguments))
        assert result.stderr, arguments
        assert result.stdout == "", result.stdout


def test_a_budget_that_does_not_suffice_is_named(answered, monkeypatch, tmp_path):
    def guess(_, problem):
        return SolverResult(np.ones(problem.n), np.ones(problem.d), "optimal, honestly", 1)

    monkeypatch.setattr(convexperc.solvers.newton.method.Newton, "solve", guess)
    proof = tmp_path / "proof.json"
    done = expect(1, run("solve", answered[0], "--seconds", "1e-9", "--proof", proof))
    shown = " ".join(done.stdout.split())
    assert "the budget of 1e-09 s for ball arithmetic does not suffice" in shown, shown
    assert "proof file 0.558" in shown, shown
    assert proof_checker.check(proof).proved
    assert "does not suffice" not in expect(0, run("solve", answered[0], "--seconds", "inf")).stdout
    assert BUDGET == SECONDS


@pytest.mark.parametrize("value", ["0", "-1", "nan"])
def test_an_illegal_budget_is_misuse(folders, answered, value):
    for arguments in (("solve", answered[0]), recognize_arguments(folders)):
        result = expect(2, run(*arguments, "--seconds", value))
        assert result.stderr.startswith("error: seconds must be a number > 0"), result.stderr


@pytest.mark.parametrize("value", ["-1", "nan", "inf"])
def test_an_illegal_lambda_is_misuse(folders, value):
    result = expect(2, run(*recognize_arguments(folders, "--lambda2", value)))
    assert result.stderr.startswith("error: lambda2 must be"), result.stderr


def test_a_solver_that_gives_up_certifies_nothing(answered, monkeypatch):
    def give_up(*_):
        raise SolverError("newton", value="no point", must="must return a point")

    monkeypatch.setattr(convexperc.solvers.newton.method.Newton, "solve", give_up)
    assert "no point" in expect(1, run("solve", answered[0], "--no-escalate")).stderr
    assert "failed: no point" in " ".join(expect(0, run("solve", answered[0])).stdout.split())


def test_a_poor_answer_of_a_confident_solver_is_exit_1(answered, monkeypatch):
    def guess(_, problem):
        return SolverResult(np.ones(problem.n), np.ones(problem.d), "optimal, honestly", 1)

    monkeypatch.setattr(convexperc.solvers.newton.method.Newton, "solve", guess)
    result = expect(1, run("solve", answered[0], "--no-escalate"))
    assert "status   NOT CERTIFIED" in result.stdout, result.stdout
    assert "solver status (not used): optimal, honestly" in result.stdout, result.stdout
    assert "ball arithmetic" in expect(0, run("solve", answered[0])).stdout


@pytest.mark.parametrize(("name", "shown"), [("newton", "newton"), ("conic", "cvxpy+clarabel")])
def test_the_solver_can_be_named(answered, name, shown):
    assert shown in expect(0, run("solve", answered[0], "--solver", name)).stdout


def test_the_sample_is_recognised_with_a_proof():
    result = expect(0, run("recognize", "--sample", "--scene", "ica-sign"))
    assert result.stdout.startswith("Sample: 5 robots look at ica-sign"), result.stdout
    assert Verdict.PROVED.value in result.stdout


@given(st.floats(0.0, 1.7e308), st.integers(1, 17))
def test_printed_bounds_are_rounded_outward(value, digits):
    assert Fraction(below(value, digits)) <= Fraction(value) <= Fraction(above(value, digits))


def test_an_infinite_bound_is_printed():
    assert float(above(float("inf"), 3)) == float("inf")


def child(code, *arguments, **options):
    """Run the console script's main in a fresh interpreter, after `code`."""
    program = f"import sys\nsys.argv = ['convexperc', *{list(map(str, arguments))!r}]\n"
    program += f"from convexperc.__main__ import main\n{code}\nmain()"
    return subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=False, **options
    )


SLOW = ("asyncio", "cv2", "cvxpy", "flint", "jaxtyping", "matplotlib", "numba", "numpy", "osqp", "PIL")
SLOW = (*SLOW, "rich.progress", "scipy", "skimage")
"""Modules that take from 0.01 s to seconds to load."""


@pytest.mark.parametrize(
    ("arguments", "slow"),
    [
        (["--help"], SLOW),
        (["recognize", "--help"], SLOW),
        (["simulate", "physical", "--help"], SLOW),
        (["--version"], (*SLOW, "rich", "importlib.metadata")),
        (["recognize", "--sample"], ("cvxpy", "flint", "matplotlib", "osqp", "rich.progress", "mujoco")),
    ],
)
def test_a_command_loads_what_it_needs_alone(arguments, slow):
    code = (
        f"import atexit\natexit.register(lambda: print('loaded:', [n for n in {slow} if n in sys.modules]))"
    )
    done = child(code, *arguments)
    assert done.returncode == 0, done
    assert done.stdout.endswith("loaded: []\n"), done.stdout


def test_a_stream_that_knows_ascii_alone_still_gets_the_answer(answered, tmp_path):
    problem = json.loads(answered[0].read_text())
    (tmp_path / "p.json").write_text(json.dumps({**problem, "id": "車"}))
    environment = {**os.environ, "PYTHONIOENCODING": "ascii"}
    done = child("", "solve", tmp_path / "p.json", env=environment)
    assert done.returncode == 0, done
    assert done.stdout.startswith("\\u8eca: n = 4"), done.stdout
    assert done.stdout.isascii(), done.stdout
