"""A campaign counts every case, survives crashes, sees false proofs, and can be broken and resumed."""

import io
import json
import re
import subprocess
import sys
from collections import Counter
from dataclasses import dataclass, replace

import numpy as np
import pytest
from rich.console import Console
from typer.testing import CliRunner

from convexperc.solution.single import solve
from convexperc.solvers.conic import Conic
from convexperc.solvers.interface import SolverResult
from convexperc.solvers.newton.method import Newton
from verification.__main__ import app
from verification.checks.raw import Raw, raw
from verification.problems.families import EXTREME, FAMILIES
from verification.search.campaign import run as campaign
from verification.search.campaign.cases import Case, Plan, cases
from verification.search.campaign.file import Settings, load, save
from verification.search.campaign.run import Rules, State, run
from verification.search.campaign.screen import families_table, raw_table
from verification.search.campaign.tallies import RawTally, Reason, Report, Tally

CASES = cases(3, 5, 0)
ESCALATING = Rules(Newton(), escalate=True)


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


def test_a_plan_deals_out_every_family_evenly():
    plan = Plan(5, 60, 9, 3)
    assert len(plan) == len(list(plan)) == len(set(plan)) == 74
    assert plan[-1] == plan[73], plan[73]
    counts = Counter(case.family for case in plan)
    assert set(counts) == set(FAMILIES), counts
    assert {counts["random"], counts["recognition"]} == {2, 3}, counts
    assert sorted(plan[1::3] + plan[0::3] + plan[2::3], key=repr) == sorted(plan, key=repr)
    with pytest.raises(IndexError):
        plan[74]


def test_every_case_is_counted_and_certified():
    report = run(CASES, replace(ESCALATING, referee_every=1))
    assert report.total == len(CASES) == sum(tally.refereed for tally in report.families.values())
    assert report.clean, (report.failures, report.contradictions)
    assert not Report().clean, "a campaign that looks at nothing proves nothing"


def test_what_failed_is_named_with_its_reason():
    starved = run(CASES, Rules(replace(Conic(), max_iterations=2)))
    assert starved.failures, "two iterations cannot be enough for all"
    reasons = {failure.reason for failure in starved.failures}
    assert reasons <= {Reason.POINT, Reason.NO_ANSWER}, starved.failures
    assert not starved.contradictions, starved.contradictions
    assert not starved.clean
    for failure in starved.failures:
        problem = failure.case.problem()
        assert (problem.n, problem.d, problem.lambdas) == (failure.n, failure.d, failure.lambdas), failure
    assert sum(tally.failed for tally in starved.families.values()) == len(starved.failures)


def test_a_crash_is_a_failure_of_its_case_and_not_the_end():
    chosen = cases(8, 0, 0)
    odd = [case for case in chosen if case.problem().n % 2]
    report = run(chosen, Rules(Crashing(), escalate=True))
    assert 0 < len(odd) < len(chosen)
    assert [failure.case for failure in report.failures] == odd, report.failures
    assert {failure.reason for failure in report.failures} == {Reason.CRASH}, report.failures
    assert all(failure.claim.startswith("TypeError: planted (") for failure in report.failures)
    assert sum(tally.crashed for tally in report.families.values()) == len(odd)
    assert sum(tally.certified for tally in report.families.values()) == len(chosen) - len(odd)


def test_a_case_that_the_referee_cannot_judge_is_a_failure(monkeypatch):
    monkeypatch.setattr(campaign, "optimum", lambda problem: 1 / 0)
    report = run(CASES[:1], replace(ESCALATING, referee_every=1))
    assert [failure.reason for failure in report.failures] == [Reason.REFEREE], report.failures
    assert report.families["random"].refereed == 0


@pytest.mark.parametrize("change", ["lower", "upper"])
def test_an_interval_that_misses_the_optimum_is_contradicted(change, monkeypatch):
    true = campaign.solve

    def wrong(*args, **options):
        found = true(*args, **options)
        proof = found.certificate
        moved = proof.upper * (1 + 1e-6) if change == "lower" else proof.lower * (1 - 1e-6)
        return replace(found, certificate=replace(proof, **{change: moved}))

    monkeypatch.setattr(campaign, "solve", wrong)
    report = run(cases(4, 0, 0), replace(ESCALATING, referee_every=2))
    assert [each.case.index for each in report.contradictions] == [0, 0], report.contradictions
    assert all(each.statements[0].startswith(change) for each in report.contradictions)
    assert [tally.contradicted for tally in report.families.values()] == [1, 1]
    assert not report.clean


def test_a_lazy_solver_fails_unless_it_is_escalated():
    chosen = [case for case in cases(6, 0, 0) if solve(case.problem()).w.any()][:2]
    assert [each.reason for each in run(chosen, Rules(Lazy())).failures] == [Reason.POINT] * 2
    report = run(chosen, Rules(Lazy(), escalate=True))
    assert report.clean, report.failures
    assert sum(tally.escalated for tally in report.families.values()) == 2


def test_extreme_families_are_refereed_more_rarely():
    rules = replace(ESCALATING, referee_every=3, raw_every=2)
    assert [k for k in range(16) if rules.referees(Case("random", 0, k))] == [0, 3, 6, 9, 12, 15]
    assert [k for k in range(31) if rules.referees(Case("mixed_scales", 0, k))] == [0, 15, 30]
    assert [k for k in range(5) if rules.asks_raw(Case(next(iter(EXTREME)), 0, k))] == [0, 2, 4]
    assert not any(Rules().referees(case) or Rules().asks_raw(case) for case in CASES)


SETTINGS = Settings(4, 27, 4, 1, "newton", escalate=True, referee=2, raw=0, chunk=10)


def test_a_resumed_campaign_is_the_unbroken_one(tmp_path):
    whole = run(SETTINGS.plan, SETTINGS.rules, chunk=SETTINGS.chunk)
    file, seen = tmp_path / "campaign.json", []

    class KilledError(Exception):
        pass

    def kill(state):
        save(file, ["campaign"], SETTINGS, state)
        if state.done == 2:
            raise KilledError

    with pytest.raises(KilledError):
        run(SETTINGS.plan, SETTINGS.rules, state=SETTINGS.fresh(), progress=kill)
    command, settings, state = load(file)
    assert (command, settings, state.done, state.chunks) == (["campaign"], SETTINGS, 2, 4)
    assert 0 < state.report.total < len(SETTINGS.plan)
    rest = run(settings.plan, settings.rules, state=state, progress=lambda now: seen.append(now.done))
    assert seen == [3, 4], seen
    assert (rest.families, rest.failures) == (whole.families, whole.failures)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["campaign.json"]


def test_two_processes_count_the_same():
    chosen = Plan(6, 27, 0, 2)
    alone, together = (run(chosen, ESCALATING, jobs=jobs, chunk=8) for jobs in (1, 2))
    assert alone.total == len(chosen)
    assert alone.families == together.families


def test_a_report_reads_back_as_it_was_written():
    report = run(CASES, Rules(Crashing(), referee_every=1, raw_every=1))
    assert report.failures, report
    report.raw_tally("zero_target").worst = float("inf")
    again = Report.from_json(json.loads(json.dumps(report.as_json(), allow_nan=False)))
    assert again == report, (again, report)


def test_raw_answers_are_measured_against_the_interval():
    tally = RawTally()
    for answer in (
        Raw("optimal", 1.5),
        Raw("optimal", 1.0 - 1e-7),
        Raw("optimal", 2.1),
        Raw("optimal_inaccurate", 9.0),
    ):
        tally.count(answer, 1.0, 2.0)
    tally.count(Raw("infeasible", None), 1.0, 2.0)
    assert (tally.total, tally.optimal, tally.inaccurate, tally.failed) == (5, 3, 1, 1), tally
    assert (tally.outside, tally.above_1e_8, tally.above_1e_6, tally.above_1e_3) == (2, 2, 1, 1), tally
    assert tally.worst == pytest.approx(0.05)
    assert Raw("optimal", 1e-300).distance(0.0, 0.0) == np.inf


def test_raw_answers_go_wrong_at_small_scale():
    plain, tiny = Case("random", 0, 1).problem(), Case("extreme_target", 0, 4).problem()
    assert raw(plain).optimal, raw(plain)
    report = run([Case("scaled_target", 0, k) for k in range(8)], replace(ESCALATING, raw_every=1))
    counts = report.raw["scaled_target"]
    assert counts.total == 8, counts
    assert counts.above_1e_3 + counts.failed > 0, counts
    assert raw(tiny).status, tiny


def test_tables_fit_a_narrow_terminal():
    tallies = {name: Tally(name, *[250_000] * 9, seconds=1e6) for name in FAMILIES}
    raws = {name: RawTally(*[250_000] * 8, worst=1e300) for name in FAMILIES}
    report = Report(tallies, raws)
    for table in (families_table(report), raw_table(report)):
        console = Console(width=100, record=True, file=io.StringIO())
        console.print(table)
        text = console.export_text()
        assert "…" not in text, text
        assert max(map(len, text.splitlines())) <= 100, text
        assert len(text.splitlines()) <= len(FAMILIES) + 8, text


def test_the_command_runs_saves_and_resumes(tmp_path):
    file = tmp_path / "out.json"
    options = ["--random", "2", "--degenerate", "3", "--referee", "1", "--raw", "1", "--json", str(file)]
    found = CliRunner().invoke(app, ["campaign", *options])
    assert found.exit_code == 0, found.output
    assert re.search(r"all +5 +5 +0 +0", found.output.replace("│", " ")), found.output
    data = json.loads(file.read_text())
    assert data["done"] == data["chunks"] == 1, data
    assert sum(family["total"] for family in data["families"]) == 5
    assert data["settings"]["solver"] == "newton"
    again = CliRunner().invoke(app, ["campaign", "--resume", str(file)])
    assert again.exit_code == 0, again.output
    assert json.loads(file.read_text()) == data
    for wrong in (["--random", "0", "--degenerate", "0"], ["--resume", str(tmp_path / "none.json")]):
        assert CliRunner().invoke(app, ["campaign", *wrong]).exit_code == 2, wrong
    file.write_text("{}")
    assert CliRunner().invoke(app, ["campaign", "--resume", str(file)]).exit_code == 2


def test_a_failure_is_shown_and_ends_with_one(monkeypatch):
    monkeypatch.setattr("verification.search.campaign.file._solver", lambda name: Lazy())
    found = CliRunner().invoke(app, ["campaign", "--random", "1", "--degenerate", "0", "--no-escalate"])
    assert found.exit_code == 1, found.output
    assert "random seed 0 index 0: n" in found.output, found.output
    assert "1 of 1" in found.output, found.output


def test_progress_goes_to_stderr():
    command = [sys.executable, "-m", "verification", "campaign", "--random", "1", "--degenerate", "0"]
    found = subprocess.run(command, capture_output=True, text=True, check=True)
    assert "1 of 1" in found.stderr, found.stderr
    assert "1 of 1" not in found.stdout, found.stdout


def test_the_state_of_nothing_is_done():
    assert State(0).report == run([], Rules())
