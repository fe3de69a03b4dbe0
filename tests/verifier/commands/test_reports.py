"""The command that makes the generated files anew: what it runs, what it leaves alone, and its exit code."""

import json
import subprocess
from pathlib import Path
from types import SimpleNamespace

import pytest
import typer
from typer.testing import CliRunner

from verification import provenance
from verification.__main__ import app
from verification.commands.reports import STEPS

RUNNER = CliRunner()


@pytest.fixture
def ran(monkeypatch: pytest.MonkeyPatch) -> list[list[str]]:
    """Commands in the order in which they were run; the second returns 3."""
    seen: list[list[str]] = []

    def run(words: list[str], **options: object) -> SimpleNamespace:
        seen.append(words[3:])
        return SimpleNamespace(returncode=3 if len(seen) == 2 else 0)

    monkeypatch.setattr(subprocess, "run", run)
    return seen


@pytest.mark.parametrize("name", STEPS)
def test_every_command_is_one_that_the_program_knows(name: str) -> None:
    program = typer.main.get_command(app)
    for command in STEPS[name].commands.values():
        first, *words = command.format(out="reports", jobs=2).split()
        context = program.commands[first].make_context(first, words)
        assert context.params, command


def test_everything_is_made_and_the_worst_exit_code_is_given(ran: list[list[str]], tmp_path: Path) -> None:
    result = RUNNER.invoke(app, ["reports", "--out", str(tmp_path), "--jobs", "1"])
    assert result.exit_code == 3, result.output
    assert [" ".join(words).split()[0] for words in ran] == [
        command.split()[0] for step in STEPS.values() for command in step.commands.values()
    ]
    assert all(str(tmp_path) in " ".join(words) for words in ran), ran


def test_what_the_present_code_has_made_is_left_alone(ran: list[list[str]], tmp_path: Path) -> None:
    code = provenance.code_digest(*provenance.SUBJECTS["faults"])
    for made, count in ((code, 0), ("0" * 64, 1)):
        (tmp_path / "faults.json").write_text(json.dumps({"made": {"code": made}}))
        result = RUNNER.invoke(app, ["reports", "--only", "faults", "--out", str(tmp_path)])
        assert (result.exit_code, len(ran)) == (0, count), result.output
        ran.clear()
    (tmp_path / "faults.json").write_text(json.dumps({"made": {"code": code}}))
    RUNNER.invoke(app, ["reports", "--only", "faults", "--out", str(tmp_path), "--again"])
    assert len(ran) == 1, ran


def test_a_step_that_is_not_there_is_misuse(ran: list[list[str]]) -> None:
    result = RUNNER.invoke(app, ["reports", "--only", "nothing"])
    assert result.exit_code == 2, result.output
    assert not ran
