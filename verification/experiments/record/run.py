"""A whole run: features, every configuration of every set by as many workers as wanted, and the record."""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from joblib import Parallel, delayed, parallel_config

from verification.experiments.design import Design
from verification.experiments.measure.configurations import Configuration
from verification.experiments.measure.evaluation import Task, evaluate
from verification.experiments.measure.features import prepare
from verification.experiments.measure.measured import Measured
from verification.experiments.record.collection import Collection
from verification.experiments.record.contents import ExperimentsData
from verification.experiments.record.judged import judged as judge
from verification.experiments.record.rankings import rankings
from verification.experiments.record.record import record
from verification.journal import Journal
from verification.provenance import code_digest, versions

SOURCE, SIMULATION = (
    ("convexperc", *(f"verification/experiments/{name}" for name in ("design.py", "scenes", "measure"))),
    "convexperc/simulation",
)
"""The code that measurements depend on; the simulation makes pictures, whose own digest counts."""

Progress = Callable[[str, int, int], None]
"""Told the stage, how much is done, and of how much."""


@dataclass(frozen=True, slots=True)
class Timed:
    """What a task found, and the seconds it took; None where it was read from the journal."""

    name: str
    found: dict[str, Any]
    seconds: float | None


def run(
    collections: Sequence[Collection],
    configurations: tuple[Configuration, ...],
    design: Design,
    *,
    cache: Path,
    journal: Path,
    workers: int,
    progress: Progress = lambda stage, done, total: None,
) -> ExperimentsData:
    """Measure and judge every configuration of every collection.

    Parameters
    ----------
    collections : sequence of Collection
        With different names.
    configurations : tuple of Configuration
        The default first.
    design : Design
    cache, journal : Path
        Folders for features and for finished configurations, made when missing. What is kept there of
        the same pictures, design and source is not done again.
    workers : int
        Processes; the record does not depend on it.
    progress : callable

    Returns
    -------
    ExperimentsData
        See `record`.
    """
    seconds: dict[str, float] = {}
    began = time.perf_counter()
    tasks: list[Task] = []
    for each in collections:
        parts = each.parts(cache)
        for part, pictures in zip(parts, (each.physical, each.study), strict=True):
            stage = f"features of {part.layout.name}"
            prepare(pictures, part.store, configurations, workers, _told(progress, stage))
        tasks += [Task(each.name, *parts, configuration, design) for configuration in configurations]
    seconds["features"] = time.perf_counter() - began
    journals = {
        each.name: Journal(journal / f"{each.name}.jsonl", _head(each, design)) for each in collections
    }
    found = _finish(tasks, journals, workers, progress)
    each_took = {timed.name: timed.seconds for timed in found.values() if timed.seconds is not None}
    seconds["readings"] = sum(each_took.values())
    with parallel_config(backend="loky", inner_max_num_threads=1):
        judgements = Parallel(n_jobs=workers)(
            delayed(_judged)(task, found[task.name].found) for task in tasks
        )
    judged: dict[str, list[dict[str, Any]]] = {each.name: [] for each in collections}
    for task, judgement in zip(tasks, judgements, strict=True):
        judged[task.collection].append(judgement)
    ranked = {each.name: rankings(*each.parts(cache), configurations[0]) for each in collections}
    return record(collections, judged, ranked, design, {"seconds": seconds, "workers": workers})


def _head(collection: Collection, design: Design) -> dict[str, Any]:
    """All that the measurements of a configuration depend on; how they are judged may change."""
    judging = ("resamples", "confidence")
    return {
        "design": {name: value for name, value in design.as_json().items() if name not in judging},
        "pictures": {collection.name: collection.digest},
        "source": code_digest(*SOURCE, without=SIMULATION),
        "versions": versions(),
    }


def _finish(
    tasks: Sequence[Task], journals: Mapping[str, Journal], workers: int, progress: Progress
) -> dict[str, Timed]:
    """What every task found, those of the journals first."""
    found: dict[str, Timed] = {}
    owners = {task.name: journals[task.collection] for task in tasks}
    for name, journal in owners.items():
        if name in journal.entries:
            found[name] = Timed(name, journal.entries[name], None)
    progress("configurations", len(found), len(tasks))
    missing = [task for task in tasks if task.name not in found]
    with parallel_config(backend="loky", inner_max_num_threads=1):
        done = Parallel(n_jobs=workers, return_as="generator_unordered", batch_size=1)
        for timed in done(delayed(_timed)(task) for task in missing):
            owners[timed.name].put(timed.name, timed.found)
            found[timed.name] = timed
            progress("configurations", len(found), len(tasks))
    return found


def _judged(task: Task, measured: dict[str, Any]) -> dict[str, Any]:
    layouts = task.physical.layout, task.study.layout
    return judge(Measured.from_json(measured, task.design, *layouts), task.configuration)


def _timed(task: Task) -> Timed:
    began = time.perf_counter()
    found = evaluate(task)
    return Timed(task.name, found, time.perf_counter() - began)


def _told(progress: Progress, stage: str) -> Callable[[int, int], None]:
    return lambda done, total: progress(stage, done, total)
