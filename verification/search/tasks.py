"""Tasks by name in worker processes: journaled, resumed, and safe against a worker that is killed.

The workers are joblib's: under ``joblib.parallel_config(backend="dask")`` they are those of a Dask cluster.
"""

import re
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import BrokenExecutor
from typing import Any

from verification.journal import Journal

Task = Callable[[], Any]
"""Returns plain data; a worker receives it pickled."""

IN_TURN = 2
"""joblib starts worker processes from two on; a single task then has a process to itself."""


def run_tasks(
    tasks: Mapping[str, Task],
    take: Callable[[str, Any], None],
    *,
    jobs: int = 1,
    journal: Journal | None = None,
) -> dict[str, str]:
    """Run every task that the journal does not keep yet, in any order.

    When a worker process is killed, all workers end, and with them the tasks that had been given out and had
    not returned. Each of these is run again while nothing else runs: the one that ends its process then is
    lost, and the others go on.

    Parameters
    ----------
    tasks : dict of str to callable
        By name. An exception of a task ends the run.
    take : callable
        Called in this process with the name of each task that was run and what it returned.
    jobs : int
        Worker processes. 1 runs every task in this process, which a task then can kill.
    journal : Journal, optional
        Keeps what tasks return; those that are lost are tried again by a resumed run.

    Returns
    -------
    dict of str to str
        For each task that is lost, how its worker ended.
    """
    done = set() if journal is None else set(journal.entries)

    def keep(name: str, data: Any) -> None:
        done.add(name)
        if journal is not None:
            journal.put(name, data)
        take(name, data)

    rest = [name for name in tasks if name not in done]
    if jobs > 1:
        with warnings.catch_warnings():
            # joblib replaces a worker that has grown large; what it had to do is done all the same
            warnings.filterwarnings("ignore", message="A worker stopped", category=UserWarning)
            return _in_workers(rest, tasks, keep, done, jobs)
    for name in rest:
        keep(name, tasks[name]())
    return {}


def _in_workers(
    names: list[str], tasks: Mapping[str, Task], keep: Callable[[str, Any], None], done: set[str], jobs: int
) -> dict[str, str]:
    """Run tasks by `jobs` workers, started anew whenever one of them is killed."""
    lost = dict[str, str]()
    while rest := [name for name in names if name not in done and name not in lost]:
        given = list[str]()
        if _ending(rest, tasks, keep, jobs, given):
            for name in (each for each in given if each not in done):
                if ending := _ending([name], tasks, keep, IN_TURN, []):
                    lost[name] = f"its worker process ended while nothing else ran: {ending}"
    return lost


def _ending(
    names: Iterable[str],
    tasks: Mapping[str, Task],
    keep: Callable[[str, Any], None],
    jobs: int,
    given: list[str],
) -> str:
    """Run tasks until all are done, or a worker ends: how it ended. `given` gets the names given out."""
    from joblib import Parallel, delayed  # noqa: PLC0415 - comes with an extra, and one process needs none

    def calls() -> Iterator[Any]:
        for name in names:
            given.append(name)
            yield delayed(_named)(name, tasks[name])

    workers = Parallel(n_jobs=jobs, return_as="generator_unordered", batch_size=1)
    try:
        for name, data in workers(calls()):
            keep(name, data)
    except BrokenExecutor as error:
        codes = re.search(r"exit codes of the workers are (.*)", str(error))
        return codes[1] if codes else str(error)
    return ""


def _named(name: str, task: Task) -> tuple[str, Any]:
    return name, task()
