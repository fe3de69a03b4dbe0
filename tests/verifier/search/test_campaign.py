"""A campaign counts every problem, survives crashes, sees false proofs, and can be broken and resumed."""

import io
import json
import re
from collections import Counter
from dataclasses import asdict, dataclass, replace

import numpy as np
import pytest
from rich.console import Console
from typer.testing import CliRunner

from convexperc.solution.single import solve
from convexperc.solvers.conic import Conic
from convexperc.solvers.interface import SolverResult
from convexperc.solvers.newton.method import Newton
from verification.__main__ import app
from verification.checks.clarabel import Tally as ClarabelTally
from verification.journal import Journal
from verification.problems.families import EXTREME, FAMILIES
from verification.provenance import is_current, stamp
from verification.search import campaign as profile
from verification.search import certify
from verification.search.campaign import SHARD, SOLVERS, Campaign, Stretch
from verification.search.certify import count_shard, run
from verification.search.screen import clarabel_table, details, families_table
from verification.search.tallies import Case, Reason, Report, Tally
from verification.search.tasks import run_tasks

MADE = {"versions": {}, "code": "", "commit": ""}
FEW = Campaign(random=3, degenerate=5, referee=0)


@dataclass(frozen=True)
class Crashing:
    """A solver that is broken on problems of an odd size."""

    name: str = "crashing"

    def solve(self, problem):
        if problem.n % 2:
            raise TypeError("planted")
        return Newton().solve(problem)


@dataclass(frozen=True)
class Lazy:
    """A solver that answers 0 whatever it is asked."""

    name: str = "lazy"

    def solve(self, problem):
        return SolverResult(np.zeros(problem.n), np.zeros(problem.d), "optimal", 0)


def cases(campaign):
    return [case for stretch in campaign.plan() for case in campaign.cases(stretch)]


def total(report, count):
    return sum(getattr(tally, count) for tally in report.families.values())


@pytest.fixture
def plant(monkeypatch):
    """Another solver in place of Newton's method."""
    return lambda solver: monkeypatch.setitem(SOLVERS, "newton", solver)


def test_problems_are_dealt_out_evenly_in_small_shards(monkeypatch):
    monkeypatch.setattr(profile, "SHARD", 2)
    campaign = Campaign(random=11, degenerate=60, extreme=9, seed=3)
    plan, chosen = campaign.plan(), cases(campaign)
    assert len(chosen) == len(set(chosen)) == campaign.total == 80
    counts = Counter(case.family for case in chosen)
    assert set(counts) == set(FAMILIES), counts
    assert (counts["random"], counts["recognition"]) == (6, 5), counts
    assert all(set(range(counts[case.family])) >= {case.index} and case.seed == 3 for case in chosen)
    assert max(stretch.count for stretch in plan) == 2, plan
    assert len({stretch.key for stretch in plan}) == len(plan)


def test_a_million_problems_make_a_few_thousand_shards_and_an_early_end_has_seen_some_of_all():
    campaign = Campaign(530_000, 450_000, 20_000)
    whole, early, plan = Counter(), Counter(), campaign.plan()
    for k, stretch in enumerate(plan):
        whole[stretch.family] += stretch.count
        early[stretch.family] += stretch.count if k < len(plan) / 4 else 0
    assert whole.total() == campaign.total
    assert len(plan) < 5000, len(plan)
    assert all(abs(early[name] - whole[name] / 4) <= SHARD + whole[name] / 50 for name in FAMILIES), early


def test_every_problem_is_counted_and_certified():
    report = run(replace(FEW, referee=1))
    assert report.total == FEW.total == total(report, "refereed") == total(report, "certified")
    assert report.clean, (report.failures, report.contradictions)
    assert list(report.families) == [name for name in FAMILIES if name in report.families]
    assert not Report().clean, "a campaign that looks at nothing proves nothing"


def test_what_failed_is_named_with_its_reason(monkeypatch):
    monkeypatch.setitem(SOLVERS, "conic", lambda: replace(Conic(), max_iterations=2))
    starved = run(replace(FEW, solver="conic", escalate=False))
    assert starved.failures, "two iterations cannot be enough for all"
    assert set(starved.reasons) <= {Reason.POINT.value, Reason.NO_ANSWER.value}, starved.failures
    assert not starved.contradictions, starved.contradictions
    assert not starved.clean
    for failure in starved.failures:
        problem = failure.case.problem()
        shown = failure.n, failure.d, failure.m, failure.lambdas
        assert shown == (problem.n, problem.d, problem.m, problem.lambdas), failure
    assert total(starved, "failed") == len(starved.failures) == sum(starved.reasons.values())


def test_a_crash_is_a_failure_of_its_problem_and_not_the_end(plant):
    plant(Crashing)
    campaign = Campaign(random=8, degenerate=0, referee=0)
    odd = [case for case in cases(campaign) if case.problem().n % 2]
    report = run(campaign)
    assert 0 < len(odd) < campaign.total
    assert [failure.case for failure in report.failures] == odd, report.failures
    assert report.reasons == {Reason.CRASH.value: len(odd)}, report.failures
    assert all(failure.status.startswith("TypeError: planted (test_camp") for failure in report.failures)
    assert total(report, "crashed") == len(odd) == total(report, "failed")
    assert total(report, "certified") == campaign.total - len(odd)


def test_a_problem_that_the_referee_cannot_judge_is_a_failure(monkeypatch):
    monkeypatch.setattr(certify, "optimum", lambda problem: 1 / 0)
    report = run(Campaign(random=1, degenerate=0, referee=1))
    assert [failure.reason for failure in report.failures] == [Reason.REFEREE], report.failures
    assert report.families["random"].refereed == 0


@pytest.mark.parametrize("change", ["lower", "upper"])
def test_an_interval_that_misses_the_optimum_is_contradicted(change, monkeypatch):
    true = certify.solve

    def wrong(*args, **options):
        found = true(*args, **options)
        proof = found.certificate
        moved = proof.upper * (1 + 1e-6) if change == "lower" else proof.lower * (1 - 1e-6)
        return replace(found, certificate=replace(proof, **{change: moved}))

    monkeypatch.setattr(certify, "solve", wrong)
    report = run(Campaign(random=4, degenerate=0, referee=2))
    assert [each.case for each in report.contradictions] == [
        Case("random", 0, 0),
        Case("recognition", 0, 0),
    ]
    assert all(each.statements[0].startswith(change) for each in report.contradictions)
    assert [tally.contradicted for tally in report.families.values()] == [1, 1]
    assert not report.clean
    assert sum(line.startswith("CONTRADICTED Case(") for line in details(report)) == 2


def test_a_lazy_solver_fails_unless_it_is_escalated(plant):
    plant(Lazy)
    campaign = Campaign(random=6, degenerate=0, referee=0)
    wrong = [case for case in cases(campaign) if solve(case.problem()).w.any()]
    assert len(wrong) >= 2, wrong
    report = run(replace(campaign, escalate=False))
    assert [each.case for each in report.failures] == wrong, report.failures
    assert report.reasons == {Reason.POINT.value: len(wrong)}
    report = run(campaign)
    assert report.clean, report.failures
    assert total(report, "escalated") == len(wrong)


def test_extreme_families_are_refereed_more_rarely():
    rules = Campaign(referee=3, clarabel=2)
    assert [k for k in range(16) if rules.referees(Case("random", 0, k))] == [0, 3, 6, 9, 12, 15]
    assert [k for k in range(31) if rules.referees(Case("mixed_scales", 0, k))] == [0, 15, 30]
    assert [k for k in range(5) if rules.asks_clarabel(Case(next(iter(EXTREME)), 0, k))] == [0, 2, 4]
    never = Campaign(referee=0, clarabel=0)
    assert not any(never.referees(case) or never.asks_clarabel(case) for case in cases(FEW))


def test_clarabel_goes_wrong_at_small_scale_and_is_counted():
    data = count_shard(Stretch("scaled_target", 0, 8), Campaign(referee=0, clarabel=1), Newton())
    counts = Report.from_json(data).clarabel["scaled_target"]
    assert counts.total == 8, counts
    assert counts.above_1e_3 + counts.failed > 0, counts


CHECKED = Campaign(4, 27, 4, seed=1, referee=0)


@pytest.fixture(scope="module")
def unbroken():
    """What `CHECKED` finds in one process, without a journal."""
    return run(CHECKED)


def test_a_resumed_campaign_is_the_unbroken_one(unbroken, tmp_path, monkeypatch):
    monkeypatch.setattr(profile, "SHARD", 1)
    file, seen = tmp_path / "run.jsonl", []

    class KilledError(Exception):
        pass

    def kill(report):
        if report.total == 12:
            raise KilledError

    with pytest.raises(KilledError):
        run(CHECKED, journal=Journal(file, CHECKED.head(MADE)), progress=kill)
    rest = run(
        CHECKED, journal=Journal(file, CHECKED.head(MADE)), progress=lambda now: seen.append(now.total)
    )
    assert seen == list(range(12, CHECKED.total + 1)), seen
    assert rest == unbroken
    assert file.stat().st_size < 1000 * CHECKED.total, "a shard takes a few hundred bytes"


def test_two_processes_count_the_same(unbroken):
    assert run(CHECKED, jobs=2) == unbroken


def test_a_shard_that_was_lost_is_told_and_a_resumed_run_repairs_it(unbroken, tmp_path, monkeypatch):
    name = "all_lambdas_zero|0|1"

    def losing(tasks, take, **options):
        return run_tasks({key: task for key, task in tasks.items() if key != name}, take, **options) | {
            name: "planted"
        }

    monkeypatch.setattr(certify, "run_tasks", losing)
    found = run(CHECKED, journal=Journal(tmp_path / "run.jsonl", CHECKED.head(MADE)))
    assert found.lost == {name: "planted"}, found.lost
    assert found.total == CHECKED.total - 1
    assert (found.failures, found.contradictions, found.clean) == ([], [], False)
    assert "LOST family|first|count all_lambdas_zero|0|1: planted" in list(details(found))
    assert Report.from_json(json.loads(json.dumps(found.as_json()))) == found
    monkeypatch.undo()
    again = run(CHECKED, journal=Journal(tmp_path / "run.jsonl", CHECKED.head(MADE)))
    assert again == unbroken
    assert again.clean, again


def test_a_report_reads_back_as_it_was_written(plant):
    plant(Crashing)
    report = run(Campaign(3, 5, escalate=False, referee=1, clarabel=1))
    assert report.failures, report
    report.clarabel_tally("zero_target").worst = float("inf")
    again = Report.from_json(json.loads(json.dumps(report.as_json(), allow_nan=False)))
    assert again == report, (again, report)


def test_tables_fit_a_narrow_terminal():
    report = Report(
        {name: Tally(*[250_000] * 9, seconds=1e6) for name in FAMILIES},
        {name: ClarabelTally(*[250_000] * 8, worst=1e300) for name in FAMILIES},
    )
    for table in (families_table(report), clarabel_table(report)):
        console = Console(width=100, record=True, file=io.StringIO())
        console.print(table)
        text = console.export_text()
        assert "…" not in text, text
        assert str(250_000 * len(FAMILIES)) in text, text
        assert max(map(len, text.splitlines())) <= 100, text
        assert len(text.splitlines()) <= len(FAMILIES) + 8, text


def command(*options):
    return CliRunner().invoke(app, ["campaign", *map(str, options)])


def test_the_command_runs_saves_and_resumes(tmp_path):
    file = tmp_path / "out.json"
    found = command("--random", 2, "--degenerate", 3, "--referee", 1, "--clarabel", 1, "--json", file)
    assert found.exit_code == 0, found.output
    assert re.search(r"all +5 +5 +0 +0", found.stdout), found.output
    assert "5 of 5" in found.stderr, found.stderr
    assert "5 of 5" not in found.stdout, found.stdout
    data = json.loads(file.read_text())
    settings = Campaign(2, 3, referee=1, clarabel=1)
    assert data["settings"] == asdict(settings), data
    assert data["command"] == settings.command, data
    assert data["made"] == stamp("campaign"), data
    assert is_current(data, "campaign"), data
    report = Report.from_json(data)
    assert report.total == 5 == sum(tally.total for tally in report.clarabel.values())
    journal = tmp_path / ".journal" / "out.json.jsonl"
    lines = journal.read_bytes().splitlines(keepends=True)
    journal.write_bytes(b"".join(lines[:3]))  # as if it had been killed after two shards
    file.unlink()
    for _ in range(2):  # the second time nothing is left to do
        again = command("--resume", file)
        assert again.exit_code == 0, again.output
        assert "2 of 5" in again.stderr or "5 of 5, 0.0/s" in again.stderr, again.stderr
        assert Report.from_json(json.loads(file.read_text())) == report


def test_the_command_that_is_printed_repeats_the_campaign():
    settings = Campaign(1, 1, 1, 5, "conic", escalate=False, referee=3, clarabel=2)
    program, found = settings.command.split(" campaign ")
    assert program == "python -m verification"
    assert command(*found.split(), "--help").exit_code == 0
    for name, value in asdict(settings).items():
        assert f"--{name} {value}" in settings.command or (name, value) == ("escalate", False), name
    assert "--no-escalate" in settings.command


def test_misuse_is_told_before_anything_is_done(tmp_path):
    file = tmp_path / "out.json"
    for wrong, said in (
        (["--random", 0, "--degenerate", 0], "at least one problem"),
        (["--resume", tmp_path / "none.json"], "No such file"),
        (["--json", tmp_path / "none" / "out.json"], "no such folder"),
    ):
        found = command(*wrong)
        assert found.exit_code == 2, found.output
        assert said in re.sub(r"[\s│]+", " ", found.output), found.output
    (tmp_path / ".journal").mkdir()
    (tmp_path / ".journal" / "out.json.jsonl").write_text("{}")
    assert command("--resume", file).exit_code == 2
    (tmp_path / ".journal" / "out.json.jsonl").unlink()
    other = Campaign(1, 0).head(stamp("campaign")) | {"code": "another"}
    Journal(tmp_path / ".journal" / "out.json.jsonl", other)
    found = command("--resume", file)
    assert found.exit_code == 2, found.output
    assert "other versions or other code" in re.sub(r"[\s│]+", " ", found.output), found.output
    assert not file.exists()


def test_a_failure_is_shown_and_ends_with_one(plant):
    plant(Lazy)
    found = command("--random", 1, "--degenerate", 0, "--no-escalate")
    assert found.exit_code == 1, found.output
    assert "random seed 0 index 0: n" in found.output, found.output


def test_an_interrupted_campaign_goes_on(tmp_path, plant, monkeypatch):
    class Interrupted(Newton):
        def solve(self, problem):
            raise KeyboardInterrupt

    options = ["--random", 2, "--degenerate", 0, "--json", tmp_path / "out.json"]
    plant(Interrupted)
    found = command(*options)
    assert found.exit_code == 3, found.output
    assert "interrupted after 0 of 2 problems; the same command goes on" in found.stderr, found.stderr
    assert not (tmp_path / "out.json").exists()
    plant(Newton)
    assert command(*options).exit_code == 0
