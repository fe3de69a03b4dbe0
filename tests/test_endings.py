"""How a command of either program ends: its exit code, at most a few lines, and never a traceback."""

import errno
import os
import re
import signal
import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest
import typer
from typer.testing import CliRunner

import convexperc
import verification
from convexperc.cli.ending import ended_in_order
from convexperc.cli.main import app as library
from convexperc.cli.program import Program
from convexperc.errors import InputError, MissingExtraError, SlowWarning, SolverError
from convexperc.files import write_json
from convexperc.problem.files import problem_record
from convexperc.problem.problem import Problem
from convexperc.report import proof_record
from convexperc.simulation import RenderingError
from convexperc.solution.single import solve
from verification.__main__ import app as verifier

ROOTS = [Path(package.__file__).parent for package in (convexperc, verification)]
BUFFERED = {name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"}
ENVIRONMENT = BUFFERED | {"COLUMNS": "100", "NO_COLOR": "1", "PYTHONPATH": str(ROOTS[0].parent)}
COMMANDS = [
    "convexperc certify problem.json answer.json",
    "convexperc --help",
    "convexperc --version",
    "convexperc simulate example",
    "verification check proof.json",
    "verification list",
    "verification families",
]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with a problem, an answer to it, and a proof."""
    place = tmp_path_factory.mktemp("endings")
    X = np.random.default_rng(7).normal(size=(4, 6))
    solution = solve(Problem(X, X[0], modalities={"a": 3, "b": 3}, lambda1=0.2, lambda2=0.6, lambda3=0.1))
    write_json(place / "problem.json", problem_record(solution.problem))
    write_json(place / "answer.json", {"w": solution.w.tolist(), "u": solution.u.tolist()})
    write_json(place / "proof.json", proof_record(solution))
    return place


def python(arguments, folder, *options, **streams):
    """Run ``python OPTIONS -m ARGUMENTS``."""
    command = [sys.executable, *options, "-m", *arguments.split()]
    streams = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE} | streams
    return subprocess.run(command, check=False, cwd=folder, env=ENVIRONMENT, text=True, **streams)


def ended(act):
    """What a command that does this prints, and its exit code."""
    app = typer.Typer(cls=Program, pretty_exceptions_enable=False)
    app.command("one")(act)
    app.command("other")(lambda: None)
    return CliRunner().invoke(app, ["one"])


def raised(error):
    """The same where it raises."""

    def act():
        raise error

    return ended(act)


@pytest.mark.parametrize(
    ("error", "code", "line"),
    [
        (InputError("X", value=[], must="must be 2-D"), 2, "error: X must be 2-D; got []."),
        (MissingExtraError("it", value=1, must="needs that"), 2, "error: it needs that; got 1."),
        (RenderingError("GL", value="glfw", must="must be egl"), 2, "error: GL must be egl; got 'glfw'."),
        (typer.BadParameter("none", param_hint="--it"), 2, "error: Invalid value for --it: none"),
        (typer.Exit(3), 3, None),
        (KeyboardInterrupt(), 130, "interrupted"),
        (MemoryError("Unable to allocate 8 GiB"), 71, "error: out of memory. Unable to allocate 8 GiB"),
        (MemoryError(), 71, "error: out of memory."),
        (OSError(errno.EIO, "no disk"), 74, "error: reading or writing failed: [Errno 5] no disk"),
        (OSError(5, "no disk", "a\nb"), 74, r"error: reading or writing failed: [Errno 5] no disk: 'a\nb'"),
        (BrokenPipeError(32, "a worker's"), 74, "error: reading or writing failed: [Errno 32] a worker's"),
    ],
    ids=lambda value: type(value).__name__,
)  # fmt: skip
def test_what_a_command_raises_is_a_code_and_one_line(error, code, line):
    done = raised(error)
    assert done.exit_code == code, done
    assert done.stderr == ("" if line is None else f"{line}\n")
    assert done.stdout == ""


@pytest.mark.parametrize(
    "error",
    [
        ZeroDivisionError("one\x1b[31m\nproved"),
        EOFError("a file ends early"),
        SolverError("solver", value=1, must="must answer"),
        RecursionError("deep"),
        OSError("not of the system"),
    ],
    ids=lambda error: type(error).__name__,
)
def test_a_fault_is_70_with_a_line_and_the_traceback_in_a_file(error, tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    done = raised(error)
    assert done.exit_code == 70, done
    told, report = done.stderr.splitlines()
    assert told.startswith(f"internal error: {type(error).__name__}: "), told
    assert "\x1b" not in told
    (file,) = tmp_path.iterdir()
    assert str(file) in report, report
    text = file.read_text(encoding="utf-8")
    assert "Traceback (most recent call last)" in text, text
    assert str(error) in text, text


def test_a_fault_is_told_in_full_where_no_file_can_be_written(tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "none"))
    done = raised(ZeroDivisionError("planted"))
    assert done.exit_code == 70, done
    assert "Traceback (most recent call last)" in done.stderr
    assert done.stderr.rstrip().endswith("ZeroDivisionError: planted"), done.stderr


@pytest.mark.parametrize(
    ("category", "line"),
    [(SlowWarning, r"warning: slow\n"), (RuntimeWarning, r"warning: RuntimeWarning: slow\n")],
    ids=["ours", "another"],
)
def test_a_warning_is_one_line_without_a_place_in_the_code(category, line):
    with warnings.catch_warnings():
        warnings.simplefilter("always")
        before = warnings.filters, warnings.showwarning
        done = ended(lambda: warnings.warn("slow\n", category, stacklevel=1))
        assert (warnings.filters, warnings.showwarning) == before
    assert (done.exit_code, done.stderr) == (0, line + "\n")


def test_both_programs_end_that_way():
    for app in (library, verifier):
        assert isinstance(typer.main.get_command(app), Program), app.info.name


@pytest.mark.parametrize("command", COMMANDS)
def test_what_cannot_be_written_has_a_code_of_its_own(command, folder):
    with Path("/dev/full").open("w") as full:
        done = python(command, folder, stdout=full)
        assert done.returncode == 74, done
        (line,) = done.stderr.splitlines()
        assert line == "error: reading or writing failed: [Errno 28] No space left on device"
        assert python(command, folder, stdout=full, stderr=full).returncode == 74


@pytest.mark.parametrize("command", COMMANDS)
def test_a_reader_that_has_gone_ends_a_command_quietly(command, folder):
    reading, writing = os.pipe()
    os.close(reading)
    with os.fdopen(writing, "wb") as stream:
        done = python(command, folder, stdout=stream)
        assert (done.returncode, done.stderr) == (141, ""), done
        assert python(command, folder, stdout=stream, stderr=stream).returncode == 141


@pytest.mark.parametrize("command", COMMANDS)
def test_a_closed_output_is_nobody_to_tell(command, folder):
    words = f"{sys.executable} -m {command} >&-"
    done = subprocess.run(words, shell=True, check=False, cwd=folder, env=ENVIRONMENT, capture_output=True)
    assert (done.returncode, done.stderr) == (0, b""), done


@pytest.mark.parametrize(
    "program", ["convexperc.problem.files.read_problem", "verification.proof_checker.check"]
)
def test_an_interruption_is_130(program, folder):
    package, _, name = program.rpartition(".")
    arguments = ["solve", "problem.json"] if "convexperc" in program else ["check", "proof.json"]
    code = (
        f"import os, signal, sys\nimport {package} as module\n"
        f"sys.argv = ['program', *{arguments}]\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)  # a background job starts without it\n"
        f"module.{name} = lambda path: os.kill(os.getpid(), signal.SIGINT)\n"
        f"from {package.partition('.')[0]}.__main__ import main\nmain()"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], check=False, cwd=folder, env=ENVIRONMENT, capture_output=True, text=True
    )
    assert (done.returncode, done.stderr) == (128 + signal.SIGINT, "interrupted\n"), done


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_what_is_being_written_is_taken_away_where_the_system_ends_a_command(number, folder, tmp_path):
    code = (
        "import os, sys\n"
        f"sys.argv = ['program', 'solve', 'problem.json', '--json', {str(tmp_path / 'out.json')!r}]\n"
        f"os.fsync = lambda descriptor: os.kill(os.getpid(), {int(number)})\n"
        "from convexperc.__main__ import main\nmain()"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], check=False, cwd=folder, env=ENVIRONMENT, capture_output=True, text=True
    )
    assert (done.returncode, done.stderr) == (128 + number, "terminated\n"), done
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("forked", [False, True])
def test_an_ignored_signal_stays_so_and_a_fork_ends_by_it(forked):
    with ended_in_order():
        child = os.fork()
        if child == 0:
            if not forked:
                signal.signal(signal.SIGTERM, signal.SIG_IGN)
                with ended_in_order():
                    os.kill(os.getpid(), signal.SIGTERM)
                    os._exit(5)
            os.kill(os.getpid(), signal.SIGTERM)
            os._exit(6)
        _, status = os.waitpid(child, 0)
    assert os.waitstatus_to_exitcode(status) == (-signal.SIGTERM if forked else 5)
    assert signal.getsignal(signal.SIGTERM) == signal.SIG_DFL


@pytest.mark.parametrize("command", [*COMMANDS, "convexperc solve --help", "verification report --help"])
def test_without_docstrings_the_same_is_said(command, folder):
    plain, bare = python(command, folder), python(command, folder, "-OO")
    assert plain.returncode == 0, plain
    assert (bare.returncode, bare.stdout) == (0, plain.stdout), bare


def test_no_docstring_is_data():
    """They are gone under ``python -OO``."""
    code = {file: file.read_text(encoding="utf-8") for root in ROOTS for file in root.rglob("*.py")}
    assert not [file for file, text in code.items() if re.search(r"__doc__|getdoc\(", text)]
    texts = [command.help for app in (library, verifier) for command in app.registered_commands]
    assert all(texts), texts
