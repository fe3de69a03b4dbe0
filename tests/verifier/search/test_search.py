"""The search: repeatable, resumable, honest about what it did not reach, and able to shrink."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path

import joblib
import numpy as np
import pytest

from convexperc.problem.problem import Problem
from verification.checks.interface import Check, Observation, Player, Recorder
from verification.journal import Journal
from verification.ledger.evidence import Outcome
from verification.problems.families import seeded
from verification.problems.sources import Seeded, Source
from verification.search import engine
from verification.search.engine import Result, plan, search
from verification.search.profiles import PROFILES, Profile
from verification.search.shards import UNBOUNDED, Found, Shard, _decade, explore, plain, problem_of, size_of

PART = "F1/bounded"
OTHER = "F1/convex"
FAMILIES = ("random", "zero_row", "lambda3_zero")
SMALL = Profile("small", problems=20, shard=8, hunts=True, per_scale=1)


def large_entry(problem: Problem, source: Source) -> Iterator[Observation]:
    """Fails where some |X_ij| >= 2; held otherwise."""
    largest = float(np.abs(problem.X).max())
    yield Observation.of(PART, largest < 2.0, largest, f"largest entry {largest}")
    yield Observation(OTHER, Outcome.UNDECIDED, float(source.integer(0, 3)))


def breaks(problem: Problem, source: Source) -> Iterator[Observation]:
    raise AssertionError(f"{problem.n} robots")
    yield Observation.of(PART, True)


def kills(problem: Problem, source: Source) -> Iterator[Observation]:
    os.kill(os.getpid(), signal.SIGKILL)
    yield Observation.of(PART, True)


LARGE = Check("large", (PART, OTHER), large_entry, FAMILIES)
BROKEN = Check("broken", (PART,), breaks, ("random",))
KILLER = Check("killer", (OTHER,), kills, ("random",), share=0.2)


def summary(result: Result) -> list[object]:
    return sorted((key, asdict(tally)) for key, tally in result.tallies.items())


@pytest.fixture(scope="module")
def unbroken() -> Result:
    return search([LARGE], SMALL, 3)


def test_every_family_is_counted_as_often_as_the_profile_says(unbroken: Result) -> None:
    assert unbroken.problems == {("large", family): 20 for family in FAMILIES}, unbroken.problems
    assert not unbroken.unreached, unbroken.unreached
    assert not unbroken.broken, unbroken.broken
    for family in FAMILIES:
        outcomes = unbroken.tallies[PART, family].outcomes
        assert sum(outcomes.values()) == 20, (family, outcomes)
        assert outcomes["failed"] > 0 < outcomes["held"], (family, outcomes)
        assert unbroken.tallies[OTHER, family].outcomes["undecided"] == 20, family


def test_a_failure_is_shrunk_to_the_smallest(unbroken: Result) -> None:
    _, case = unbroken.smallest()[PART]
    problem = problem_of(case.problem)
    assert (problem.n, problem.d) == (1, 1), case
    assert np.abs(problem.X).tolist() == [[2.0]], case
    assert problem.o.tolist() == [0.0], case
    again = list(large_entry(problem, Player(case.drawn)))
    assert again[0].outcome is Outcome.FAILED, again
    assert size_of(problem) == case.size, case


@pytest.mark.parametrize("jobs", [1, 2])
def test_the_outcome_does_not_depend_on_the_workers(unbroken: Result, jobs: int) -> None:
    assert summary(search([LARGE], SMALL, 3, jobs=jobs)) == summary(unbroken)


def test_another_seed_finds_something_else(unbroken: Result) -> None:
    assert summary(search([LARGE], SMALL, 4)) != summary(unbroken)


def test_a_broken_run_goes_on_where_it_was(unbroken: Result, tmp_path: Path) -> None:
    keep, file, head = 3, tmp_path / "run.jsonl", {"seed": 3}
    search([LARGE], SMALL, 3, journal=Journal(file, head))
    lines = file.read_text().splitlines(keepends=True)
    file.write_text("".join(lines[: 1 + keep]) + lines[1 + keep][:-20])  # the last line was cut off
    journal = Journal(file, head)
    assert len(journal.entries) == keep, journal.entries
    kept = dict(journal.entries)
    result = search([LARGE], SMALL, 3, journal=journal)
    assert summary(result) == summary(unbroken)
    assert all(journal.entries[key] is found for key, found in kept.items()), "a kept shard was done again"


def test_an_exception_of_a_check_is_told_not_hidden() -> None:
    result = search([BROKEN], SMALL, 0)
    assert len(result.broken) == 20, result.broken
    assert "broken on broken|random" in result.broken[0], result.broken
    assert "AssertionError" in result.broken[0], result.broken


def test_an_exception_of_a_check_while_a_failure_is_shrunk_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    def exploring(shard: Shard, check: Check, seed: int) -> Found:
        return explore(shard, BROKEN if shard.hunt else check, seed)

    monkeypatch.setattr(engine, "explore", exploring)
    result = search([LARGE], SMALL, 3)
    assert result.broken, "nothing was shrunk"
    assert all("robots" in each and f"|{PART}" in each for each in result.broken), result.broken


def test_a_check_that_kills_its_process_loses_its_shard_only(unbroken: Result, tmp_path: Path) -> None:
    journal = Journal(tmp_path / "run.jsonl", {"seed": 3})
    result = search([LARGE, KILLER], SMALL, 3, jobs=2, journal=journal)
    lost = Shard("killer", "random", 0, 4).key
    assert len(result.broken) == 1, result.broken
    assert result.broken[0].startswith(f"shard {lost} is lost: "), result.broken
    assert "SIGKILL" in result.broken[0], result.broken
    assert result.unreached == ["killer was not tried on random"]
    assert summary(result) == summary(unbroken)
    assert lost not in journal.entries, journal.entries.keys()


def test_a_family_that_no_problem_came_from_is_told() -> None:
    shards = [shard for shard in plan([LARGE], SMALL) if shard.family != "zero_row"]
    found = [explore(shard, LARGE, 3) for shard in shards]
    assert Result.of(found, [LARGE]).unreached == ["large was not tried on zero_row"]


def test_targeting_drives_the_measure_up() -> None:
    shard = Shard("large", "random", 0, 200)
    found = explore(shard, LARGE, 0)
    assert found.problems == 200, found.problems
    assert found.tallies[PART].worst == 3.0, found.tallies[PART]


@pytest.mark.parametrize(
    ("measure", "decade"),
    [(0.5, 0), (1.0, 0), (1.5, 1), (10.0, 1), (10.5, 2), (0.05, -1), (0.0, -400), (np.inf, UNBOUNDED)],
)
def test_a_decade_ends_with_its_power_of_ten(measure: float, decade: int) -> None:
    assert _decade(measure) == decade


def test_what_a_check_draws_can_be_drawn_again() -> None:
    recorder = Recorder(Seeded(np.random.default_rng(5), (3, 4)))
    drawn = recorder.integer(-9, 9), recorder.choice("abcdef"), recorder.matrix(2, 3)
    player = Player(recorder.drawn)
    again = player.integer(-9, 9), player.choice("abcdef"), player.matrix(2, 3)
    assert drawn[:2] == again[:2], (drawn, again)
    assert np.array_equal(drawn[2], again[2]), (drawn, again)


@pytest.mark.parametrize("family", ["random", "mixed_scales", "subnormal_entries", "one_column_modalities"])
def test_a_problem_survives_json(family: str) -> None:
    problem = seeded(family, 1, 2, largest=(4, 8))
    again = problem_of(plain(problem))
    assert np.array_equal(again.X, problem.X), family
    assert np.array_equal(again.o, problem.o), family
    assert (again.lambdas, again.modalities.sizes) == (problem.lambdas, problem.modalities.sizes), family


def test_the_full_profile_tries_more_than_a_million_cases() -> None:
    from verification.checks.catalogue import CHECKS  # noqa: PLC0415 - only this test needs all checks

    parts = {check.name: len(check.parts) * check.product for check in CHECKS}
    cases = sum(shard.problems * parts[shard.check] for shard in plan(CHECKS, PROFILES["full"]))
    assert cases >= 1_000_000, cases


SCRIPT = """
import sys, time
from pathlib import Path
sys.path.insert(0, {folder!r})
from test_search import LARGE, SMALL
from verification.search.engine import search
from verification.journal import Journal
journal = Journal(Path({file!r}), {{"seed": 3}})
search([LARGE], SMALL, 3, journal=journal, progress=lambda found: time.sleep(0.2))
"""


def test_nothing_is_lost_by_a_kill(unbroken: Result, tmp_path: Path) -> None:
    file = tmp_path / "run.jsonl"
    script = SCRIPT.format(folder=str(Path(__file__).parent), file=str(file))
    for how in (signal.SIGKILL, signal.SIGTERM):
        child = subprocess.Popen([sys.executable, "-c", script], env=dict(os.environ))
        before = len(file.read_text().splitlines()) if file.exists() else 0
        deadline = time.monotonic() + 60.0
        while not file.exists() or len(file.read_text().splitlines()) < before + 3:
            assert time.monotonic() < deadline, "nothing was written for a minute"
            assert child.poll() is None, "it ended before it could be killed"
            time.sleep(0.02)
        child.send_signal(how)
        child.wait(30)
    journal = Journal(file, {"seed": 3})
    assert len(journal.entries) >= 4, journal.entries
    assert summary(search([LARGE], SMALL, 3, journal=journal)) == summary(unbroken)


def test_the_workers_may_be_those_of_a_thread_pool(unbroken: Result) -> None:
    with joblib.parallel_config(backend="threading"):
        found = search([LARGE], SMALL, 3, jobs=1)
    assert summary(found) == summary(unbroken)
