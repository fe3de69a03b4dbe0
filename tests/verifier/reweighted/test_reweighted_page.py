"""docs/reweighted.md: its files give what it says, by the command."""

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from verification.__main__ import app
from verification.reweighted import judge_term
from verification.reweighted.gallery import CASES
from verification.reweighted.gallery.page import markdown
from verification.reweighted.gallery.records import stored, stored_records
from verification.reweighted.loops.judging import QUESTIONS
from verification.reweighted.programs.inputs import arrays, digest

PAGE = Path(__file__).parents[3] / "docs" / "reweighted.md"
RUNNER = CliRunner(env={"COLUMNS": "140", "TERM": "dumb", "NO_COLOR": "1"})


def block(number: int) -> str:
    return re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), flags=re.S)[number]


def table() -> dict[str, tuple[str, str]]:
    """The answers that the page tells of its first file."""
    rows = re.findall(
        r"^\| (\w+) \| (yes|no|undecided) \| (.*) \|$", PAGE.read_text(encoding="utf-8"), flags=re.M
    )
    return {question: (word, statement) for question, word, statement in rows}


def judged(text: str, folder: Path) -> tuple[int, dict[str, dict[str, str]]]:
    """The exit code of `loops` for a file, and its answers by question."""
    file, answers = folder / "stated.py", folder / "answers.json"
    file.write_text(text, encoding="utf-8")
    done = RUNNER.invoke(app, ["loops", str(file), "--json", str(answers)])
    found = json.loads(answers.read_text(encoding="utf-8"))
    assert found["subject"] == "stated"
    return done.exit_code, {each["question"]: each for each in found["answers"]}


def test_ten_lines_give_the_failure_and_the_repair(tmp_path: Path) -> None:
    assert len([line for line in block(0).splitlines() if line.strip()]) <= 10
    code, found = judged(block(0), tmp_path)
    assert code == 1, found
    told = table()
    assert set(told) < set(found)
    for question, (word, statement) in told.items():
        assert (found[question]["answer"], found[question]["statement"]) == (word, statement)

    code, found = judged(block(0).replace('at_zero="hold"', 'at_zero="leave"'), tmp_path)
    assert code == 0, found


def test_twenty_lines_give_the_papers_rise(tmp_path: Path) -> None:
    assert len([line for line in block(1).splitlines() if line.strip()]) <= 20
    code, found = judged(block(1), tmp_path)
    assert code == 1, found
    rise = found["descends"]
    assert "weight 1/(4*r)" in found["terms"]["statement"]
    first, second = re.search(
        r"rises from (\S+) to (\S+) in the second", PAGE.read_text(encoding="utf-8")
    ).groups()  # type: ignore[union-attr]
    assert rise["statement"] == f"F rises in iteration 2, from {first} to {second}."


def test_the_second_pair_is_what_the_page_says() -> None:
    lines = [line for line in block(2).splitlines() if line.startswith("print(")]
    smoothed, wrong = (eval(line.removeprefix("print")) for line in lines)
    assert not smoothed.faults
    assert {answer.question for answer in wrong.faults} == {"tangent", "units"}
    assert judge_term is not None


def test_the_programs_of_the_page_are_judged_as_it_says(capsys: pytest.CaptureFixture[str]) -> None:
    exec(compile(block(3), str(PAGE), "exec"), {})
    floored, exact = capsys.readouterr().out.split("exact, tolerance", maxsplit=1)
    assert re.search(r"as given +yes", floored)
    assert re.search(r"other units +no", floored)
    assert " no " not in exact.replace("It gave no warnings.", "")


def test_the_recorded_answers_of_the_page_are_judged_as_the_program(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {}
    exec(compile(block(3), str(PAGE), "exec"), names)
    capsys.readouterr()
    exec(compile(block(4), str(PAGE), "exec"), names)
    before = capsys.readouterr().out
    assert not re.search(r" (yes|no)  ", before.partition("  record ")[0]), before

    answers = names["folder"] / "answers.jsonl"
    for line in (names["folder"] / "inputs.jsonl").read_text(encoding="utf-8").splitlines():
        asked = json.loads(line)
        answer = names["floored"](np.array(asked["input"]["y"]))
        with answers.open("a", encoding="utf-8") as taken:
            taken.write(json.dumps({"id": asked["id"], "answer": answer}) + "\n")
    exec(compile(block(4), str(PAGE), "exec"), names)
    after = capsys.readouterr().out
    assert re.search(r"as given +yes", after)
    assert re.search(r"other units +no", after)
    assert re.search(r"ask twice +undecided +Not asked", after)
    assert re.search(r"record +yes", after)
    shown = re.search(
        r'^    (\{"id".*"input".*)\n    (\{.*"answer".*)$', PAGE.read_text(encoding="utf-8"), re.M
    )
    assert shown is not None
    line, told = (json.loads(each) for each in shown.groups())
    assert line["id"] == told["id"] == digest("", arrays(line["input"]))


@pytest.mark.parametrize("case", CASES)
def test_the_gallery_is_stored_with_the_answers_of_every_case(case: str) -> None:
    assert [answer["question"] for answer in stored()["cases"][case]["answers"]] == list(QUESTIONS)


def test_the_committed_page_of_the_gallery_is_that_of_what_is_stored() -> None:
    page = PAGE.parents[1] / "reports" / "loops.md"
    assert page.read_text(encoding="utf-8") == markdown(stored())
    assert len(CASES) >= 12


@pytest.mark.parametrize("name", list(stored_records()))
def test_a_stored_instance_is_confirmed_again(name: str) -> None:
    record = stored_records()[name]
    assert record.is_confirmed
    assert record.table(2)


def test_a_stored_instance_is_replayed(tmp_path: Path) -> None:
    name = next(name for name in stored_records() if name.startswith("paper-printed-descends"))
    picture = tmp_path / "F.svg"
    done = RUNNER.invoke(app, ["loops", name, "--plot", str(picture)])
    assert done.exit_code == 0, done.output
    assert "confirmed again" in done.output
    assert picture.read_bytes().startswith(b"<?xml")


@pytest.mark.parametrize(
    ("arguments", "what"),
    [
        (["no-such-case"], "must be one of"),
        (["nowhere.py"], "must be a Python file"),
    ],
)
def test_misuse_of_the_command(arguments: list[str], what: str) -> None:
    done = RUNNER.invoke(app, ["loops", *arguments])
    assert done.exit_code == 2
    assert what in done.output.replace("\n", " ")
