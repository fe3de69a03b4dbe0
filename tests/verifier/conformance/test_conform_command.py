"""The commands of the kit: exit codes, misuse, files."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from verification.__main__ import app

LIBRARY = ("--module", "verification.conformance.adapters:library")


def ran(*words: str):
    return CliRunner().invoke(app, ["conform", *words])


def test_a_sound_solver_ends_with_0_and_files(tmp_path: Path):
    done = ran(*LIBRARY, "--filter", "random-*", "--out", str(tmp_path / "new"), "--max-examples", "30")
    assert done.exit_code == 0, done.output
    assert "reaches L3" in done.output
    assert "search: 58 requests" in done.output
    record = json.loads((tmp_path / "new" / "report.json").read_text())
    assert record["search"]["found"] == []
    assert {each.name for each in (tmp_path / "new").iterdir()} == {"report.html", "report.json", "junit.xml"}


def test_a_solver_that_declines_ends_with_3():
    done = ran("--module", "verification.conformance.adapters:sklearn_lasso", "--filter", "random-*")
    assert done.exit_code == 3, done.output


def test_a_faulty_solver_ends_with_1_unless_that_is_known(tmp_path: Path):
    words = ("--module", "verification.conformance.adapters:paper_printed", "--filter", "random-0[0-2]")
    done = ran(*words, "--out", str(tmp_path))
    assert done.exit_code == 1, done.output
    failed = json.loads((tmp_path / "report.json").read_text())["findings"]
    known = tmp_path / "known"
    known.write_text(
        "".join(f"{each['id']} {each['level']}\n" for each in failed if each["outcome"] == "failed")
    )
    done = ran(*words, "--known", str(known))
    assert done.exit_code == 0, done.output


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ((), "give one of"),
        ((*LIBRARY, "--command", "true"), "give one of"),
        ((*LIBRARY, "--profile", "float16"), "must be one of float64, float32"),
        ((*LIBRARY, "--filter", "no-such-id"), "must match an id"),
        (("--module", "solver.py"), "package.module:function"),
        (("--module", "nosuch:solve"), "No module named 'nosuch'"),
        ((*LIBRARY, "--timeout", "inf"), "must be seconds"),
        ((*LIBRARY, "--out", "taken"), "no ordinary file"),
        (("--command", "no-such-program-here"), "can be started"),
        (("--results", "."), "*.json"),
        ((*LIBRARY, "--known", "no-such-file"), "readable text file"),
        (("--results", ".", "--max-examples", "10"), "can be asked"),
        (("template", "cobol"), "must be one of c, python"),
        (("vectors",), "give one of"),
    ],
)
def test_misuse_ends_with_2(
    words: tuple[str, ...], told: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "taken" / "report.json").mkdir(parents=True)
    done = ran(*words)
    assert done.exit_code == 2, done.output
    assert told in " ".join(done.output.replace("│", " ").split()), done.output


def test_requests_are_exported(tmp_path: Path):
    out = tmp_path / "requests.jsonl"
    assert ran("export", "--out", str(out)).exit_code == 0
    lines = out.read_text().splitlines()
    assert "{" in lines, "malformed ones as well"
    ids = [json.loads(line)["id"] for line in lines if line.startswith('{"id"') and "malformed-" not in line]
    assert len(ids) == len(set(ids)) > 500


def test_the_proofs_of_the_vectors_are_checked():
    done = ran("vectors", "--check")
    assert done.exit_code == 0, done.output
    assert "every proof holds" in done.output
