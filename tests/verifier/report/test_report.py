"""The report: the same bytes for the same evidence, a page that needs nothing, hostile strings harmless."""

import hashlib
import json
import re
import subprocess
from fractions import Fraction
from html.parser import HTMLParser
from xml.etree import ElementTree

import jsonschema
import pytest
from made_up import MACHINE, SETTINGS, argument, evidence, judged, refutation, series, verdicts

from convexperc.errors import FileFormatError, InputError
from verification import provenance as environment
from verification.checks.catalogue import CHECKS
from verification.checks.descent import ITERATIONS
from verification.counterexamples.files import catalogue
from verification.counterexamples.given import given, in_words
from verification.exact.problem import ExactProblem
from verification.ledger.claims import CLAIMS, PARTS
from verification.ledger.evidence import Argument, Checker, Count, Refutation, Step, Verdict
from verification.problems.families import FAMILIES
from verification.provenance import record_digest
from verification.report import sentences, words
from verification.report.build import build
from verification.report.contents import Report
from verification.report.diff import diff, read_report
from verification.report.junit import junit
from verification.report.markdown import VOLATILE
from verification.report.plain import plain
from verification.report.plots import DRAWN, plot
from verification.report.schema import report_schema
from verification.report.write import SUMS, files, store
from verification.search.profiles import PROFILES

RECORDS = {"d1-printed.json": b"{}\n", "l2-inequality.json": b"[]\n"}
EVIL = "<script src='http://evil'>alert(1)</script> | **x** `y` &amp; \x00 {{ 7*7 }} \"' ]]> --> $x$"
TIMES = {"step6": {"x": [8, 16], "y": [1e-5, 8e-5], "slope": 3.0}}


def rendered(made=None, baseline=None, records=RECORDS):
    return files(judged(made, baseline), records)


def told(made=None, baseline=None) -> Report:
    return build(judged(made, baseline), RECORDS)


def record(made=None):
    """The data of report.json."""
    return plain(told(made))


@pytest.fixture(scope="module")
def good():
    return rendered()


@pytest.mark.usefixtures("drawn_anew")
def test_the_same_evidence_gives_the_same_bytes(good):
    assert rendered() == good


def test_two_machines_differ_in_one_block_alone(good):
    other = rendered(evidence(volatile={"date": "later", "commit": "f00", "times": TIMES}))
    for name, mark in (("report.html", '<section id="volatile">'), ("report.md", VOLATILE)):
        before, after = (found[name].decode().partition(mark) for found in (good, other))
        assert before[1] == after[1] == mark
        assert before[0] == after[0], name
        assert before[2] != after[2], name
    mine, theirs = (json.loads(found["report.json"]) for found in (good, other))
    assert [key for key in mine if mine[key] != theirs[key]] == ["volatile"]
    same = set(good) - {"report.html", "report.md", "report.json"}
    assert all(good[name] == other[name] for name in same), same


def test_the_digest_moves_with_every_finding_and_with_nothing_volatile():
    found = record()
    assert found["digest"] == record_digest(found) == record(evidence(volatile={}))["digest"]
    assert json.loads(told().file) == found
    changed = evidence(settings=SETTINGS | {"seed": 1}), evidence(missing=["x"]), evidence(series={})
    digests = {record(made)["digest"] for made in changed} | {found["digest"]}
    assert len(digests) == 4, digests


class Page(HTMLParser):
    """What the tests need of a page."""

    VOID = ("meta", "br", "img")

    def __init__(self, text):
        super().__init__()
        self.open, self.ids, self.links, self.levels, self.text = [], [], [], [], ""
        self.tags = set()
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        named = dict(attrs)
        self.tags.add(tag)
        if tag not in self.VOID:
            self.open.append(tag)
        if "id" in named:
            self.ids.append(named["id"])
        if "href" in named:
            self.links.append(named["href"])
        if re.fullmatch("h[1-6]", tag):
            self.levels.append(int(tag[1]))
        assert not any(name.startswith("on") for name in named), (tag, named)
        inside = (
            tag == "img" and named["src"].startswith("data:image/jpeg;base64,") and len(named["alt"]) > 20
        )
        assert "src" not in named or inside, (tag, named)
        assert tag != "svg" or len(named["aria-label"]) > 40, named

    def handle_startendtag(self, tag, attrs):
        self.handle_starttag(tag, attrs)
        if tag not in self.VOID:
            self.open.pop()

    def handle_endtag(self, tag):
        assert self.open.pop() == tag, (tag, self.getpos())

    def handle_data(self, data):
        self.text += data


@pytest.mark.parametrize(
    "made", [evidence(volatile=MACHINE | {"times": TIMES}), evidence(series={}, missing=["a"])]
)
def test_the_page_is_well_formed_and_needs_nothing_else(made):
    text = rendered(made)["report.html"].decode()
    page = Page(text)
    assert page.open == []
    assert len(page.ids) == len(set(page.ids)), [each for each in page.ids if page.ids.count(each) > 1]
    assert {link.removeprefix("#") for link in page.links} <= set(page.ids)
    assert all(link.startswith("#") for link in page.links)
    assert {each.replace("/", "-") for each in [*CLAIMS, *PARTS]} <= set(page.ids)
    assert not page.tags & {"script", "link", "iframe", "img", "object", "embed", "image", "base", "form"}
    assert all(target.startswith("#") for target in re.findall(r"url\(([^)]*)", text))
    assert "@import" not in text
    assert "http" not in text
    steps = list(zip([0, *page.levels], page.levels, strict=False))
    assert all(after <= before + 1 for before, after in steps), steps
    assert len(text.encode()) < 1_000_000
    found = set(re.findall(r'\bhref="#([^"]*)"|url\(#([^)]*)\)', text))
    assert {a or b for a, b in found} <= set(page.ids)


def test_what_was_not_run_is_said_and_never_an_empty_picture():
    none = rendered(evidence(series={}))
    assert "<svg" not in none["report.html"].decode()
    for name in ("report.html", "report.md"):
        assert none[name].decode().count("not run in this profile") >= 5, name
    some = rendered(evidence(series={"cost": series()["cost"]}))["report.html"].decode()
    assert some.count("<svg") == 1


def test_a_report_says_what_it_found(good):
    page, text = Page(good["report.html"].decode()).text, good["report.md"].decode()
    squeezed = " ".join(page.split())
    for claim in CLAIMS.values():
        assert claim.statement in squeezed, claim.id
        assert all(part.statement in squeezed for part in claim.parts), claim.id
    for needed in (
        "1,317 failed",
        "Worst: 1e-05, in family orthogonal target",
        "X = lambda1 = 1, o = -1, lambda2 = 4, lambda3 = 0: F goes 4, 9, 9; F* = 1",
        "python -m verification replay t1a-printed-gauss-seidel",
        "python -m verification report --profile quick --seed 0",
        "z3 and cvc5, checked: 2*a*b <= a**2 + b**2; where a: ||x||",
        "30 claims in 93 formal parts",
        "Every verdict is the one that the baseline expects",
        "numpy2.0.0",
        "7/250",
    ):
        assert needed in squeezed.replace("versions: numpy ", "numpy"), needed
    assert "python -m verification replay t1a-printed-gauss-seidel" in text
    order = [
        text.index(f"\n## {title}")
        for title in ("Verdicts", "How", "The claims", "Known", "Evidence", "Env", "What")
    ]
    assert order == sorted(order)


@pytest.mark.parametrize(
    ("changes", "code", "message"),
    [
        ({"missing": ["family one_view"]}, 3, "missing: family one_view"),
        ({"arguments": []}, 1, "D1/corrected: supported, the baseline says holds"),
    ],
)
def test_a_run_that_is_not_as_expected_says_so_first(changes, code, message):
    made = evidence(series={}, **changes)
    found = rendered(made, verdicts(evidence()))
    assert json.loads(found["report.json"])["outcome"]["code"] == code
    page = Page(found["report.html"].decode()).text
    assert message in page.partition("1. Verdicts")[0]
    assert message.replace("_", r"\_") in found["report.md"].decode().partition("## Verdicts")[0]


def test_the_file_for_machines_follows_its_schema():
    schema = report_schema()
    jsonschema.Draft202012Validator.check_schema(schema)
    validator = jsonschema.Draft202012Validator(schema)
    found = record()
    validator.validate(found)
    assert found["claims"][0]["parts"][0]["cases"]["held"] == 8500
    worst = {part["key"]: part["cases"]["worst"] for claim in found["claims"] for part in claim["parts"]}
    assert worst["N1/w_system"] == "inf"
    for path, value in {("digest",): "0", ("claims", 0, "verdict"): "true", ("outcome", "code"): 2}.items():
        wrong = json.loads(json.dumps(found))
        place = wrong
        for step in path[:-1]:
            place = place[step]
        place[path[-1]] = value
        assert not validator.is_valid(wrong), path
    del found["volatile"]
    assert not validator.is_valid(found)


def test_junit_has_a_case_a_part_and_fails_where_the_verdict_is_another():
    made = evidence(missing=["family one_view"])
    root = ElementTree.fromstring(junit(told(made)))
    cases = {case.get("name"): case for case in root.iter("testcase")}
    assert set(PARTS) <= set(cases)
    assert not [key for key, case in cases.items() if case.find("skipped") is not None]
    failures = [case for case in cases.values() if case.find("failure") is not None]
    assert [case.get("name") for case in failures] == ["nothing that is required is missing or open"]
    assert (root.get("tests"), root.get("failures"), root.get("skipped")) == (str(len(PARTS) + 4), "1", "0")
    without = ElementTree.fromstring(junit(told(evidence(surveys=[]))))
    surveyed = {key for key, part in PARTS.items() if part.rule is not None}
    assert {
        case.get("name") for case in without.iter("testcase") if case.find("skipped") is not None
    } == surveyed
    other = verdicts(made) | {"F1/convex": Verdict.REFUTED}
    failed = ElementTree.fromstring(junit(told(made, other))).findall(".//failure")
    assert failed[0].get("message") == "holds; the baseline says refuted"
    assert {case.get("time") for case in root.iter("testcase")} == {"0"}


def test_hostile_strings_stay_text():
    step = Step(EVIL, Checker.SOLVERS, True, EVIL, EVIL)
    found = rendered(
        evidence(
            settings=SETTINGS | {"command": EVIL, "profile": EVIL, EVIL: {EVIL: EVIL}},
            counts=[Count("F2/conic", EVIL, held=3, failed=1)],
            arguments=[Argument("F1/convex", EVIL, EVIL, (step,))],
            refutations=[Refutation(EVIL, "D1/printed", True, EVIL, EVIL, EVIL)],
            series={"counterexample": {"title": EVIL, "F_star": [0, 1], "runs": {EVIL: [1, 2]}}},
            missing=[EVIL],
            volatile={EVIL: EVIL, "times": {EVIL.replace("\x00", ""): TIMES["step6"]}},
        )
    )
    page = Page(found["report.html"].decode())
    assert "script" not in page.tags
    assert "alert(1)" in page.text
    assert "49" not in re.findall(r"\{\{ 7\*7 \}\}|\b49\b", page.text)
    outside = re.sub(r"(?<!`)(`+)(?!`).+?(?<!`)\1(?!`)", "", found["report.md"].decode())
    told = [line for line in outside.splitlines() if "<script" in line]
    assert len(told) == 1, told
    assert told[0].startswith("    <script"), "only the command, which is indented code"
    assert "<script" not in found["junit.xml"].decode()
    root = ElementTree.fromstring(found["junit.xml"])
    assert any("alert(1)" in (case.text or "") for case in root.iter("failure"))
    table = next(line for line in found["report.md"].decode().splitlines() if line.startswith("| F1 "))
    assert len(re.findall(r"(?<!\\)\|", table)) == 5, table


def test_a_drawing_is_the_same_each_time_and_fits_beside_others():
    data = series() | {"times": TIMES}
    drawn = {name: plot(name, data[name], f"label of {name}") for name in DRAWN}
    assert drawn == {name: plot(name, data[name], f"label of {name}") for name in DRAWN}
    ids = [each for svg in drawn.values() for each in re.findall(r'\bid="([^"]*)"', svg)]
    assert len(ids) == len(set(ids))
    assert "mathdefault" not in "".join(drawn.values())
    for name, svg in drawn.items():
        assert len(svg) < 80_000, (name, len(svg))
        ElementTree.fromstring(svg)


WRONG = {
    "counterexample": {"F_star": [1.0], "runs": {}},
    "distance": {"edges": [1, 2, 3], "counts": {"a": [1]}, "undecided": {"a": 0}},
    "rate": {"curves": {"a": [1.0]}, "reference": "another"},
    "cost": {"step6": {"x": [1, 2], "y": [1], "slope": 1}},
    "clarabel": {"scales": [1.0], "per_scale": [1]},
}


@pytest.mark.parametrize("name", WRONG)
def test_a_series_of_another_shape_is_refused_by_name(name):
    with pytest.raises(InputError, match=f"series '{name}'"):
        rendered(evidence(series={name: WRONG[name]}))


@pytest.mark.parametrize("name", ["command", "profile", "seed", "versions"])
def test_a_run_that_nobody_could_repeat_is_refused(name):
    settings = {key: value for key, value in SETTINGS.items() if key != name}
    with pytest.raises(InputError, match=name):
        told(evidence(settings=settings))


def test_the_files_are_whole_and_their_sums_right(good, tmp_path):
    folder = tmp_path / "new" / "report"
    store(good, folder)
    lines = (folder / SUMS).read_text().splitlines()
    names = sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())
    assert names == sorted([*good, SUMS]) == sorted([*(line[66:] for line in lines), SUMS])
    for line in lines:
        assert hashlib.sha256((folder / line[66:]).read_bytes()).hexdigest() == line[:64], line
    mine = folder / "counterexamples" / "mine.json"
    mine.write_text("{}")
    store({name: data for name, data in good.items() if "l2-inequality" not in name}, folder)
    kept = sorted(path.name for path in (folder / "counterexamples").iterdir())
    assert kept == ["d1-printed.json", "mine.json"]


def test_nothing_is_written_where_something_is_wrong(good, tmp_path):
    for name in ("../x.json", "a/b.json", "X.json", ".json", "x.txt"):
        with pytest.raises(InputError, match="records"):
            rendered(records={name: b""})
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="must be a folder"):
        store(good, tmp_path / "file")


def test_equal_reports_do_not_differ(tmp_path):
    path = tmp_path / "report.json"
    path.write_bytes(told().file)
    found = diff(read_report(path), record(evidence(volatile={})))
    assert (found.code, found.text) == (0, "All verdicts are equal.")


def test_a_difference_is_named():
    changed = evidence(
        settings=SETTINGS | {"seed": 1, "versions": {"python": "3.11.0", "numpy": "2.1.0"}},
        counts=[count for count in evidence().counts if (count.part, count.family) != ("F2/conic", "random")],
        arguments=[argument("F1/convex")],
        refutations=[
            refutation("D1/printed"),
            refutation("A1/objective"),
            refutation("L2/inequality", False),
        ],
    )
    found = diff(record(), record(changed))
    assert found.code == 1
    assert "D1/corrected: holds -> supported" in found.verdicts
    assert "A1: supported -> refuted" in found.verdicts
    assert found.counts == ("F2/conic: held 8,500 -> 8,250",)
    assert "A1/objective: a1-objective appeared" in found.counterexamples
    assert "L2/inequality: l2-inequality disappeared" in found.counterexamples
    assert found.settings == (
        "seed: 0 -> 1",
        "versions.numpy: 2.0.0 -> 2.1.0",
        "versions.clarabel: 0.11.1 -> absent",
    )
    assert found.text.startswith("Verdicts:\n  F1"), found.text
    counts = [Count("F2/conic", "random", held=1)]
    only = diff(record(), record(evidence(counts=[*evidence().counts, *counts])))
    assert (only.code, only.counts) == (0, ("F2/conic: held 8,500 -> 8,501",))


@pytest.mark.parametrize(
    ("content", "needed"),
    [
        ("{", "must be JSON"),
        ("[]", "'list'"),
        ('{"schema": "convexperc/bench/1"}', "convexperc/bench/1"),
        ('{"schema": "convexperc/report/1"}', "one of an older schema is to be made again"),
        ('{"schema": "convexperc/report/2", "digest": "0", "claims": []}', "changed after it was written"),
    ],
)
def test_what_is_no_report_is_refused(tmp_path, content, needed):
    path = tmp_path / "report.json"
    path.write_text(content, encoding="utf-8")
    with pytest.raises(FileFormatError) as caught:
        read_report(path)
    assert needed in str(caught.value), caught.value
    with pytest.raises(FileFormatError, match="No such file"):
        read_report(tmp_path / "none.json")


def test_the_environment_names_versions_and_the_machine(tmp_path):
    found = environment.versions()
    assert set(environment.DECIDING) < set(found)
    assert found["numpy"].startswith("2."), found
    machine = environment.machine()
    assert set(machine) == {"date", "commit", "system", "processor", "blas", "blas kernel"}
    assert all(isinstance(value, str) and value for value in machine.values()), machine
    assert environment.processor(tmp_path / "none") != ""
    (tmp_path / "cpuinfo").write_text("processor : 0\nmodel name\t: An Abacus @ 1 Hz\n")
    assert environment.processor(tmp_path / "cpuinfo") == "An Abacus @ 1 Hz"


def test_the_commit_is_that_of_the_project_and_of_no_other_checkout(tmp_path):
    assert environment.commit(tmp_path) == "not a checkout"
    git = [
        "git",
        "-C",
        str(tmp_path),
        "-c",
        "user.name=a",
        "-c",
        "user.email=a@b",
        "-c",
        "commit.gpgsign=false",
    ]
    for command in (["init", "-q"], ["commit", "-q", "--allow-empty", "-m", "x"]):
        subprocess.run([*git, *command], check=True)
    clean = environment.commit(tmp_path)
    assert re.fullmatch("[0-9a-f]{40}", clean), clean
    for folder in ("reports", "new"):
        assert environment.commit(tmp_path) == clean, "what is generated there is no change of the code"
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "file").write_text("")
    assert environment.commit(tmp_path) == f"{clean}, with changes"
    assert environment.commit(tmp_path / "new") == "not a checkout"


def test_a_partial_report_speaks_of_its_claims_alone():
    made = evidence(settings=SETTINGS | {"claims": ["T1a", "L2"]}, series={})
    content = rendered(made)
    found = json.loads(content["report.json"])
    assert [claim["id"] for claim in found["claims"]] == ["L2", "T1a"]
    assert set(found["unjudged"]) == set(CLAIMS) - {"L2", "T1a"}
    assert found["outcome"]["code"] == 0, found["outcome"]
    page = Page(content["report.html"].decode())
    assert {link.removeprefix("#") for link in page.links} <= set(page.ids)
    told = "This is a partial report: 2 of the 30 claims of the ledger were selected and judged, L2 and T1a."
    for text in (page.text, content["report.md"].decode()):
        squeezed = " ".join(text.split())
        assert told in squeezed
        assert "which this run did not judge" in squeezed
        assert "Counted multiplications" not in squeezed, "a figure of a claim that was not selected"
    assert "2 claims in 14 formal parts" in page.text


def test_counts_by_variant_and_by_family_are_told(good):
    squeezed = " ".join(Page(good["report.html"].decode()).text.split())
    part = next(part for part in told().parts if part.key == "T1a/printed/gauss_seidel")
    rows = dict(sentences.by_kind(part))
    assert [rows[kind].failed for kind in ("random", "degenerate", "all")] == [0, 1317, 1317], rows
    assert rows["random"].held + rows["degenerate"].held == rows["all"].held == part.cases.held
    assert "printed GS refuted 250 1317/8250 1317/8500" in squeezed
    assert f"looked at {500 * len(FAMILIES):,} problems of {len(FAMILIES)} families" in squeezed
    rows = sentences.coverage(told(evidence(series={"coverage": {"random": 1234}})))
    assert [row.family for row in rows] == list(FAMILIES)
    assert [row.problems for row in rows[:2]] == [1234, None]
    assert sum(row.cases.held for row in rows) == sum(count.held for count in evidence().counts)


def test_the_worst_case_is_named_with_its_family_and_unbounded_where_it_has_no_number():
    counts = [Count("F2/conic", "random", 3, worst=2e-9), Count("F2/conic", "one_view", 2, worst=1e-3)]
    for more, expected in (
        ([], "Worst: 0.001, in family one view (relative gap of its point)."),
        (
            [Count("F2/conic", "one_view", 1, worst=1e300)],
            "Worst: unbounded (relative gap of its point), as F*",
        ),
    ):
        part = next(each for each in told(evidence(counts=counts + more)).parts if each.key == "F2/conic")
        assert sentences.worst(part).startswith(expected), sentences.worst(part)
        assert part.families["one_view"].held == 2 + len(more), part.families


def test_every_refuted_stated_part_shows_its_first_counterexample():
    found = [
        refutation("N1/u_system", name="b"),
        refutation("N1/w_system", False, name="stale"),
        refutation("N1/w_system", name="a"),
    ]
    claim = next(claim for claim in told(evidence(refutations=found)).claims if claim.id == "N1")
    shown = [(key, each.id) for key, each in sentences.examples(claim)]
    assert shown == [("N1/w_system", "a"), ("N1/u_system", "b")]


def test_the_limitations_fit_the_profiles_and_the_checks():
    text = " ".join(words.LIMITATIONS)
    assert "at most 4 views and 8 features" in text
    assert {check.largest for check in CHECKS} <= {(3, 6), (4, 8)}
    assert f"limit of {ITERATIONS} iterations" in text
    assert f"limit of {ITERATIONS} iterations" in CLAIMS["T1b"].method
    for profile in PROFILES.values():
        assert profile.name in text, profile
        assert str(profile.problems) in text, profile
    assert not PROFILES["quick"].hunts
    assert PROFILES["ci"].hunts
    assert PROFILES["full"].hunts


def test_the_corrected_statements_of_the_ledger_exist():
    named = {claim.id: claim.repaired_by for claim in CLAIMS.values() if claim.repaired_by}
    assert set(named) == {"T1a", "T1b", "S1"}
    assert all(key in PARTS for keys in named.values() for key in keys)


def test_what_a_counterexample_is_about_is_exact():
    told = {each.id: given(each) for each in catalogue()}
    assert told["rise-printed-gauss-seidel"] == (
        "X = [1], o = [-1], lambda1 = 1, lambda2 = 1, lambda3 = 0; printed update, Gauss-Seidel, from the"
        " paper's start"
    )
    assert told["l1-analogue"] == "v = (1, 0); t = (1, 1)"
    assert "eps = 1/4000000" in told["limit-smoothed-default-eps"]
    assert told["tie-permuted-templates"].endswith("templates o = (1, 0) and o = (0, 1)")
    large = ExactProblem.small([[1] * 11] * 3, [1] * 11, [11], 1, 1, 1)
    assert in_words(large) == "n = 3, d = 11, m = 1, lambda1 = 1, lambda2 = 1, lambda3 = 1"
    third, tenth = "12345678901/33333333333", Fraction(0.1)
    assert in_words(ExactProblem.small([[third]], [tenth], [1], 0, 0, 0)).startswith(
        f"X = [{third}], o = [0.1],"
    )
