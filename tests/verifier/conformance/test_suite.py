"""Which vectors are asked, known failures, what is written, and the search beyond the vectors."""

import json
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from faulty_solvers import asked_otherwise, changed, library, traced
from markupsafe import escape

from convexperc import Problem
from convexperc.errors import FileFormatError, InputError
from verification.conformance import outputs, suite
from verification.conformance.asserting import assert_conforms
from verification.conformance.doors import Command, Function
from verification.conformance.judge import Level
from verification.conformance.profiles import FLOAT32, FLOAT64
from verification.conformance.request import Request
from verification.conformance.searching import search
from verification.conformance.suite import Selection, lines, read_known, run
from verification.conformance.vectors import all_vectors
from verification.exact.formulation import objective
from verification.search import engine

half = asked_otherwise(lambda2=0.5)


def test_the_selection_takes_ids_and_flags():
    every, extreme = Selection(), Selection(only="extreme")
    asked = {each.id for each in all_vectors().problems if every.takes(each.id, each.flags)}
    more = {each.id for each in all_vectors().problems if extreme.takes(each.id, each.flags)}
    assert more == {each.id for each in all_vectors().problems if "extreme" in each.flags} != set()
    assert not more & asked
    single = Selection(FLOAT32)
    assert not any(
        single.takes(each.id, each.flags) for each in all_vectors().problems if "float64" in each.flags
    )
    assert Selection(only="real").takes("x", ["real"])
    assert Selection(only="zero-*").takes("zero-row-00")
    assert not Selection(only="zero-*").takes("random-00", ["real"])
    with pytest.raises(InputError, match="must match an id, or be a flag"):
        run(Function(library), Selection(only="no-such"))


def test_the_lines_are_those_that_are_asked():
    found = [json.loads(line) for line in lines(Selection(only="random-*"))]
    assert [each["id"] for each in found] == [f"random-{k:02}" for k in range(len(found))]
    problem = all_vectors().problems[0].request.problem
    data = json.loads(Request("one", problem).line)
    np.testing.assert_array_equal(np.array(data["X"]), problem.X)
    np.testing.assert_array_equal(np.array(data["o"]), problem.o)
    assert sum(data["modalities"]) == data["d"] == problem.d
    with pytest.raises(InputError, match="consecutive"):
        Request(
            "one",
            Problem(np.eye(3), [1.0, 1.0, 1.0], modalities=[[0, 2], [1]], lambda1=1, lambda2=1, lambda3=1),
        )


def test_known_failures_are_told_apart(tmp_path: Path):
    first = run(Function(half), Selection(only="random-0*"))
    ids = {each.id for each in first.failed}
    known = tmp_path / "known"
    known.write_text(
        "# the lambdas are not mine\n"
        + "".join(f"{each.id} {each.level} # half\n" for each in first.failed)
        + "\nrandom-00 L0\n"
    )
    again = run(Function(half), Selection(only="random-0*"), known=read_known(known))
    assert again.failed == first.failed != ()
    assert not again.unexpected
    assert again.statement.endswith(f"{len(first.failed)} failures on {len(ids)} requests, all known.")
    assert again.stale == ("random-00 L0",)
    assert again.reached == Level.L0
    known.write_text("random-00 L7\n")
    with pytest.raises(FileFormatError, match="must be an id and a level"):
        read_known(known)
    known.write_text("random-00 L1\nrandom-00 L1\n")
    with pytest.raises(FileFormatError, match="must be given once"):
        read_known(known)
    known.write_text("\ufeffrandom-00 L1\n", "utf-8")
    assert read_known(known) == {("random-00", Level.L1): ""}
    known.write_text("random-77 L1\n")
    with pytest.raises(InputError, match="must name ids of the vectors"):
        run(Function(half), Selection(only="random-0*"), known=read_known(known))


def test_what_is_written_says_what_was_found():
    report = run(Function(half), Selection(only="random-0*"))
    record = outputs.as_json(report, None)
    assert json.loads(json.dumps(record)) == record
    assert record["reached"] == "L0"
    failed = {each["id"] for each in record["findings"] if each["outcome"] == "failed"}
    assert set(record["requests"]) == failed != set()
    assert record["levels"]["L1"]["failed"] == len(failed)
    suite = ElementTree.fromstring(outputs.junit(report))
    assert suite.get("failures") == str(len(list(suite.iter("failure")))) == str(len(report.failed))
    page = outputs.page(report, None).decode()
    assert escape(report.statement) in page
    assert "<script" not in page
    assert all(each.id in page for each in report.failed)


def test_text_of_a_solver_cannot_forge_a_page():
    def shouts(X: Any, o: Any, modalities: Any, **weights: float) -> Any:
        raise ArithmeticError("<script>alert(1)</script>\x1b[31m\n\x00")

    report = run(Function(shouts), Selection(only="random-00"))
    page = outputs.page(report, None).decode()
    assert "<script" not in page
    assert "\x1b" not in page
    ElementTree.fromstring(outputs.junit(report))


def test_a_test_of_ones_own_in_two_lines():
    assert assert_conforms(library, only="random-*").reached == "L3"
    with pytest.raises(AssertionError, match=r"reaches L0.*\n.*random-\d\d L1: F\(w, u\) is"):
        assert_conforms(half, only="random-*")
    assert_conforms(half, only="random-*", level="L0")
    with pytest.raises(AssertionError, match="12 declined, which declined= may allow: random-00"):
        assert_conforms(declines, only="random-*")
    with pytest.raises(AssertionError, match="Nothing was answered"):
        assert_conforms(declines, only="random-*", declined=True)
    with pytest.raises(InputError, match="level"):
        assert_conforms(library, level="L9")
    with pytest.raises(InputError, match="a list of words in assert_conforms"):
        assert_conforms("./solver", only="random-*")


def test_a_test_of_ones_own_acquits_nobody(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    def small(X: Any, o: Any, modalities: Any, **weights: float) -> Any:
        if X.size > 4:
            raise NotImplementedError("small ones only")
        return library(X, o, modalities, **weights)

    with pytest.raises(AssertionError, match="declined"):
        assert_conforms(small, only="random-*", declined=["one-view-*"])
    assert assert_conforms(small, only="random-*", declined=["random-*"]).declined
    known = tmp_path / "known"
    known.write_text("random-00 L2 # old\n")
    with pytest.raises(AssertionError, match="Nothing was answered"):
        assert_conforms(declines, only="random-*", declined=True, known=known)
    with pytest.raises(AssertionError, match="Nothing was answered"):
        assert_conforms(declines, declined=True)
    with pytest.raises(AssertionError, match="not all were asked"):
        assert_conforms([sys.executable, "-c", ""], only="random-*", known=known)

    def ends(X: Any, o: Any, modalities: Any, **weights: float) -> Any:
        sys.exit(0)

    with pytest.raises(AssertionError, match="SystemExit"):
        assert_conforms(ends, only="random-00")
    loose = [replace(each, lower=each.lower / 2) for each in all_vectors().problems if each.id == "random-01"]
    monkeypatch.setattr(suite, "_selected", lambda *of: (loose, [], []))
    with pytest.raises(AssertionError, match="undecided: random-01 L1; random-01 L2"):
        assert_conforms(library)


def test_a_failure_shows_the_answer_and_a_better_one():
    report = run(Function(half), Selection(only="random-0*"))
    first = outputs.smallest(report)[0]
    explained = report.explained[first.id]
    assert sum(explained.answered.terms) > sum(explained.better.terms)
    record, page = outputs.as_json(report, None), outputs.page(report, None).decode()
    assert record["explained"][first.id]["answered"]["w"] == explained.answered.w.tolist()
    assert str(escape(explained.lines[1])) in page
    case = next(each for each in all_vectors().problems if each.id == first.id)
    for point in (explained.answered, explained.better):
        exact = objective(case.request.problem, point.w, point.u).upper
        assert sum(point.terms) == pytest.approx(float(exact), rel=1e-12)
    assert "F = " in explained.lines[0]


def test_a_trace_of_one_value_shows_nothing():
    report = run(Function(traced(lambda F: [F])), Selection(only="random-00"))
    assert report.counts("L4") == {"skipped": 1}


def declines(X: Any, o: Any, modalities: Any, **weights: float) -> Any:
    raise NotImplementedError("nothing")


@pytest.mark.parametrize("profile", [FLOAT64, FLOAT32], ids=["float64", "float32"])
def test_the_search_finds_nothing_wrong_with_the_library(profile: Any):
    found = search(Function(library), profile, 400)
    assert found.asked >= 400
    assert not found.found, found.found
    assert not found.undecided
    assert not found.broken, found.broken


def test_the_search_shrinks_what_it_finds():
    found = search(Function(half), FLOAT64, 60)
    by_level = {each.level: each for each in found.found}
    assert set(by_level) == {"L1", "L2"}, found
    data = json.loads(by_level[Level.L1].line)
    assert (data["n"], data["d"]) == (1, 1), data
    assert run_line(half, data)


def run_line(solver: Any, data: dict[str, Any]) -> bool:
    """Whether the request that was found fails by itself."""
    weights = {name: data[name] for name in ("lambda1", "lambda2", "lambda3")}
    truth = library(np.array(data["X"]), np.array(data["o"]), data["modalities"], **weights)
    wrong = solver(np.array(data["X"]), np.array(data["o"]), data["modalities"], **weights)
    return bool(abs(truth["w"][0] - wrong[0][0]) > 1e-6)


def test_a_search_that_finds_a_crash_goes_on():
    def raises(found: dict[str, Any], problem: Problem) -> dict[str, Any]:
        if problem.n > 2:
            raise ArithmeticError("more than two robots")
        return found

    found = search(Function(changed(raises)), FLOAT64, 60)
    assert [each.level for each in found.found] == ["L0"]
    assert json.loads(found.found[0].line)["n"] == 3
    assert "more than two robots" in found.found[0].detail


CRASHES = """
import json, os, sys
for line in sys.stdin:
    request = json.loads(line)
    if request["n"] >= int(sys.argv[1]):
        os.abort()
    print(json.dumps({"id": request["id"], "unsupported": "few robots"}), flush=True)
"""
"""Crashes on requests of so many robots or more; it loads no library, as each crash means another start."""


def crashes(least: int) -> Command:
    return Command([sys.executable, "-c", CRASHES, str(least)])


def test_the_search_shrinks_a_crash_to_a_request_that_crashes():
    found = search(crashes(2), FLOAT64, 60)
    (crash,) = found.found
    assert json.loads(crash.line)["n"] == 2
    assert "asked again" not in crash.detail
    assert not found.broken


def test_the_search_takes_no_request_for_failed_that_was_not_asked():
    found = search(crashes(1), FLOAT64, 60)
    (crash,) = found.found
    assert "SIGABRT" in crash.detail
    assert crash.failures < found.asked


def test_a_failure_that_does_not_come_again_is_told(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(engine, "HUNTED", 20)  # nothing is to be found
    asked = 0

    def flaky(X: Any, o: Any, modalities: Any, **weights: float) -> Any:
        nonlocal asked
        asked += 1
        return (half if asked == 9 else library)(X, o, modalities, **weights)

    found = search(Function(flaky), FLOAT64, 60)
    assert found.found
    assert all(each.detail.endswith("it did not fail when asked again") for each in found.found), found
