"""The stages of a run: what its journal depends on, what is not confirmed, and how costs are counted."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from convexperc.problem.problem import Problem
from verification.checks.interface import Check, Observation
from verification.journal import read_head
from verification.problems.sources import Source
from verification.run import stages
from verification.run.stages import Options, gather
from verification.search.engine import Result
from verification.search.profiles import PROFILES
from verification.search.shards import Case, Tally, plain, size_of

PART = "F1/bounded"
QUICK = Options(PROFILES["quick"], claims=("F1",))


def test_a_journal_is_continued_by_the_same_source_alone(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(stages, "_gathered", interrupted)
    file, old, heads = tmp_path / "run.jsonl", tmp_path / "run.jsonl.old", []
    for digest in ("one", "one", "two"):
        monkeypatch.setattr(stages, "code_digest", lambda digest=digest: digest)
        assert not old.exists(), heads
        assert gather(QUICK, file).interrupted, digest
        heads.append(read_head(file))
    assert old.exists(), "the journal of another source was continued"
    assert heads[0] == heads[1] != heads[2], heads


def failing_above_one(problem: Problem, source: Source) -> Iterator[Observation]:
    yield Observation.of(PART, problem.X[0, 0] <= 1.0, problem.X[0, 0], "too large")


@pytest.mark.parametrize(("entry", "confirmed"), [(2.0, True), (1.0, False)])
def test_a_failure_that_is_not_confirmed_is_told(
    monkeypatch: pytest.MonkeyPatch, entry: float, confirmed: bool
) -> None:
    monkeypatch.setattr(stages, "CHECKS", (Check("small", (PART,), failing_above_one),))
    problem = Problem([[entry]], [1.0], lambda1=1.0, lambda2=1.0, lambda3=1.0)
    case = Case(size_of(problem), plain(problem), [], entry, "")
    missing: list[str] = []
    result = Result({(PART, "random"): Tally(smallest=case)})
    records = list(stages._found(result, QUICK, missing))
    assert [each.part for each in records] == [PART] * confirmed, records
    assert len(missing) == (not confirmed), missing
    assert all(f"{PART}: a failure on random is not confirmed" in each for each in missing), missing


@pytest.mark.parametrize("held", [True, False])
def test_a_cost_is_counted_as_held_or_failed(held: bool) -> None:
    count = stages._counted(Observation.of("C1/step6", held, 3.0))
    assert (count.held, count.failed, count.worst) == (int(held), int(not held), 3.0), count
