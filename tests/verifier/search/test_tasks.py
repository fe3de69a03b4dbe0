"""Tasks in worker processes: all are run once, and a worker that is killed takes nothing else with it."""

import os
import signal
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from verification.journal import Journal
from verification.search.tasks import run_tasks


def square(number: int) -> int:
    return number * number


def dies(folder: Path, how: int, times: int) -> str:
    """End the process as often as that, and then return; each call leaves a file."""
    calls = len(list(folder.iterdir()))
    (folder / str(calls)).touch()
    if calls < times:
        os.kill(os.getpid(), how)
    return "survived"


def raises() -> None:
    raise ZeroDivisionError("planted")


SQUARES = {f"square {k}": partial(square, k) for k in range(8)}


class Taken(dict[str, Any]):
    """Takes each name once."""

    def __call__(self, name: str, data: Any) -> None:
        assert name not in self, name
        self[name] = data


@pytest.mark.parametrize("jobs", [1, 2])
def test_every_task_that_the_journal_lacks_is_run_once(tmp_path: Path, jobs: int) -> None:
    journal, taken = Journal(tmp_path / "run.jsonl", {}), Taken()
    journal.put("square 3", "kept")
    assert not run_tasks(SQUARES, taken, jobs=jobs, journal=journal)
    squares = {f"square {k}": k * k for k in range(8)}
    assert taken == {name: data for name, data in squares.items() if name != "square 3"}
    assert Journal(tmp_path / "run.jsonl", {}).entries == squares | {"square 3": "kept"}


@pytest.mark.parametrize("jobs", [1, 2])
def test_an_exception_of_a_task_ends_the_run(jobs: int) -> None:
    with pytest.raises(ZeroDivisionError, match="planted"):
        run_tasks({"bad": raises}, Taken(), jobs=jobs)


def test_a_killed_worker_loses_the_task_that_kills_it_again_and_no_other(tmp_path: Path) -> None:
    folders = {name: tmp_path / name for name in ("once", "always", "segfault")}
    for folder in folders.values():
        folder.mkdir()
    names = list(SQUARES)
    tasks: dict[str, Any] = {name: SQUARES[name] for name in names[:3]}
    tasks["once"] = partial(dies, folders["once"], signal.SIGKILL, 1)
    tasks |= {name: SQUARES[name] for name in names[3:6]}
    tasks["always"] = partial(dies, folders["always"], signal.SIGKILL, 9)
    tasks["segfault"] = partial(dies, folders["segfault"], signal.SIGSEGV, 9)
    tasks |= {name: SQUARES[name] for name in names[6:]}
    journal, taken = Journal(tmp_path / "run.jsonl", {}), Taken()
    lost = run_tasks(tasks, taken, jobs=2, journal=journal)
    assert set(lost) == {"always", "segfault"}, lost
    assert "SIGKILL" in lost["always"], lost
    assert "SIGSEGV" in lost["segfault"], lost
    assert taken == {f"square {k}": k * k for k in range(8)} | {"once": "survived"}
    assert journal.entries == taken, "what is lost is not kept: a resumed run tries it again"
    assert all(len(list(folder.iterdir())) <= 2 for folder in folders.values()), "once more, and not again"
