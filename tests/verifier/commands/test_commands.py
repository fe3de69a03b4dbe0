"""The commands about claims: what they print, write and return, also when they are misused or broken off."""

import json
import re
import subprocess
import sys
from dataclasses import replace
from functools import cache
from hashlib import sha256

import pytest
from checked_arguments import checked_once
from made_up import settled
from typer.testing import CliRunner

import verification.run.stages
import verification.search.engine
from convexperc.files import write_json
from verification.__main__ import app
from verification.counterexamples.files import catalogue
from verification.experiments.record.reading import PACKAGED
from verification.ledger import baseline
from verification.ledger.baseline import read_baseline
from verification.ledger.claims import CLAIMS
from verification.ledger.evidence import Checker, Outcome, Step, Verdict
from verification.proofs.arguments import other_steps
from verification.provenance import is_current
from verification.search.engine import plan
from verification.search.profiles import PROFILES
from verification.search.shards import explore

RUNNER = CliRunner(env={"COLUMNS": "140", "TERM": "dumb", "NO_COLOR": "1"})
OTHERS = cache(other_steps)
KEPT = ".journal/quick-0-L2.evidence.json"
FILES = {"report.html", "report.md", "report.json", "junit.xml", "SHA256SUMS"}


def run(*arguments):
    return RUNNER.invoke(app, [str(argument) for argument in arguments])


def expect(code, result):
    assert result.exit_code == code, (result.exit_code, result.output, result.exception)
    return result


def squeezed(text):
    return re.sub(r"[\s│]+", " ", text)


def findings(folder, kept=KEPT):
    """What a run has kept, but for times and the machine."""
    data = json.loads((folder / kept).read_text(encoding="utf-8"))
    del data["evidence"]["volatile"]
    return data


@pytest.fixture(scope="module", autouse=True)
def _few_problems():
    """The fewest problems that a check may be tried on: these tests are about the commands."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setitem(PROFILES, "quick", replace(PROFILES["quick"], problems=1, shard=4))
        patched.setattr(verification.search.engine, "HUNTED", 5)
        yield


@pytest.fixture(scope="module")
def judged(tmp_path_factory):
    """The folder of `report --claim L2`, and what was printed."""
    folder = tmp_path_factory.mktemp("judged")
    return folder, expect(0, run("report", "--claim", "L2", "--jobs", 1, "--out", folder))


@pytest.fixture
def explored(monkeypatch):
    """Every shard that is explored from here on; ask it to break off after some with `explored.limit`."""

    class Explored(list):
        limit = 10**9

    keys = Explored()

    def counted(shard, check, seed):
        if len(keys) == keys.limit:
            raise KeyboardInterrupt
        keys.append(shard.key)
        return explore(shard, check, seed)

    monkeypatch.setattr(verification.search.engine, "explore", counted)
    return keys


@pytest.fixture(autouse=True)
def _arguments_checked_once(monkeypatch):
    """The arguments depend on nothing: checking them takes seconds, once is enough."""
    monkeypatch.setattr(verification.run.stages, "all_arguments", checked_once)
    monkeypatch.setattr(verification.run.stages, "other_steps", OTHERS)


def test_the_list_has_every_claim():
    text = expect(0, run("list")).stdout
    assert all(re.search(rf"│ {identity} +│", text) for identity in CLAIMS), text
    assert "and 8" in text, text  # the rest may stand in the next line of its cell


def test_help_imports_nothing_slow():
    code = """
import sys
import verification.__main__ as m
for command in ("--help", "run --help", "report --help", "report diff --help", "reports --help"):
    sys.argv = ["verification", *command.split()]
    try:
        m.main()
    except SystemExit as end:
        assert not end.code, command
print("loaded", *sys.modules)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    shown, _, modules = done.stdout.partition("loaded ")
    assert shown.count("Usage") == 5, shown
    slow = {"cvxpy", "clarabel", "scipy", "numba", "hypothesis", "flint", "cvc5", "z3", "matplotlib"}
    slow |= {"jinja2"}
    assert not slow & set(modules.split()), slow & set(modules.split())


def test_a_run_judges_what_was_selected_once_and_nothing_else(tmp_path):
    selected = ("--claim", "L2", "--claim", "L1", "--claim", "L2")
    result = expect(0, run("run", *selected, "--jobs", 1, "--out", tmp_path))
    text = squeezed(result.stdout)
    assert "L2 refuted L2/inequality; corrected statement: L2/elementwise holds" in text, text
    assert "judged: 2 of 30 claims; nothing is said of the others" in text, text
    assert "A2" not in text, "observed by the same check, and not selected"
    assert [path.name for path in tmp_path.iterdir()] == [".journal"], "no report is written"
    kept = findings(tmp_path, ".journal/quick-0-L1-L2.evidence.json")
    assert {count["part"] for count in kept["evidence"]["counts"]} == {
        "L1/inequality",
        "L2/inequality",
        "L2/elementwise",
    }
    assert not kept["interrupted"]
    settings = kept["evidence"]["settings"]
    assert settings["claims"] == ["L1", "L2"], "in the order of the ledger"
    assert settings["command"].endswith("report --profile quick --seed 0 --claim L1 --claim L2")


@pytest.mark.parametrize(
    ("option", "value", "needed"),
    [
        ("--claim", "Z9", "no claim 'Z9'; the ledger has F1"),
        ("--profile", "huge", "must be one of quick"),
        ("--seed", "-1", "greater than or equal to 0"),
        ("--jobs", "0", "greater than or equal to 1"),
    ],
)
@pytest.mark.parametrize("command", ["run", "report"])
def test_what_is_no_option_is_misuse(command, option, value, needed, tmp_path):
    result = expect(2, run(command, option, value, "--out", tmp_path / "new"))
    assert needed in squeezed(result.stderr), result.stderr
    assert not (tmp_path / "new").exists()


def test_a_changed_verdict_is_named(monkeypatch, tmp_path):
    changed = read_baseline() | {"N1/positive": Verdict.SUPPORTED, "F1": Verdict.REFUTED}
    monkeypatch.setattr("verification.ledger.baseline.read_baseline", lambda: changed)
    text = expect(1, run("run", "--claim", "N1", "--jobs", 1, "--out", tmp_path)).stdout
    assert "N1/positive: holds, the baseline says supported" in text, text
    assert "F1" not in text, text


def test_a_check_that_breaks_leaves_something_open(monkeypatch, tmp_path):
    def broken(problem, source):
        raise ArithmeticError("planted")

    checks = tuple(
        replace(check, observe=broken) if "L2/inequality" in check.parts else check
        for check in verification.run.stages.CHECKS
    )
    monkeypatch.setattr(verification.run.stages, "CHECKS", checks)
    text = squeezed(expect(3, run("report", "--claim", "L2", "--jobs", 1, "--out", tmp_path)).stdout)
    assert "ArithmeticError: planted" in text, text
    assert "missing: " in text, text
    assert "ArithmeticError: planted" in (tmp_path / "report.md").read_text(encoding="utf-8")


def test_a_step_that_no_claim_rests_on_is_missed_if_it_fails(monkeypatch, tmp_path):
    failed = Step("planted: a step", Checker.EXACT, False, "1 == 2")
    monkeypatch.setattr(verification.run.stages, "other_steps", lambda: (failed,))
    text = squeezed(expect(3, run("run", "--claim", "L2", "--jobs", 1, "--out", tmp_path)).stdout)
    assert "missing: not accepted: planted: a step" in text, text


def test_a_fault_of_our_own_is_not_called_misuse(monkeypatch, tmp_path):
    def faulty():
        raise KeyError("planted")

    monkeypatch.setattr(verification.run.stages, "all_arguments", faulty)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    result = expect(70, run("run", "--claim", "N1", "--jobs", 1, "--out", tmp_path))
    assert "internal error: KeyError: 'planted'" in result.stderr, result.stderr


def test_a_report_is_written_whole_and_says_that_it_is_partial(judged):
    folder, result = judged
    assert {path.name for path in folder.iterdir()} == FILES | {"counterexamples", ".journal"}
    assert "wrote " in result.stdout, result.stdout
    listed = dict(reversed(line.split("  ")) for line in (folder / "SHA256SUMS").read_text().splitlines())
    on_disk = {path.relative_to(folder).as_posix() for path in folder.glob("[!.]*/*.json")} | FILES
    assert set(listed) == on_disk - {"SHA256SUMS"}
    for name, digest in listed.items():
        assert sha256((folder / name).read_bytes()).hexdigest() == digest, name
    record = json.loads((folder / "report.json").read_text(encoding="utf-8"))
    assert [claim["id"] for claim in record["claims"]] == ["L2"]
    assert len(record["unjudged"]) == len(CLAIMS) - 1
    assert record["outcome"]["code"] == 0, record["outcome"]
    assert is_current(record, "report"), "it says by which code it was made"
    for name in ("report.html", "report.md"):
        text = squeezed((folder / name).read_text(encoding="utf-8"))
        assert "This is a partial report: 1 of the 30 claims of the ledger were selected" in text, name
        assert "T1a/printed" not in text, name
        assert "not run in this profile" not in text, name
    found = {each["id"]: each for part in record["claims"][0]["parts"] for each in part["counterexamples"]}
    assert found["l1-analogue"]["given"] == "v = (1, 0); t = (1, 1)", found
    assert next(iter(found)) == "l1-analogue", "the catalogue's comes first"
    assert 'testcase name="F1' not in (folder / "junit.xml").read_text(encoding="utf-8")


def test_a_corrected_statement_of_another_claim_is_not_judged_unseen(judged, tmp_path):
    kept = findings(judged[0])
    kept["evidence"] |= {"volatile": {}, "settings": kept["evidence"]["settings"] | {"claims": ["T1a"]}}
    kept["evidence"]["refutations"] = [
        each | {"part": "T1a/printed/gauss_seidel"} for each in kept["evidence"]["refutations"]
    ]
    (tmp_path / "kept.json").write_text(json.dumps(kept), encoding="utf-8")
    run("report", "--evidence", tmp_path / "kept.json", "--out", tmp_path)
    text = squeezed((tmp_path / "report.html").read_text(encoding="utf-8"))
    assert "T1c/descent/jacobi, which this run did not judge" in text
    assert "T1c/descent/jacobi not judged in this run" in text


def test_the_same_seed_gives_the_same_bytes(judged, tmp_path):
    folder, _ = judged
    checked_once.cache_clear()
    expect(0, run("report", "--claim", "L2", "--jobs", 2, "--out", tmp_path))
    for name in ("junit.xml", *(f"counterexamples/{p.name}" for p in (folder / "counterexamples").iterdir())):
        assert (tmp_path / name).read_bytes() == (folder / name).read_bytes(), name
    for name in ("report.html", "report.md"):
        one, two = (settled(name, (place / name).read_text(encoding="utf-8")) for place in (folder, tmp_path))
        assert one == two, name
    one, two = (json.loads((place / "report.json").read_text()) for place in (folder, tmp_path))
    assert one.pop("volatile") != two.pop("volatile")
    assert one == two


def test_kept_evidence_is_rendered_again(judged, tmp_path):
    folder, _ = judged
    text = expect(0, run("report", "--evidence", folder / KEPT, "--out", tmp_path)).stdout
    assert "judged: 1 of 30 claims" in text, text
    for name in FILES:
        assert (tmp_path / name).read_bytes() == (folder / name).read_bytes(), name


def test_evidence_is_judged_once(judged, monkeypatch, tmp_path):
    calls = []

    def counted(function):
        return lambda *arguments: calls.append(function.__name__) or function(*arguments)

    for function in (baseline.judge_all, baseline.assess, baseline.read_baseline):
        monkeypatch.setattr(baseline, function.__name__, counted(function))
    expect(0, run("report", "--evidence", judged[0] / KEPT, "--out", tmp_path))
    assert sorted(calls) == ["assess", "judge_all", "read_baseline"], calls


@pytest.mark.parametrize(
    ("content", "needed"),
    [
        ("{", "JSONDecodeError"),
        ("[]", "TypeError"),
        ("{}", "KeyError"),
        ('{"evidence": 3, "records": [], "interrupted": false}', "TypeError"),
        ("\udcff", "UnicodeDecodeError"),
    ],
)
def test_what_is_no_evidence_is_misuse(content, needed, tmp_path):
    (tmp_path / "kept.json").write_bytes(content.encode("utf-8", "surrogateescape"))
    result = expect(2, run("report", "--evidence", tmp_path / "kept.json", "--out", tmp_path / "new"))
    assert needed in squeezed(result.stderr), result.stderr
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize(
    ("changes", "needed"),
    [
        ({"settings": {"claims": ["Z9"]}}, "the ledger has no claim Z9"),
        ({"settings": {"claims": ["L2"]}}, "command"),
        ({"series": {"cost": {"step6": {}}}}, "series 'cost'"),
    ],
)
def test_evidence_that_cannot_be_rendered_is_misuse(judged, changes, needed, tmp_path):
    kept = findings(judged[0])
    kept["evidence"] |= {"volatile": {}} | changes
    if "series" in changes:
        kept["evidence"]["settings"]["claims"] = ["C1"]
    (tmp_path / "kept.json").write_text(json.dumps(kept), encoding="utf-8")
    result = expect(2, run("report", "--evidence", tmp_path / "kept.json", "--out", tmp_path / "new"))
    assert needed in squeezed(result.stderr), result.stderr
    assert "--evidence" in result.stderr, result.stderr
    assert not (tmp_path / "new").exists()


def test_missing_evidence_and_both_sources_are_misuse(judged, tmp_path):
    expect(2, run("report", "--evidence", tmp_path / "none.json", "--out", tmp_path / "new"))
    both = run("report", "--evidence", judged[0] / KEPT, "--claim", "L2", "--out", tmp_path / "new")
    assert "cannot be combined" in squeezed(expect(2, both).stderr), both.stderr
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize("command", ["run", "report"])
def test_a_place_that_cannot_be_written_is_misuse_before_the_work(command, explored, tmp_path):
    (tmp_path / "file").write_text("mine")
    (tmp_path / "folder" / "report.html").mkdir(parents=True)
    for out in (tmp_path / "file", tmp_path / "file" / "below", tmp_path / "folder"):
        result = expect(2, run(command, "--claim", "L2", "--jobs", 1, "--out", out))
        assert "--out" in result.stderr, result.stderr
    assert explored == []
    assert (tmp_path / "file").read_text() == "mine"
    assert not [path for path in (tmp_path / "folder").rglob("*") if path.is_file()]


@pytest.mark.parametrize(
    ("command", "work"),
    [
        (["faults", "--json"], "verification.faults.table.planted"),
        (["faults", "--markdown"], "verification.faults.table.planted"),
        (["bench", "--json"], "verification.bench.run.run"),
        (["bench", "--growth", "--plot"], "verification.bench.run.run"),
    ],
)
def test_a_file_that_cannot_be_written_is_misuse_before_the_work(command, work, monkeypatch, tmp_path):
    begun = []
    monkeypatch.setattr(work, lambda *args, **options: begun.append(args))
    result = expect(2, run(*command, tmp_path / "none" / "table.svg"))
    assert command[-1] in result.stderr, result.stderr
    assert "no such folder" in squeezed(result.stderr), result.stderr
    assert not begun


def test_what_cannot_be_drawn_ends_with_one_line_that_blames_no_option(monkeypatch, tmp_path):
    monkeypatch.setenv("MUJOCO_GL", "glfw")
    result = expect(2, run("experiments", "--out", tmp_path / "new"))
    assert result.stderr.startswith("error: MUJOCO_GL must be egl, osmesa or unset; got 'glfw'."), (
        result.stderr
    )
    assert len(result.stderr.splitlines()) == 1
    assert not list(tmp_path.iterdir())
    monkeypatch.setattr("convexperc.simulation.backends.choose_backend", lambda: "egl")
    result = expect(2, run("experiments", "--out", tmp_path / "new"))
    assert result.stderr.splitlines()[-1].startswith("error: MUJOCO_GL must be"), result.stderr


@pytest.mark.parametrize(
    "arguments",
    [
        "report --experiments report.md --out .",
        "report --experiments record.json --evidence junit.xml --out ../here",
        "report --evidence counterexamples/kept.json --out .",
        "run --experiments .journal/quick-0.evidence.json --out .",
        "faults --json a --markdown ./a",
        "bench --growth --json a.svg --plot a.svg",
        "replay record.svg --plot link.svg",
        "campaign --resume begun.json --json .journal/begun.json.jsonl",
        "experiments --photos photos --out photos/new --no-simulate",
        "experiments --simulation photos --case-study photos --out new --cache photos/car",
        "experiments --photos new/sheets --out new --no-simulate",
    ],
)
def test_an_output_is_never_an_input_or_another_output(arguments, tmp_path, monkeypatch):
    folder = tmp_path / "here"
    for name in ("counterexamples", ".journal", "photos/car", "new/sheets"):
        (folder / name).mkdir(parents=True)
    for name in ("report.md", "junit.xml", "counterexamples/kept.json", ".journal/quick-0.evidence.json"):
        (folder / name).write_text("mine")
    (folder / "record.json").write_bytes(PACKAGED.read_bytes())
    record = next(each for each in catalogue() if each.id == "rise-absolute-jacobi")
    write_json(folder / "record.svg", record.as_json())
    (folder / "link.svg").symlink_to("record.svg")
    monkeypatch.chdir(folder)
    if "campaign" in arguments:
        expect(0, run("campaign", "--random", 1, "--degenerate", 1, "--json", "begun.json"))
    before = {path: path.is_dir() or path.read_bytes() for path in tmp_path.rglob("*")}
    result = expect(2, run(*arguments.split()))
    text = squeezed(result.stderr)
    assert re.search("must (be another file than|neither contain|not lie in)", text), result.stderr
    assert result.stdout == ""
    assert {path: path.is_dir() or path.read_bytes() for path in tmp_path.rglob("*")} == before


def test_a_report_is_not_half_written(judged, tmp_path):
    (tmp_path / "SHA256SUMS").mkdir()
    result = expect(2, run("report", "--evidence", judged[0] / KEPT, "--out", tmp_path))
    assert "SHA256SUMS" in squeezed(result.stderr), result.stderr
    assert not [path for path in tmp_path.rglob("*") if path.is_file()]


def test_an_interrupted_search_goes_on_where_it_was(judged, explored, tmp_path):
    whole, _ = judged
    command = ("report", "--claim", "L2", "--jobs", 1, "--out", tmp_path)
    options = verification.run.stages.Options(PROFILES["quick"], claims=("L2",))
    sizes = [shard.problems for shard in plan(options.checks, options.profile)]
    explored.limit = 5
    text = squeezed(expect(3, run(*command)).stdout)
    assert f"interrupted after {sum(sizes[:5])} of {sum(sizes)} problems: nothing is judged" in text, text
    assert {path.name for path in tmp_path.iterdir()} == {".journal"}, "no report of half a run"
    half = interrupted_evidence(tmp_path / KEPT)
    cases = sum(count[outcome] for count in half["counts"] for outcome in Outcome)
    assert cases == 2 * sum(sizes[:5]), "a case for each part that was selected"
    assert "nothing is judged" in expect(3, run("report", "--evidence", tmp_path / KEPT)).stdout
    begun = list(explored)
    explored.clear()
    explored.limit = 10**9
    expect(0, run(*command))
    assert len(begun) == 5
    assert not set(begun) & set(explored), "nothing is done twice"
    assert sum(key.endswith("|") for key in (*begun, *explored)) == len(sizes)
    assert findings(tmp_path) == findings(whole)


def interrupted_evidence(file):
    data = json.loads(file.read_text(encoding="utf-8"))
    assert data["interrupted"]
    return data["evidence"]


def test_an_interruption_after_the_search_loses_nothing_of_it(explored, monkeypatch, tmp_path):
    def broken_off():
        raise KeyboardInterrupt

    command = ("run", "--claim", "L1", "--jobs", 1, "--out", tmp_path)
    with monkeypatch.context() as patched:
        patched.setattr(verification.run.stages, "all_arguments", broken_off)
        expect(3, run(*command))
    assert explored
    explored.clear()
    expect(0, run(*command))
    assert explored == []


def test_two_reports_are_compared(judged, tmp_path):
    folder, _ = judged
    report = folder / "report.json"
    same = expect(0, run("report", "diff", report, report))
    assert same.stdout.strip() == "All verdicts are equal.", same.stdout
    kept = findings(folder)
    kept["evidence"] |= {"volatile": {}, "arguments": []}
    (tmp_path / "kept.json").write_text(json.dumps(kept), encoding="utf-8")
    expect(1, run("report", "--evidence", tmp_path / "kept.json", "--out", tmp_path))
    other = expect(1, run("report", "diff", report, tmp_path / "report.json"))
    assert "L2/elementwise: holds -> supported" in other.stdout, other.stdout
    bad = expect(2, run("report", "diff", report, tmp_path / "kept.json"))
    assert "schema" in squeezed(bad.stderr), bad.stderr
    expect(2, run("report", "diff", report, tmp_path / "none.json"))


def test_a_record_of_the_catalogue_is_replayed():
    text = expect(0, run("replay", "rise-printed-gauss-seidel")).stdout
    for needed in ("X = [1], o = [-1]", "confirmed: ", "57/49", "rises"):
        assert needed in text, text


def test_a_record_that_the_search_found_is_replayed_from_the_report(judged):
    text = expect(0, run("replay", "found-l2-inequality", "--out", judged[0])).stdout
    assert "confirmed: " in text, text


def test_a_stale_record_is_told_by_the_exit_code(tmp_path):
    record = next(each for each in catalogue() if each.id == "rise-absolute-jacobi")
    mended = replace(record, id="mended", fields=dict(record.fields) | {"reading": "corrected"})
    write_json(tmp_path / "mended.json", mended.as_json())
    text = expect(1, run("replay", tmp_path / "mended.json")).stdout
    assert "stale: " in text, text
    (tmp_path / "counterexamples").mkdir()
    (tmp_path / "mended.json").rename(tmp_path / "counterexamples" / "mended.json")
    assert "stale: " in expect(1, run("replay", "mended", "--out", tmp_path)).stdout


def test_what_is_no_record_is_misuse(tmp_path):
    result = expect(2, run("replay", "no-such-record", "--out", tmp_path))
    assert "no record 'no-such-record'" in squeezed(result.stderr), result.stderr
    (tmp_path / "bad.json").write_text("{}")
    assert "must be an object" in squeezed(expect(2, run("replay", tmp_path / "bad.json")).stderr)


@pytest.mark.parametrize(("name", "head"), [("F.svg", b"<?xml"), ("F.png", b"\x89PNG")])
def test_a_replay_is_drawn(name, head, tmp_path):
    expect(0, run("replay", "locked-w-jacobi", "--plot", tmp_path / name))
    assert (tmp_path / name).read_bytes().startswith(head)


@pytest.mark.parametrize("name", ["F.pdf", "none/F.svg"])
def test_a_drawing_that_cannot_be_written_is_misuse_before_the_work(name, tmp_path):
    result = expect(2, run("replay", "locked-w-jacobi", "--plot", tmp_path / name))
    assert "--plot" in result.stderr, result.stderr
    assert "confirmed" not in result.stdout, result.stdout
    assert not list(tmp_path.iterdir())
