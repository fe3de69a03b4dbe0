"""Whatever a program does to the protocol is told as its fault, in time; its answer is judged even so."""

import json
import os
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from protocol_faults import answer

from convexperc import Problem
from convexperc.errors import InputError
from verification.conformance.answers import Answer, Refusal
from verification.conformance.doors import PATIENT, Command, Module, NotAskedError, Results
from verification.conformance.request import Request
from verification.conformance.suite import Selection, lines, run
from verification.conformance.vectors import all_vectors

HERE = Path(__file__).parent
PROGRAM = HERE / "protocol_faults.py"
ONE = Selection(only="one-view-00")
TWO = Selection(only="one-view-0[01]")
MALFORMED = Selection(only="malformed-0[0-2]")


SILENT = ("hangs", "not flushed", "no end of line")
MISTAKEN = ("wrong id", "no id", "one answer late", "key twice", "a list", "two objects in a line")
STALL = 1.0
"""Seconds to wait for an answer that never comes; a mistaken one comes within them."""


@pytest.fixture(scope="module")
def answers(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The right answers to what the programs are asked, by line."""
    patterns = ("one-view-0[0-5]", "random-*", "malformed-0[0-2]")
    asked = [line for only in patterns for line in lines(Selection(only=only))]
    file = tmp_path_factory.mktemp("protocol") / "answers.json"
    file.write_text(json.dumps({line: answer(line) for line in asked}))
    return file


def program(
    name: str, answers: Path | None, seconds: float = 20.0, starting: float = 0.0, sound: int = 0
) -> Command:
    """A program that shows its fault after `sound` requests; see `protocol_faults`."""
    words = [sys.executable, str(PROGRAM), name, str(sound), *([] if answers is None else [str(answers)])]
    return Command(words, seconds=seconds, starting=starting)


def test_the_program_without_a_fault_has_none():
    report = run(program("sound", None), Selection(only="one-view-*"))
    assert report.reached == "L3", report.findings
    report = run(program("sound", None), Selection(only="malformed"))
    assert not report.failed, report.failed


@pytest.mark.parametrize(
    ("name", "told", "answered"),
    [
        ("banner", "not JSON", True),
        ("debug lines", "iteration 1", True),
        ("wrong id", "asked was", False),
        ("no id", "asked was", False),
        ("one answer late", "first", False),
        ("no u", "has no u", False),
        ("too many weights", "w must have", False),
        ("NaN", "must be finite", False),
        ("infinity", "must be finite", False),
        ("numbers as words", "must be a number", False),
        ("nested", "must be a number", False),
        ("error for everything", "error: not today", False),
        ("error without a reason", "must say why", False),
        ("answer and error", "error stands beside", False),
        ("key twice", "a key twice", False),
        ("a list", "not a JSON object", False),
        ("two objects in a line", "not JSON", False),
        ("not UTF-8", "not JSON", True),
        ("huge output", "a line of more than", False),
        ("endless lines", "one line after the other", False),
        ("flood", "asked was one-view-00; and 997 more; writes one line after", False),
        ("does not start", "no licence", False),
        ("ends before it answers", "exit code 3", False),
        ("crashes", "signal SIGABRT", False),
        ("never reads", "no answer within", False),
        ("hangs", "no answer within", False),
        ("not flushed", "no answer within", False),
        ("no end of line", "no answer within", False),
        ("closes its output", "closed its output", False),
    ],
)
def test_a_fault_of_the_protocol_is_named(name: str, told: str, answered: bool, answers: Path):
    """Where the kit waits in vain, the program has answered before: its start takes none of the time."""
    if name in (*SILENT, *MISTAKEN):
        report, asked = run(program(name, answers, STALL, starting=30.0, sound=1), TWO), "one-view-01"
        assert report.counts("L2")["held"] == 1, report.findings
    else:
        seconds = STALL if name == "never reads" else 20.0
        report, asked = run(program(name, answers, seconds), ONE), "one-view-00"
    details = [each.detail for each in report.failed if each.level == "L0"]
    assert details, report.findings
    assert told in details[0], details
    held = {each.id for each in report.findings if (each.level, each.outcome) == ("L2", "held")}
    assert (asked in held) is answered, report.findings


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("silent on malformed", "no answer within"),
        ("ends on malformed", "exit code 4"),
        ("answers malformed", "answers where an error was due"),
    ],
)
def test_malformed_requests_want_an_error(name: str, told: str, answers: Path):
    report = run(program(name, answers, STALL if name == "silent on malformed" else 20.0), MALFORMED)
    assert report.counts("L0")["failed"] == 3, report.findings
    assert all(told in each.detail for each in report.failed), report.failed


def test_an_answer_that_comes_twice_is_a_fault_of_its_request_or_seen_at_the_end(answers: Path):
    first = run(program("answers twice", answers), ONE)
    assert [each.id for each in first.failed] == ["protocol"], first.failed
    both = run(program("answers twice", answers), TWO)
    assert [each.id for each in both.failed] == ["protocol", "one-view-00"], both.failed
    assert both.counts("L2")["held"] == 2


def test_what_comes_after_an_answer_belongs_to_its_request(answers: Path):
    for name, told in (("talks after it answers", "bye"), ("crashes after it answers", "SIGABRT")):
        with program(name, answers) as door:
            case, after = (lines(Selection(only=f"one-view-0{k}"))[0] for k in range(2))
            assert door.ask_malformed("one-view-00", case)[1] == []
            time.sleep(2.0)
            assert door.ask_malformed("one-view-01", after)[1] == []
            assert told in door.earlier()[0], name
            assert door.earlier() == []


@pytest.mark.parametrize(
    "name", ["ends after each", "ends later", "does not end", "blank lines", "keys beyond"]
)
def test_what_harms_nobody_is_no_fault(name: str, answers: Path):
    """Among them a program that is started for each request, and one that leaves a child with its output."""
    start = time.monotonic()
    report = run(program(name, answers), Selection(only="one-view-0[0-5]"))
    assert report.counts("L2")["held"] == 6, report.findings
    assert not report.failed, report.failed
    assert report.ignored == (("iterations",) if name == "keys beyond" else ())
    assert time.monotonic() - start < 60.0


def test_a_program_that_never_answers_is_given_up(answers: Path):
    """What was not asked is no failure and no pass, and what did fail is told first."""
    report = run(program("ends before it answers", answers), Selection(only="random-*"))
    assert [each.detail for each in report.failed] == ["ended with exit code 3 before it answered"] * 3
    rest = len({each.id for each in report.findings}) - 3
    assert sum((each.level, each.detail) == ("L0", "not asked") for each in report.open) == rest > 6
    assert not report.declined
    assert (
        f"3 failures on 3 requests. {rest} more were not asked: it was given up after 3" in report.statement
    )


def test_a_program_that_crashes_on_many_requests_is_asked_them_all(answers: Path):
    """Each start answers one request and crashes at the next."""
    report = run(program("crashes", answers, sound=1), Selection(only="random-*"))
    count = len({each.id for each in report.findings})
    assert report.counts("L2")["held"] == -(-count // 2)
    assert report.counts("L0") == {"held": -(-count // 2), "failed": count // 2}


def test_one_that_has_answered_is_given_up_late(answers: Path, tmp_path: Path):
    """It answers at its first start alone; `PATIENT` requests later it is given up."""
    (tmp_path / "dies.py").write_text(
        "import json, pathlib, sys\n"
        "mark = pathlib.Path('mark')\n"
        "if mark.exists(): sys.exit(5)\n"
        "mark.touch()\n"
        f"print(json.dumps(json.load(open({str(answers)!r}))[sys.stdin.readline().strip()]))\n"
    )
    request = next(each.request for each in all_vectors().problems if each.id == "one-view-00")
    with Command([sys.executable, "dies.py"], folder=tmp_path) as door:
        assert isinstance(door.ask(request).answer, Answer)
        for _ in range(PATIENT):
            assert "exit code 5" in door.ask(request).faults[0]
        with pytest.raises(NotAskedError, match=f"after {PATIENT} requests in a row"):
            door.ask(request)
        assert "exit code 5" in door.ask(request).faults[0], "it is tried anew"


def test_an_answer_that_cannot_be_read_does_not_take_the_time_of_one(answers: Path):
    start = time.monotonic()
    report = run(program("key twice", answers, 60.0, sound=1), TWO)
    assert "a key twice" in report.failed[0].detail
    assert time.monotonic() - start < 30.0


def test_large_requests_do_not_block():
    report = run(program("sound", None), Selection(only="large-0[67]"))
    assert report.counts("L2")["held"] == 2, report.findings
    rng = np.random.default_rng(0)
    large = Problem(rng.random((40, 400)), rng.random(400), lambda1=0.1, lambda2=0.1, lambda3=0.1)
    with program("never reads", None, STALL) as door:
        assert door.ask(Request("large", large)).faults == [f"did not read the request within {STALL:g} s"]


def test_what_cannot_be_asked_is_misuse():
    for seconds in (float("inf"), float("nan"), 0.0, 1e300):
        with pytest.raises(InputError, match="timeout must be seconds"):
            Command("true", seconds=seconds)
    for command in ("", '"open', "no-such-program-here"):
        with pytest.raises(InputError):
            Command(command).ask(all_vectors().problems[0].request)
    with pytest.raises(InputError, match=r"package\.module:function"):
        Module("solver.py")
    with pytest.raises(InputError, match=r"\*\.json"):
        Results(HERE, all_vectors().ids)


def test_a_function_has_its_own_process(tmp_path: Path):
    (tmp_path / "mine.py").write_text(
        "import os, numpy as np\n"
        "def sound(X, o, modalities, **weights):\n"
        "    print('{}')\n"
        "    from convexperc import Problem, solve\n"
        "    found = solve(Problem(X, o, modalities=modalities, **weights))\n"
        "    return found.w.astype(np.float64), found.u\n"
        "def crash(X, o, modalities, **weights):\n"
        "    os.abort()\n"
        "def changes(X, o, modalities, **weights):\n"
        "    found = sound(X, o, modalities, **weights)\n"
        "    X[0] += 1.0\n"
        "    modalities.clear()\n"
        "    return found\n"
        "def ends(X, o, modalities, **weights):\n"
        "    raise SystemExit(3)\n"
        "def declines(X, o, modalities, **weights):\n"
        "    raise NotImplementedError('only three robots')\n"
    )
    request = all_vectors().problems[0].request
    for name, kind in (("sound", Answer), ("declines", Refusal)):
        door = Module(f"mine:{name}", folder=tmp_path)
        reply = door.ask(request)
        assert isinstance(reply.answer, kind), reply
        assert not reply.faults, reply
        assert not door.close()
    reply = Module("mine:crash", folder=tmp_path).ask(request)
    assert "SIGABRT" in reply.faults[0], reply
    with Module("mine:ends", folder=tmp_path) as door:
        assert door.ask(request).answer == Refusal("error", "SystemExit: 3")
    with Module("mine:changes", folder=tmp_path) as door:
        reply = door.ask(request)
        assert isinstance(reply.answer, Answer)
        assert [each.split(",")[0] for each in reply.faults] == ["changes X", "changes modalities"]


def test_a_function_that_cannot_be_imported_is_misuse(tmp_path: Path):
    (tmp_path / "broken.py").write_text("def solve(:\n")
    (tmp_path / "ends.py").write_text("raise SystemExit(4)\n")
    request = all_vectors().problems[0].request
    for place, told in (
        ("nosuch:solve", "ModuleNotFoundError: No module named 'nosuch'"),
        ("broken:solve", "SyntaxError"),
        ("ends:solve", "SystemExit: 4"),
        ("json:nosuch", "AttributeError"),
    ):
        with Module(place, folder=tmp_path) as door, pytest.raises(InputError, match=told):
            door.ask(request)


def test_a_folder_called_like_the_kit_does_not_hide_it(tmp_path: Path):
    for name in ("verification", "convexperc"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "__init__.py").write_text("raise RuntimeError('hidden')\n")
    (tmp_path / "solver.py").write_text(
        "def solve(*data, **weights):\n    raise NotImplementedError('found')\n"
    )
    with Module("solver:solve", folder=tmp_path) as door:
        assert door.ask(all_vectors().problems[0].request).answer == Refusal("unsupported", "found")


def test_results_are_read_from_a_folder(tmp_path: Path):
    found = json.dumps(answer(*lines(ONE)))
    (tmp_path / "a.jsonl").write_text(f"{found}\nnothing\n")
    report = run(Results(tmp_path, all_vectors().ids), TWO)
    assert report.counts("L2")["held"] == 1
    assert [(each.id, each.detail) for each in report.failed] == [
        ("protocol", "a.jsonl:2: not JSON, or a key twice: nothing"),
        ("one-view-01", "no answer"),
    ]
    (tmp_path / "b.json").write_text(found)
    assert "2 answers" in run(Results(tmp_path, all_vectors().ids), ONE).failed[1].detail
    (tmp_path / "b.json").write_text(found.replace("one-view-00", "one-view-99"))
    assert (
        "answers one-view-99, which there is not"
        in run(Results(tmp_path, all_vectors().ids), ONE).failed[0].detail
    )


def test_what_is_no_file_of_answers_is_misuse(tmp_path: Path):
    def folder(name: str) -> Path:
        (tmp_path / name).mkdir()
        return tmp_path / name

    (folder("folder") / "x.json").mkdir()
    (folder("link") / "x.json").symlink_to("nowhere")
    os.mkfifo(folder("fifo") / "x.jsonl")
    (folder("list") / "x.json").write_text('[{"id": "a", "w": [0], "u": [0]},\n{"id": "b"}]')
    for name, told in (
        ("folder", "no ordinary file"),
        ("link", "leads nowhere"),
        ("fifo", "no ordinary file"),
        ("list", "must have one answer a line"),
    ):
        with pytest.raises(InputError, match=told):
            Results(tmp_path / name, all_vectors().ids)
