"""The templates, built and judged as a newcomer would, by the commands of docs/conformance.md."""

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

COMPILER = shutil.which("cc")


def conform(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "verification", "conform", *words]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=500, check=False)


def judged(folder: Path, *words: str) -> tuple[int, dict]:
    done = conform(folder, *words, "--out", "report")
    assert done.returncode in {0, 1, 3}, done.stderr
    return done.returncode, json.loads((folder / "report" / "report.json").read_text())


def test_the_python_template_conforms(tmp_path: Path):
    (tmp_path / "solver.py").write_text(conform(tmp_path, "template", "python").stdout)
    code, report = judged(tmp_path, "--module", "solver:solve")
    assert code == 0, report["statement"]
    assert report["reached"] == "L3"


def test_the_test_of_the_page_passes_with_the_python_template(tmp_path: Path):
    page = (Path(__file__).parents[3] / "docs" / "conformance.md").read_text("utf-8")
    (example,) = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    (tmp_path / "solver.py").write_text(conform(tmp_path, "template", "python").stdout)
    (tmp_path / "test_mine.py").write_text(example)
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "test_mine.py"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=300, check=False)
    assert "1 passed" in done.stdout, done.stdout


@pytest.mark.skipif(COMPILER is None, reason="this machine has no C compiler")
@pytest.mark.parametrize(("flags", "profile"), [((), "float64"), (("-DREAL=float",), "float32")])
def test_the_c_template_conforms_where_gradients_suffice(
    tmp_path: Path, flags: tuple[str, ...], profile: str
):
    (tmp_path / "solver.c").write_text(conform(tmp_path, "template", "c").stdout)
    strict = ["-Wall", "-Wextra", "-Werror", "-std=c99", "-O2"]
    subprocess.run([COMPILER, *strict, *flags, "-o", "solver", "solver.c", "-lm"], cwd=tmp_path, check=True)
    code, report = judged(tmp_path, "--command", "./solver", "--profile", profile)
    assert report["levels"]["L0"] == {
        "held": report["levels"]["L0"]["held"],
        "failed": 0,
        "known": 0,
        "undecided": 0,
        "skipped": 0,
    }
    assert code in {0, 1}
    assert report["levels"]["L2"]["failed"] <= 0.1 * report["levels"]["L2"]["held"], report["statement"]


@pytest.mark.skipif(COMPILER is None, reason="this machine has no C compiler")
def test_answers_of_the_c_template_are_read_from_a_folder(tmp_path: Path):
    (tmp_path / "solver.c").write_text(conform(tmp_path, "template", "c").stdout)
    subprocess.run([COMPILER, "-O2", "-o", "solver", "solver.c", "-lm"], cwd=tmp_path, check=True)
    conform(tmp_path, "export", "--out", "requests.jsonl", "--filter", "random-*")
    (tmp_path / "answers").mkdir()
    with (tmp_path / "requests.jsonl").open() as asked, (tmp_path / "answers" / "a.jsonl").open("w") as told:
        subprocess.run([tmp_path / "solver"], stdin=asked, stdout=told, check=True)
    code, report = judged(tmp_path, "--results", "answers", "--filter", "random-*")
    assert code == 0, report
    assert report["reached"] == "L3"
