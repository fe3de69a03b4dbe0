"""Both packages from an archive, as applications are sometimes shipped: their data are read from it."""

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest

import convexperc
import verification
from convexperc.files import write_json
from convexperc.problem.files import problem_record
from convexperc.problem.problem import Problem
from verification.provenance import stamp

ROOTS = [Path(package.__file__).parent for package in (convexperc, verification)]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with the archive, a problem, and an answer to it that is wrong."""
    place = tmp_path_factory.mktemp("archive")
    with zipfile.ZipFile(place / "both.zip", "w") as archive:
        for root in ROOTS:
            for file in root.rglob("*"):
                if file.is_file() and file.suffix != ".pyc":
                    archive.write(file, file.relative_to(root.parent))
    X = np.random.default_rng(7).normal(size=(4, 6))
    write_json(place / "problem.json", problem_record(Problem(X, X[0], lambda1=1, lambda2=1, lambda3=1)))
    write_json(place / "answer.json", {"w": [0.0] * 4, "u": [0.0] * 6})
    return place


def python(folder, *words):
    environment = os.environ | {"PYTHONPATH": str(folder / "both.zip"), "COLUMNS": "140"}
    command = [sys.executable, *words]
    return subprocess.run(command, check=False, cwd=folder, env=environment, capture_output=True, text=True)


@pytest.mark.parametrize(
    ("command", "code", "shown"),
    [
        ("convexperc --help", 0, "recognize"),
        ("convexperc certify problem.json answer.json", 1, "NOT CERTIFIED"),
        ("verification families", 0, "degenerate"),
        ("verification list", 0, "Claims"),
        ("verification check answer.json", 1, "rejected"),
    ],
)
def test_a_command_answers(command, code, shown, folder):
    done = python(folder, "-m", *command.split())
    assert (done.returncode, done.stderr) == (code, ""), done
    assert shown in done.stdout, done.stdout


def test_what_comes_with_the_packages_is_found(folder):
    code = (
        "import convexperc.recognition.sample as sample\n"
        "from verification.ledger.baseline import read_baseline\n"
        "from verification.provenance import stamp\n"
        "from verification.counterexamples.files import catalogue\n"
        "scene = sample.sample_scene('red-car')\n"
        "print(sample.__file__)\n"
        "print(len(scene.views), bool(read_baseline()), bool(catalogue()), stamp('report')['code'])"
    )
    done = python(folder, "-c", code)
    assert done.returncode == 0, done.stderr
    place, told = done.stdout.splitlines()
    assert place.startswith(str(folder / "both.zip")), place
    assert told == f"5 True True {stamp('report')['code']}"
